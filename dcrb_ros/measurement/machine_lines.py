"""Lines of a machine: multiples of the shaft, and mains and slots of the motor of a laboratory rig."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.housing_priors import HousingName
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Span
from dcrb_ros.schema.arrays import Floats

ORDERS = np.arange(1.0, 7.0)
"""Multiples of the shaft [-]."""
MAINS = np.array([50.0, 100.0])
"""Mains frequency and its double [Hz]."""
SLOTS = (800.0, 8000.0)
"""Range of the middle line of the motor's slots [Hz]."""
NEIGHBOURS = 100.0 * np.arange(-2.0, 3.0)
"""Distances of the slot lines from the middle one [Hz], multiples of twice the mains frequency."""
SHAFT_AND_MAINS, SLOT, DOUBLE_SLOT = 0.4, 0.6, 0.2
"""Scales of the Rayleigh distributions of the amplitudes, relative [-]."""


class MachineLines:
    """Lines of random amplitude, phase and slot frequency, whose mean square over both axes is 1 at the reference speed.

    An axle box has only multiples of the shaft; its gears and motor are parameters of the group background. The amplitude of the multiples
    grows with the square of the speed.
    """

    def __init__(self, housing: HousingName, seed: int) -> None:
        random = random_stream(seed, "machine lines")
        slots = random.uniform(*SLOTS) + NEIGHBOURS
        fixed = np.concatenate([MAINS, slots, 2.0 * slots[1:4]]) if housing == "laboratory" else np.zeros(0)
        scales = np.array([SHAFT_AND_MAINS] * 8 + [SLOT] * 5 + [DOUBLE_SLOT] * 3)
        amplitudes = scales * random.rayleigh(size=(2, 16)) * random.choice([-1.0, 1.0], (2, 16))
        self._phases = 2.0 * math.pi * random.random(16)
        amplitudes = amplitudes[:, : len(ORDERS) + len(fixed)]
        self._amplitudes = amplitudes / math.sqrt(0.25 * float(np.sum(amplitudes**2)))
        self._frequencies = fixed
        """Lines of constant frequency [Hz]."""

    def at(self, span: Span, ratio: Floats, rate: float) -> Floats:
        """Return the lines at every tick, shape (ticks, 2); ``ratio``, shape (ticks,), is the speed over the reference speed [-]."""
        lines = np.zeros((len(ratio), 2))
        ticks = np.arange(span.first, span.first + len(ratio))
        shaft = ratio**2
        for number, phase in enumerate(self._phases[: self._amplitudes.shape[1]]):
            if number < len(ORDERS):
                line = shaft * np.cos(ORDERS[number] * span.angle[1:] + phase)
            else:
                frequency = self._frequencies[number - len(ORDERS)]
                line = np.cos(2.0 * math.pi * np.mod(frequency * ticks / rate, 1.0) + phase)
            for axis in (0, 1):
                lines[:, axis] += self._amplitudes[axis, number] * line
        return lines
