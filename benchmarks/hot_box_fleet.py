"""Days of many axles: trips, weather, individual boxes, and the temperatures that follow.

All distributions are choices, stated in `Fleet`; none was fitted to the detector. Both boxes of an axle share train and weather. The
detector knows neither load, sun nor wind.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from hot_box_heat import HeatTable
from scipy.signal import lfilter

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.arrays import Floats, Samples

STEP = 60.0
"""Time between two readings [s]."""
PARTS = 3
"""Steps of the network in that time [-]."""
DAY = 86_400.0
"""[s]"""
WHEEL_RADIUS = 0.46
"""[m]"""


@dataclass(frozen=True)
class Duty:
    """Operation of the trains of a fleet and the weather; each array has the shape (steps, axles)."""

    speed: Floats
    """Of the shaft [rad/s]."""
    load: Floats
    """On each bearing [N]."""
    ambient: Floats
    """[deg C]"""
    wind: Floats
    """Cooling of the boxes over that in calm, dry air [-]."""
    sun: Floats
    """Heat that a box in the sun absorbs [W]."""


@dataclass(frozen=True)
class Growth:
    """The growth of a fault of the first box of each axle, from nothing to its last size in a straight line; shape (axles,)."""

    onset: Floats
    """[s]"""
    duration: Floats
    """[s]"""
    last: float
    """Last size."""

    def size(self, time: float) -> Floats:
        """Return the sizes at a time [s]."""
        return np.asarray(self.last * np.clip((time - self.onset) / self.duration, 0.0, 1.0))


@dataclass(frozen=True)
class Temperatures:
    """Temperatures of a fleet's boxes, shape (steps, axles, 2) [deg C]; the fault is in the first box of an axle."""

    outer_ring: Samples
    box: Samples


class Fleet:
    """A number of axles over a number of days, drawn from a seed."""

    def __init__(self, axles: int, days: int, seed: int) -> None:
        self.axles, self.days, self.seed = axles, days, seed
        self.steps = round(days * DAY / STEP)
        self._individual = random_stream(seed, "hot boxes: individuals")
        self.friction = np.exp(0.2 * self._individual.standard_normal((axles, 2)))
        """Heat of the films over that of the bench: logarithm with a deviation of 0.2 [-]."""
        self.cooling = np.exp(0.1 * self._individual.standard_normal((axles, 2)))
        """Cooling of each box over that of the bench: logarithm with a deviation of 0.1 [-]."""
        self.sunny = self._individual.random((axles, 2))
        """Share of the sun that each box gets [-]."""
        self.bias = self._individual.standard_normal(axles)
        """Error of the thermometer of the air, deviation 1 K [K]."""
        self.duty = self._duty()

    def _duty(self) -> Duty:
        """Return the duty: trips between stations by day and standstill by night, in the weather of each axle's place."""
        trips = [self._trips(random_stream(self.seed, f"hot boxes: trips of axle {k}")) for k in range(self.axles)]
        weather = random_stream(self.seed, "hot boxes: weather")
        hour = (np.arange(self.steps) * STEP / 3600.0)[:, None]
        day = np.minimum((hour / 24.0).astype(np.int64), self.days - 1)
        # The mean of a day wanders about that of the season by 4 K; 5 K between morning and afternoon; a front of some hours has 2 K.
        season = weather.uniform(-8.0, 24.0, self.axles)
        daily = season + 4.0 * weather.standard_normal((self.days, self.axles))
        ambient = daily[day[:, 0]] + 5.0 * np.sin(2.0 * np.pi * (hour - 9.0) / 24.0) + 2.0 * self._wander(weather, 3.0)
        # Wind and rain change the cooling by 12 %, within some hours; clouds cover the sun by day, up to 200 W.
        wind = np.exp(0.12 * self._wander(weather, 2.0))
        height = np.clip(np.sin(2.0 * np.pi * (hour % 24.0 - 6.0) / 24.0), 0.0, 1.0)
        sun = 200.0 * height * np.clip(0.5 + 0.5 * self._wander(weather, 1.0), 0.0, 1.0)
        return Duty(np.stack([speed for speed, _ in trips], 1), np.stack([load for _, load in trips], 1), ambient, wind, sun)

    def _wander(self, random: np.random.Generator, hours: float) -> Floats:
        """Return a unit-variance process with a correlation time of some hours, shape (steps, axles) [-]."""
        kept = float(np.exp(-STEP / (3600.0 * hours)))
        process = random.standard_normal((self.steps, self.axles))
        process[1:] *= np.sqrt(1.0 - kept**2)
        return np.asarray(lfilter([1.0], [1.0, -kept], process, axis=0))

    def _trips(self, random: np.random.Generator) -> tuple[Floats, Floats]:
        """Return speed [rad/s] and load [N] of an axle: from 5 to 23 h trips of 2 to 5 h, empty to full, with stops every 15 to 80 km."""
        speed, load = np.zeros(self.steps), np.zeros(self.steps)
        permitted = random.uniform(120.0, 200.0)
        for day in range(self.days):
            now, end = (day * 24.0 + 5.0 + random.random()) * 3600.0, (day * 24.0 + 22.0 + random.random()) * 3600.0
            while now < end:
                carried, arrival = random.uniform(80e3, 130e3), min(now + random.uniform(2.0, 5.0) * 3600.0, end)
                begin = now
                while now < arrival:
                    velocity = random.uniform(0.6, 1.0) * permitted / 3.6
                    driven = now + 1e3 * random.uniform(15.0, 80.0) / velocity
                    speed[int(now / STEP) : int(driven / STEP)] = velocity / WHEEL_RADIUS
                    now = driven + random.uniform(60.0, 600.0)
                load[int(begin / STEP) : int(now / STEP)] = carried
                now += random.uniform(0.2, 1.0) * 3600.0
        load[load == 0.0] = 80e3
        return speed, load

    def temperatures(self, table: HeatTable, growth: Growth | None = None) -> Temperatures:
        """Return the temperatures of all boxes; at first they are those of the air."""
        duty, axles = self.duty, self.axles
        outer, box = np.zeros((2, self.steps, axles, 2), np.float32)
        state = np.broadcast_to(np.repeat(duty.ambient[0], 2), (4, 2 * axles)).copy()
        friction, cooling = self.friction.ravel(), self.cooling.ravel()
        size = np.zeros((axles, 2))
        for k in range(self.steps):
            speed, load, ambient, wind = (np.repeat(values[k], 2) for values in (duty.speed, duty.load, duty.ambient, duty.wind))
            sun = (duty.sun[k][:, None] * self.sunny).ravel()
            if growth is not None:
                size[:, 0] = growth.size(k * STEP)
            for _ in range(PARTS):
                state = table.after(state, speed, load, size.ravel(), ambient, friction, wind * cooling, sun, STEP / PARTS)
            outer[k], box[k] = state[2].reshape(axles, 2), state[3].reshape(axles, 2)
        return Temperatures(outer, box)

    def readings(self, truth: Temperatures) -> tuple[Floats, Floats]:
        """Return the readings at the outer rings and in the air: noise of 0.2 K, in steps of 0.5 K, and the bias of the air's.

        Shapes (steps, axles, 2) and (steps, axles) [deg C].
        """
        random = random_stream(self.seed, "hot boxes: thermometers")
        ring = truth.outer_ring + 0.2 * random.standard_normal(truth.outer_ring.shape)
        air = self.duty.ambient + self.bias + 0.2 * random.standard_normal(self.duty.ambient.shape)
        return np.round(ring / 0.5) * 0.5, np.round(air / 0.5) * 0.5
