"""The times at which the teeth of a wheel on the shaft pass its pickup: the pulses of a tacho."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.schema.arrays import Floats, Integers

TOOTH = 0.5
"""Share of a tooth in the pitch [-]: as wide as the gap beside it."""


class ToothedWheel:
    """Finds the rising edges of a pickup whose signal is high where a tooth is in front of it.

    Tooth m covers the angles from 2 pi m / N to 2 pi (m + 1/2) / N. A shaft that turns forwards reaches it at the lower angle, one that
    turns backwards at the upper one, so that the pulses do not tell the direction. Between two time steps the angle is interpolated
    linearly. The sample clock also stamps the pulses, with its offset and without its jitter. The pulses are the same for any block size.
    """

    def __init__(self, pulses_per_turn: int, step_rate: int, clock_offset_ppm: float = 0.0) -> None:
        """Begin at time step 0, with ``step_rate`` time steps per second [Hz]."""
        self._pitches = pulses_per_turn / (2.0 * math.pi)
        self._step_ns = 1e9 / step_rate / (1.0 + 1e-6 * clock_offset_ppm)
        self._before = np.zeros(0)
        """Angle at the last time step, in pitches; empty before the first."""
        self._step = 0

    def pulses(self, angle: Floats) -> Integers:
        """Return the times of the pulses up to the last of the next time steps, shape (pulses,) [ns].

        ``angle`` is that of the shaft at each of these steps, shape (steps,) [rad]. From step to step there is one pulse at most.
        """
        position = np.concatenate([self._before, angle * self._pitches])
        begin, end, floor = position[:-1], position[1:], np.floor(position)
        passed = floor[1:] > floor[:-1]
        if not (end >= begin).all():  # the shaft turns backwards, if only for a moment
            after = np.ceil(position - TOOTH)
            passed |= after[1:] < after[:-1]
        at = np.flatnonzero(passed)
        before, now = begin[at], end[at]
        edge = np.where(floor[at + 1] > floor[at], floor[at + 1], np.ceil(now - TOOTH) + TOOTH)
        step = self._step - len(self._before) + at + (edge - before) / (now - before)
        self._before, self._step = position[-1:], self._step + len(angle)
        return np.asarray(np.rint(step * self._step_ns), np.int64)
