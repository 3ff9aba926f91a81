"""Pulses on the axle box at exact times, whatever the length of the blocks in which the time steps are processed."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.schema.arrays import Floats


class Pulses:
    """Pulses with the shape of a Hann window: zero at both ends, the peak in the middle."""

    def __init__(self, duration: float, rate: float) -> None:
        """Prepare for pulses of a ``duration`` [s] at a step rate [Hz]."""
        self._length = duration * rate
        self._present: list[tuple[float, float]] = []

    def begin(self, at: float, peak: float) -> None:
        """Start a pulse with a ``peak`` [m/s^2] at a time in steps, which need not be whole and not be before that of an earlier call."""
        self._present.append((at, peak))

    def process(self, first: int, count: int) -> Floats:
        """Return the sum of the pulses at ``count`` steps from step ``first`` on, shape (count,) [m/s^2]."""
        total = np.zeros(count)
        for at, peak in self._present:
            begin, end = max(first, math.ceil(at)), min(first + count, math.floor(at + self._length) + 1)
            if begin < end:
                share = (np.arange(begin, end) - at) / self._length
                total[begin - first : end - first] += 0.5 * peak * (1.0 - np.cos(2.0 * math.pi * share))
        self._present = [(at, peak) for at, peak in self._present if at + self._length >= first + count]
        return total


class Passings:
    """A pulse each time the shaft has turned by a ``period`` [rad] in either direction, ``phase`` periods after angle zero."""

    def __init__(self, period: float, phase: float, pulses: Pulses) -> None:
        self._period, self._phase, self._pulses = period, phase, pulses

    def process(self, first: int, angle: Floats, peak: Floats) -> Floats:
        """Return the sum of the pulses from step ``first`` on, shape (steps,) [m/s^2].

        ``angle`` is the shaft angle at the step before ``first`` and at every step, shape (steps + 1,) [rad]; ``peak`` the peak of a pulse
        that starts at a step, shape (steps,) [m/s^2].
        """
        position = angle / self._period - self._phase
        cell = np.floor(position)
        for i in np.flatnonzero(cell[1:] != cell[:-1]):
            edge = max(cell[i], cell[i + 1])
            between = (edge - position[i]) / (position[i + 1] - position[i])
            self._pulses.begin(first + i - 1 + float(between), float(peak[i]))
        return self._pulses.process(first, len(peak))
