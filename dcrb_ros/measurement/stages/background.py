"""The background: acceleration of the axle box by wheel and track, and impacts that resemble those of a defect."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dcrb_ros.measurement.filters import Filter, above_step_rate, band_of_noise
from dcrb_ros.measurement.pulses import Passings, Pulses
from dcrb_ros.measurement.random_streams import PoissonTimes, random_stream
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

REFERENCE_SPEED = 20.0
"""Vehicle speed at which the levels of joints, flats and track noise are given [m/s], 72 km/h."""
JOINT_DURATION = 0.004
"""Duration of a rail joint's pulse [s]."""
FLAT_DURATION = 0.002
"""Duration of a wheel flat's pulse [s]."""
IMPACT_DURATION = 1e-4
"""Duration of a look-alike impact [s]."""
NARROWEST_BAND = 1.2
"""Smallest ratio of the edges of the track noise [-]."""


class BackgroundParameters(Group):
    """Levels of wheel, track and look-alike impacts."""

    unbalance: float = quantity(
        0.0,
        "m",
        "Unbalance: acceleration amplitude over the square of the shaft speed; 1e-4 gives 1.6 m/s^2 at 1200 rpm",
        0.0,
        0.01,
        run_time=True,
    )
    joint_level: float = quantity(
        0.0, "m/s^2", "Peak acceleration at a rail joint at 72 km/h; proportional to the speed", 0.0, 1e4, run_time=True
    )
    joint_spacing: float = quantity(25.0, "m", "Distance between rail joints", 1.0, 1000.0)
    flat_level: float = quantity(
        0.0,
        "m/s^2",
        "Peak acceleration of a wheel flat, once per revolution, at 72 km/h; proportional to the speed",
        0.0,
        1e4,
        run_time=True,
    )
    track_level: float = quantity(
        0.0, "m/s^2", "Random track excitation, rms per axis, at 72 km/h; proportional to the speed", 0.0, 1e3, run_time=True
    )
    track_low: float = quantity(20.0, "Hz", "Lower edge of the track excitation", 1.0, 20000.0)
    track_high: float = quantity(1500.0, "Hz", "Upper edge of the track excitation", 2.0, 40000.0)
    impact_rate: float = quantity(
        0.0, "1/s", "Impacts per second, at random times, that resemble those of a defect", 0.0, 1000.0, run_time=True
    )
    impact_level: float = quantity(200.0, "m/s^2", "Mean peak of these impacts, which last 0.1 ms", 0.0, 1e5, run_time=True)


class Background(Stage):
    """Adds the acceleration of the axle box by wheel, track and look-alike impacts."""

    group, parameters = "background", BackgroundParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._levels = setup.parameters[BackgroundParameters]
        self._radius = 0.5 * setup.wheel_diameter
        phases = random_stream(setup.seed, "passings").random(3)
        self._joints = Passings(self._levels.joint_spacing / self._radius, float(phases[0]), Pulses(JOINT_DURATION, rate))
        self._flat = Passings(2.0 * math.pi, float(phases[1]), Pulses(FLAT_DURATION, rate))
        self._unbalance_phase = 2.0 * math.pi * float(phases[2])
        self._impacts, self._impact_times = Pulses(IMPACT_DURATION, rate), PoissonTimes(random_stream(setup.seed, "impacts"))
        self._track = Filter(band_of_noise(self._levels.track_low, self._levels.track_high, rate))
        self._track_random = random_stream(setup.seed, "track")

    @classmethod
    def problems(cls, parameters: Parameters, step_rate: int) -> Iterator[str]:
        levels = parameters[BackgroundParameters]
        yield from above_step_rate("background.track_high", levels.track_high, step_rate)
        if levels.track_high < NARROWEST_BAND * levels.track_low:
            yield (
                f"background.track_high = {levels.track_high:g} Hz is less than {NARROWEST_BAND:g} times "
                f"background.track_low = {levels.track_low:g} Hz: make the band wider"
            )

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        self._levels = parameters[BackgroundParameters]

    @property
    def active(self) -> bool:
        b = self._levels
        return any(level > 0.0 for level in (b.unbalance, b.joint_level, b.flat_level, b.track_level, b.impact_rate))

    def process(self, acceleration: Floats, span: Span) -> Floats:
        levels, speed = self._levels, np.diff(span.angle) * self.rate
        relative_speed = np.abs(speed) * (self._radius / REFERENCE_SPEED)
        background = np.zeros((len(speed), 2))
        if levels.unbalance > 0.0:
            self._add_unbalance(span.angle[1:], speed, background)
        if levels.joint_level > 0.0:
            background[:, 1] += self._joints.process(span.first, span.angle, levels.joint_level * relative_speed)
        if levels.flat_level > 0.0:
            background[:, 1] += self._flat.process(span.first, span.angle, levels.flat_level * relative_speed)
        if levels.track_level > 0.0:
            track = self._track.process(self._track_random.standard_normal(background.shape))
            for axis in (0, 1):
                background[:, axis] += levels.track_level * relative_speed * track[:, axis]
        if levels.impact_rate > 0.0:
            background[:, 1] += self._look_alikes(span.first, len(speed))
        return acceleration + background

    def _add_unbalance(self, angle: Floats, speed: Floats, background: Floats) -> None:
        """Add the acceleration of a force that rotates with the shaft and grows with the square of its speed [m/s^2]."""
        angle, force = angle + self._unbalance_phase, self._levels.unbalance * speed**2
        background[:, 0] += force * np.cos(angle)
        background[:, 1] += force * np.sin(angle)

    def _look_alikes(self, first: int, count: int) -> Floats:
        """Return impacts at random times, with peaks of 0.5 to 1.5 times the mean [m/s^2]."""
        for at, share in self._impact_times.within(first, count, self._levels.impact_rate / self.rate):
            self._impacts.begin(at, self._levels.impact_level * (0.5 + share))
        return self._impacts.process(first, count)
