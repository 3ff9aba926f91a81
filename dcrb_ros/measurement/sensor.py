"""The accelerometer on the outer ring: every stage from the ring's acceleration to measured samples.

At every time step: background, structure, mount, bandwidth; then the anti-alias filter. At every sample: cross axis, hum,
offset, coupling. At the times of the converter's clock: noise, range, steps. A stage that is off costs nothing.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dcrb_ros.measurement.analog import Analog, Surroundings
from dcrb_ros.measurement.clock import Clock
from dcrb_ros.measurement.converter import Converter
from dcrb_ros.measurement.decimation import Decimator
from dcrb_ros.measurement.electronics import Electronics
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.sensor import Background, SensorParameters


@dataclass(frozen=True)
class Measurement:
    """Samples of the sensor over one stretch; arrays of shape (samples, 2)."""

    clean: npt.NDArray[np.float64]
    """After the anti-alias filter, before everything else [m/s^2]."""
    measured: npt.NDArray[np.float64]
    """With noise, clipped to the range and rounded to the converter's steps [m/s^2]."""
    clipped: npt.NDArray[np.bool_]
    """Whether any axis of a sample was beyond the range, shape (samples,)."""
    angle: npt.NDArray[np.float64]
    """Rotation of the inner ring when a sample was taken, shape (samples,) [rad]."""


class Sensor:
    """The chain from acceleration at every time step to measured samples; the same bits for any block size."""

    def __init__(self, configuration: Configuration) -> None:
        self._factor = configuration.steps_per_sample
        self._background = configuration.background
        self._decimator = Decimator(self._factor, between=True)
        self._analog = Analog(configuration)
        self._arriving: Decimator | None = None
        self._electronics = Electronics(configuration)
        clock = configuration.sensor
        self._clock = Clock(configuration) if clock.clock_offset_ppm or clock.clock_jitter else None
        self._converter = Converter(configuration)
        self._angles = np.zeros(0)

    def change(self, sensor: SensorParameters, sample: int, background: Background | None = None) -> None:
        """Measure with other parameters from ``sample`` on, which must not lie before an earlier change's."""
        self._background = background or self._background
        self._analog.changes.add(sample * self._factor, Surroundings(sensor, self._background))
        self._electronics.hum_levels.add(sample, self._background.hum_level)
        self._converter.changes.add(self._clock.sample_at(sample) if self._clock else sample, sensor)

    def steps(self, samples: int) -> int:
        """Return the time steps needed until so many ``samples`` of each kind are due [-]."""
        nominal = samples if self._clock is None else max(samples, self._clock.needed(samples))
        return (nominal - 1) * self._factor + self._decimator.lead + 1

    def measure(self, acceleration: npt.NDArray[np.float64], angle: npt.NDArray[np.float64]) -> Measurement:
        """Return the samples due after ``acceleration``, means over each step, shape (steps, 2) [m/s^2].

        ``angle`` is the shaft's at the beginning of each step, shape (steps,) [rad].
        """
        clean, arriving = self._sampled(acceleration, angle)
        # An angle waits until the filter has its sample.
        self._angles = np.concatenate([self._angles, angle])
        turned, self._angles = self._angles[: len(clean) * self._factor : self._factor], self._angles[len(clean) * self._factor :]
        arriving = self._electronics.feed(arriving)
        if self._clock is not None:
            arriving, turned = self._clock.feed(arriving, turned)
        measured, clipped = self._converter.feed(arriving)
        return Measurement(clean, measured, clipped, turned)

    def _sampled(
        self, acceleration: npt.NDArray[np.float64], angle: npt.NDArray[np.float64]
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return the outer ring's acceleration and what arrives at the sensor, both after the anti-alias filter [m/s^2]."""
        if self._arriving is None and self._analog.touches(len(acceleration)):
            # Until now both were the same.
            self._arriving = copy.deepcopy(self._decimator)
        clean = self._decimator.feed(acceleration)
        arriving = self._analog.feed(acceleration, angle)
        return clean, clean if self._arriving is None else self._arriving.feed(arriving)
