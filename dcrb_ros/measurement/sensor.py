"""The accelerometer on the outer ring: anti-alias filter, noise, range and converter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dcrb_ros.configuration import Configuration
from dcrb_ros.measurement.decimation import Decimator


@dataclass(frozen=True)
class Measurement:
    """Samples of the sensor over one stretch; arrays of shape (samples, 2)."""

    clean: npt.NDArray[np.float64]
    """After the anti-alias filter, before everything else [m/s^2]."""
    measured: npt.NDArray[np.float64]
    """With noise, clipped to the range and rounded to the converter's steps [m/s^2]."""
    clipped: npt.NDArray[np.bool_]
    """Whether any axis of a sample was beyond the range, shape (samples,)."""


class Sensor:
    """The chain from acceleration at every time step to measured samples; the same bits for any block size."""

    def __init__(self, configuration: Configuration) -> None:
        sensor = configuration.sensor
        self._decimator = Decimator(configuration.steps_per_sample, between=True)
        self._random = np.random.Generator(np.random.Philox(configuration.simulation.seed))
        self._noise = sensor.noise_density * np.sqrt(0.5 * sensor.sampling_rate)
        self._range = sensor.range
        self._resolution = sensor.range / 2.0 ** (sensor.adc_bits - 1) if sensor.adc_bits > 0 else 0.0

    @property
    def lead(self) -> int:
        """Time steps needed beyond a sample [-]."""
        return self._decimator.lead

    def measure(self, acceleration: npt.NDArray[np.float64]) -> Measurement:
        """Return the samples due after ``acceleration``, means over each step, shape (steps, 2) [m/s^2]."""
        clean = self._decimator.feed(acceleration)
        noisy = clean + self._noise * self._random.standard_normal(clean.shape)
        limited = np.clip(noisy, -self._range, self._range)
        if self._resolution > 0.0:
            limited = np.round(limited / self._resolution) * self._resolution
        return Measurement(clean, limited, np.any(np.abs(noisy) > self._range, axis=1))
