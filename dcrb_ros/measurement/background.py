"""What shakes the axle box besides the bearing: wheel, track, and impacts that look like a defect's."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.filters import Filter, band_of_noise
from dcrb_ros.measurement.pulses import Passings, Pulses
from dcrb_ros.measurement.streams import RandomTimes, stream
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.sensor import REFERENCE_SPEED, Background

JOINT_DURATION = 0.004
"""Duration of a rail joint's pulse [s]."""
FLAT_DURATION = 0.002
"""Duration of a wheel flat's pulse [s]."""
IMPACT_DURATION = 1e-4
"""Duration of a look-alike impact [s]."""
HUM_SECOND, HUM_THIRD = 0.5, 0.33
"""Share of the mains' harmonics in their fundamental [-]."""


class Shaking:
    """Acceleration of the axle box by wheel and track, at every time step."""

    def __init__(self, configuration: Configuration) -> None:
        """Prepare for the background of a configuration, all of which may be off."""
        c, rate = configuration, float(configuration.step_rate)
        self._rate, self._seed = rate, c.simulation.seed
        self._radius = 0.5 * c.operating.wheel_diameter
        where = stream(self._seed, "passings").random(3)
        self._joints = Passings(c.background.joint_spacing / self._radius, float(where[0]), Pulses(JOINT_DURATION, rate))
        self._flat = Passings(2.0 * math.pi, float(where[1]), Pulses(FLAT_DURATION, rate))
        self._phase = 2.0 * math.pi * float(where[2])
        self._impacts, self._impact_times = Pulses(IMPACT_DURATION, rate), RandomTimes(stream(self._seed, "impacts"))
        self._track = Filter(band_of_noise(c.background.track_low, c.background.track_high, rate))
        self._track_random = stream(self._seed, "track")
        self.background = c.background
        """What it is like from now on."""

    @property
    def on(self) -> bool:
        """Whether wheel or track shake the axle box."""
        b = self.background
        return any(level > 0.0 for level in (b.unbalance, b.joint_level, b.flat_level, b.track_level, b.impact_rate))

    def feed(self, first: int, turned: Floats) -> Floats:
        """Return the acceleration from step ``first`` on, shape (steps, 2) [m/s^2].

        ``turned`` is the shaft's angle at the step before and at these steps, shape (steps + 1,) [rad].
        """
        b, speed = self.background, np.diff(turned) * self._rate
        share = np.abs(speed) * (self._radius / REFERENCE_SPEED)
        shaking = np.zeros((len(speed), 2))
        if b.unbalance > 0.0:
            self._unbalance(b, turned[1:], speed, shaking)
        if b.joint_level > 0.0:
            shaking[:, 1] += self._joints.feed(first, turned, b.joint_level * share)
        if b.flat_level > 0.0:
            shaking[:, 1] += self._flat.feed(first, turned, b.flat_level * share)
        if b.track_level > 0.0:
            track = self._track.feed(self._track_random.standard_normal(shaking.shape))
            for axis in (0, 1):
                shaking[:, axis] += b.track_level * share * track[:, axis]
        if b.impact_rate > 0.0:
            shaking[:, 1] += self._look_alike(b, first, len(speed))
        return shaking

    def _unbalance(self, b: Background, turned: Floats, speed: Floats, shaking: Floats) -> None:
        """Add the acceleration of a force that turns with the shaft and grows with the square of its speed [m/s^2]."""
        angle, force = turned + self._phase, b.unbalance * speed**2
        shaking[:, 0] += force * np.cos(angle)
        shaking[:, 1] += force * np.sin(angle)

    def _look_alike(self, b: Background, first: int, count: int) -> Floats:
        """Return impacts at random times, of half to one and a half times their mean peak [m/s^2]."""
        for at, share in self._impact_times.within(first, count, b.impact_rate / self._rate):
            self._impacts.begin(at, b.impact_level * (0.5 + share))
        return self._impacts.feed(first, count)


class Hum:
    """Mains hum that a cable picks up, at every sample."""

    def __init__(self, configuration: Configuration) -> None:
        """Prepare for the hum of a configuration, which may be off."""
        self._rate = float(configuration.sensor.sampling_rate)
        self._frequency = configuration.background.hum_frequency
        self._phase = 2.0 * math.pi * float(stream(configuration.simulation.seed, "hum").random())

    def feed(self, first: int, count: int, level: float) -> Floats:
        """Return the hum of a ``level`` [m/s^2] from sample ``first`` on, shape (samples,) [m/s^2]."""
        turns = np.mod(self._frequency * np.arange(first, first + count), self._rate) * (2.0 * math.pi / self._rate) + self._phase
        sine, cosine = np.sin(turns), np.cos(turns)
        second, third = 2.0 * sine * cosine, sine * (3.0 - 4.0 * sine**2)
        hum: Floats = level * (sine + HUM_SECOND * second + HUM_THIRD * third)
        return hum
