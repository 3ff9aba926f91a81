"""The accelerometer on the outer ring: anti-alias filter, noise, range and converter."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dcrb_ros.configuration import Configuration
from dcrb_ros.measurement.decimation import Decimator
from dcrb_ros.parameters import SensorParameters


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
        self._decimator = Decimator(configuration.steps_per_sample, between=True)
        self._random = np.random.Generator(np.random.Philox(configuration.simulation.seed))
        self._samples = 0
        self._changes: deque[tuple[int, SensorParameters]] = deque()
        self._set(configuration.sensor)

    def _set(self, sensor: SensorParameters) -> None:
        self._noise = sensor.noise_density * np.sqrt(0.5 * sensor.sampling_rate)
        self._range = sensor.range
        self._resolution = sensor.range / 2.0 ** (sensor.adc_bits - 1) if sensor.adc_bits > 0 else 0.0

    def change(self, sensor: SensorParameters, sample: int) -> None:
        """Measure with other parameters from ``sample`` on, which must not lie before an earlier change's."""
        self._changes.append((sample, sensor))

    @property
    def lead(self) -> int:
        """Time steps needed beyond a sample [-]."""
        return self._decimator.lead

    def measure(self, acceleration: npt.NDArray[np.float64]) -> Measurement:
        """Return the samples due after ``acceleration``, means over each step, shape (steps, 2) [m/s^2]."""
        clean = self._decimator.feed(acceleration)
        random = self._random.standard_normal(clean.shape)
        measured, clipped, begin = np.empty_like(clean), np.empty(len(clean), np.bool_), 0
        while begin < len(clean):
            while self._changes and self._changes[0][0] <= self._samples:
                self._set(self._changes.popleft()[1])
            end = min(len(clean), begin + self._changes[0][0] - self._samples) if self._changes else len(clean)
            measured[begin:end], clipped[begin:end] = self._limited(clean[begin:end] + self._noise * random[begin:end])
            self._samples += end - begin
            begin = end
        return Measurement(clean, measured, clipped)

    def _limited(self, noisy: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
        """Return samples within the range in the converter's steps, and which were beyond it."""
        limited = np.clip(noisy, -self._range, self._range)
        if self._resolution > 0.0:
            limited = np.round(limited / self._resolution) * self._resolution
        return limited, np.any(np.abs(noisy) > self._range, axis=1)
