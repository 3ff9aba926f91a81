"""Faults of the sensor that show in its samples; a loose mounting belongs to the mount."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from dcrb_ros.measurement.filters import Filter
from dcrb_ros.measurement.streams import RandomTimes, stream
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.sensor import SensorParameters

SPIKES = 20.0
"""Cable spikes a second at full severity."""
SPIKE_LENGTH = 1e-4
"""Time in which a spike falls to 1/e [s]."""
STICKING = 0.1
"""Period in which a sensor sticks for its severity's share [s]."""
LEAST_LIMIT = 0.01
"""Share of its range at which a fully saturated sensor limits [-]."""
AXES = {"both": (0, 1), "x": (0,), "y": (1,)}


class FaultySamples:
    """Samples of a sensor that may be faulty: dead, drifting, spiking, limiting or stuck."""

    def __init__(self, sensor: SensorParameters, seed: int) -> None:
        self._rate = float(sensor.sampling_rate)
        self._times = RandomTimes(stream(seed, "spikes"))
        self._falling = self._spike_shape()
        self._held = np.zeros(2)
        self._onset = 0
        self._sensor = sensor.model_copy(update={"fault": "none"})
        self.set(sensor, 0)

    def set(self, sensor: SensorParameters, sample: int) -> None:
        """Have the fault of ``sensor`` from a sample on; a fault that was there goes on from where it was."""
        if sensor.fault != self._sensor.fault:
            self._onset, self._falling = sample, self._spike_shape()
        self._sensor = sensor

    @property
    def kind(self) -> str:
        """The fault, or ``none``."""
        return self._sensor.fault if self._sensor.fault_severity > 0.0 else "none"

    @property
    def _axes(self) -> tuple[int, ...]:
        return AXES[self._sensor.fault_axis]

    def limit(self) -> Floats | float:
        """Return the largest acceleration, of each axis where they differ [m/s^2]."""
        if self.kind != "saturated":
            return self._sensor.range
        limit = np.full(2, self._sensor.range)
        limit[list(self._axes)] *= LEAST_LIMIT**self._sensor.fault_severity
        return limit

    def distorted(self, samples: Floats, first: int) -> Floats:
        """Return what the fault makes of samples from ``first`` on before noise and converter, shape (samples, 2) [m/s^2]."""
        gain = self._gain(first, len(samples))
        if self.kind not in ("dead", "gain_drift", "spikes"):
            return samples
        changed: Floats = samples.copy()
        spikes = self._spikes(first, len(samples)) if self.kind == "spikes" else 0.0
        for axis in self._axes:
            changed[:, axis] = gain * changed[:, axis] + spikes
        return changed

    def _gain(self, first: int, count: int) -> Floats | float:
        """Return the gain of faulty axes [-]."""
        if self.kind == "dead":
            return 1.0 - self._sensor.fault_severity
        if self.kind == "gain_drift":
            since = (np.arange(first, first + count) - self._onset) / (self._sensor.fault_time * self._rate)
            fallen: Floats = 1.0 - self._sensor.fault_severity * np.clip(since, 0.0, 1.0)
            return fallen
        return 1.0

    def _spikes(self, first: int, count: int) -> Floats:
        """Return spikes at random times that fall off exponentially [m/s^2]; they reach a fifth of the range up to all of it."""
        severity, blows = self._sensor.fault_severity, np.zeros((count, 1))
        for at, drawn in self._times.within(first, count, SPIKES * severity / self._rate):
            share = 2.0 * drawn - 1.0
            blows[int(at) - first] += severity * self._sensor.range * math.copysign(0.2 + 0.8 * abs(share), share)
        falling: Floats = self._falling.feed(blows)[:, 0]
        return falling

    def _spike_shape(self) -> Filter:
        decay = float(np.exp(-1.0 / (SPIKE_LENGTH * self._rate)))
        return Filter(np.array([[1.0, 0.0, 0.0, 1.0, -decay, 0.0]]), columns=1)

    def stuck(self, samples: Floats, first: int) -> Floats:
        """Return samples from ``first`` on with those that a stuck sensor repeats, shape (samples, 2) [m/s^2]."""
        if self.kind == "stuck":
            samples = samples.copy()
            period = max(2, round(STICKING * self._rate))
            place = (np.arange(first, first + len(samples)) - self._onset) % period
            sticks: npt.NDArray[np.bool_] = place < self._sensor.fault_severity * period
            last_moving = np.maximum.accumulate(np.where(sticks, -1, np.arange(len(samples))))
            for axis in self._axes:
                own = np.concatenate([[self._held[axis]], samples[:, axis]])
                samples[:, axis] = own[last_moving + 1]
        if len(samples):
            self._held = samples[-1].copy()
        return samples
