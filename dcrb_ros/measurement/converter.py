"""The converter: noise, range and steps, and the faults that show in its samples."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from dcrb_ros.measurement.filters import Filter, pink
from dcrb_ros.measurement.sensor_fault import FaultySamples
from dcrb_ros.measurement.streams import stream
from dcrb_ros.measurement.timetable import Timetable
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.sensor import MICRO_G, SensorParameters


class Converter:
    """Turns sampled acceleration into what is published."""

    def __init__(self, configuration: Configuration) -> None:
        seed = configuration.simulation.seed
        self._random = np.random.Generator(np.random.Philox(seed))
        self._pink, self._pink_random = Filter(pink(float(configuration.sensor.sampling_rate))), stream(seed, "pink_noise")
        self._fault = FaultySamples(configuration.sensor, seed)
        self.changes: Timetable[SensorParameters] = Timetable(self._set)
        """Other parameters by the sample from which they hold."""
        self._set(configuration.sensor)

    def _set(self, sensor: SensorParameters) -> None:
        density = sensor.noise_density
        if sensor.white_noise_ug > 0.0:
            density = math.hypot(density, sensor.white_noise_ug * MICRO_G)
        self._white = density * np.sqrt(0.5 * sensor.sampling_rate)
        self._pink_density = sensor.pink_noise_ug * MICRO_G
        self._resolution = sensor.range / 2.0 ** (sensor.adc_bits - 1) if sensor.adc_bits > 0 else 0.0
        self._fault.set(sensor, self.changes.reached)

    def feed(self, samples: Floats) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """Return the measured samples, shape (samples, 2) [m/s^2], and whether any axis of each was beyond its range."""
        random = self._random.standard_normal(samples.shape)
        measured, clipped = np.empty_like(samples), np.empty(len(samples), np.bool_)
        first = self.changes.reached
        for piece in self.changes.pieces(len(samples)):
            at = first + piece.start
            noisy = self._fault.distorted(samples[piece], at) + self._white * random[piece]
            if self._pink_density > 0.0:
                noisy += self._pink_density * self._pink.feed(self._pink_random.standard_normal(noisy.shape))
            limited, clipped[piece] = self._limited(noisy)
            measured[piece] = self._fault.stuck(limited, at)
        return measured, clipped

    def _limited(self, noisy: Floats) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """Return samples within the range in the converter's steps, and which were beyond it."""
        limit = self._fault.limit()
        limited = np.clip(noisy, -limit, limit)
        if self._resolution > 0.0:
            limited = np.round(limited / self._resolution) * self._resolution
        beyond = np.abs(noisy) > limit
        return limited, beyond[:, 0] | beyond[:, 1]
