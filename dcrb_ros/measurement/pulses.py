"""Short blows on the axle box at exact times, however the time is cut into stretches."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.runtime.arrays import Floats


class Pulses:
    """Pulses under way: each is half a period of a raised cosine, 0 at both ends and its peak in the middle."""

    def __init__(self, duration: float, rate: float) -> None:
        """Prepare for pulses of a ``duration`` [s] at a ``rate`` [Hz]."""
        self._length = duration * rate
        self._under_way: list[tuple[float, float]] = []

    def begin(self, at: float, peak: float) -> None:
        """Begin a pulse at a time in steps, which may lie between two, with a ``peak`` [m/s^2]; not before an earlier one."""
        self._under_way.append((at, peak))

    def feed(self, first: int, count: int) -> Floats:
        """Return their sum at ``count`` steps from step ``first`` on [m/s^2]."""
        total = np.zeros(count)
        for at, peak in self._under_way:
            begin, end = max(first, math.ceil(at)), min(first + count, math.floor(at + self._length) + 1)
            if begin < end:
                share = (np.arange(begin, end) - at) / self._length
                total[begin - first : end - first] += 0.5 * peak * (1.0 - np.cos(2.0 * math.pi * share))
        self._under_way = [(at, peak) for at, peak in self._under_way if at + self._length >= first + count]
        return total


class Passings:
    """Pulses each time the shaft has turned by a ``period`` [rad], forwards or backwards, ``phase`` periods after its zero."""

    def __init__(self, period: float, phase: float, pulses: Pulses) -> None:
        self._period, self._phase, self._pulses = period, phase, pulses

    def feed(self, first: int, turned: Floats, peak: Floats) -> Floats:
        """Return their sum [m/s^2]; ``turned`` is the shaft's angle at the step before ``first`` and the steps from there on [rad]."""
        place = turned / self._period - self._phase
        cell = np.floor(place)
        for i in np.flatnonzero(cell[1:] != cell[:-1]):
            edge = max(cell[i], cell[i + 1])
            between = (edge - place[i]) / (place[i + 1] - place[i])
            self._pulses.begin(first + i - 1 + float(between), float(peak[i]))
        return self._pulses.feed(first, len(peak))
