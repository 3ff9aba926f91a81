"""Mains hum that the cable picks up."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

SECOND, THIRD = 0.5, 0.33
"""Amplitudes of the second and third harmonic relative to the fundamental [-]."""


class HumParameters(Group):
    """Level and frequency of the hum."""

    hum_level: float = quantity(0.0, "m/s^2", "Mains hum in the cable: amplitude of its fundamental", 0.0, 1e3, run_time=True)
    hum_frequency: float = quantity(50.0, "Hz", "Mains frequency", 10.0, 500.0, remedy="50, 60 or 16.7 Hz")


class MainsHum(Stage):
    """Adds the mains frequency and two harmonics, alike in X and Y."""

    group, parameters = "background", HumParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._frequency, self._level = setup.parameters[HumParameters].hum_frequency, 0.0
        self._phase = 2.0 * math.pi * float(random_stream(setup.seed, "hum").random())

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        self._level = parameters[HumParameters].hum_level

    @property
    def active(self) -> bool:
        return self._level > 0.0

    def process(self, acceleration: Floats, span: Span) -> Floats:
        samples = np.arange(span.first, span.first + len(acceleration))
        angle = np.mod(self._frequency * samples, self.rate) * (2.0 * math.pi / self.rate) + self._phase
        sine, cosine = np.sin(angle), np.cos(angle)
        second, third = 2.0 * sine * cosine, sine * (3.0 - 4.0 * sine**2)
        hum = self._level * (sine + SECOND * second + THIRD * third)
        after: Floats = acceleration.copy()
        for axis in (0, 1):
            after[:, axis] += hum
        return after
