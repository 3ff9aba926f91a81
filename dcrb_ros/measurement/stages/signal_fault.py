"""Faults of the sensor that act before noise and ADC: a dead sensor, a drifting gain, spikes of a loose cable."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.filters import Filter
from dcrb_ros.measurement.parameters import AXES, Accelerometer, SensorFault
from dcrb_ros.measurement.random_streams import PoissonTimes, random_stream
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats

SPIKES = 20.0
"""Spikes of a cable per second at full severity."""
SPIKE_LENGTH = 1e-4
"""Time in which a spike falls to 1/e [s]."""


class SignalFault(Stage):
    """Scales the faulty axes or adds spikes to them."""

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._times = PoissonTimes(random_stream(setup.seed, "spikes"))
        self._spike_shape = self._new_spike_shape()
        self._fault: SensorFault = "none"
        self._onset = 0.0
        self._sensor = setup.parameters[Accelerometer]

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        """Start a new fault at a tick; a fault that stays continues from its present state."""
        before, self._sensor = self._sensor, parameters[Accelerometer]
        if self._sensor.present_fault != self._fault:
            self._onset, self._spike_shape = tick, self._new_spike_shape()
        elif (self._sensor.fault_time, self._sensor.fault_severity) != (before.fault_time, before.fault_severity):
            lost = before.fault_severity * min((tick - self._onset) / (before.fault_time * self.rate), 1.0)
            reached = min(lost / self._sensor.fault_severity, 1.0) if self._sensor.fault_severity > 0.0 else 1.0
            self._onset = tick - reached * self._sensor.fault_time * self.rate  # a drift continues from the loss that it has reached
        self._fault = self._sensor.present_fault

    @property
    def active(self) -> bool:
        return self._fault in ("dead", "gain_drift", "spikes")

    def process(self, acceleration: Floats, span: Span) -> Floats:
        count = len(acceleration)
        gain, spikes = self._gain(span.first, count), self._spikes(span.first, count) if self._fault == "spikes" else 0.0
        after: Floats = acceleration.copy()
        for axis in AXES[self._sensor.fault_axis]:
            after[:, axis] = gain * after[:, axis] + spikes
        return after

    def _gain(self, first: int, count: int) -> Floats | float:
        """Return the gain of the faulty axes [-]."""
        if self._fault == "dead":
            return 1.0 - self._sensor.fault_severity
        if self._fault == "gain_drift":
            elapsed = (np.arange(first, first + count) - self._onset) / (self._sensor.fault_time * self.rate)
            gain: Floats = 1.0 - self._sensor.fault_severity * np.clip(elapsed, 0.0, 1.0)
            return gain
        return 1.0

    def _spikes(self, first: int, count: int) -> Floats:
        """Return spikes at random times that decay exponentially [m/s^2]; their peaks are 0.2 to 1 times the range."""
        severity, impulses = self._sensor.fault_severity, np.zeros((count, 1))
        for at, drawn in self._times.within(first, count, SPIKES * severity / self.rate):
            share = 2.0 * drawn - 1.0
            impulses[int(at) - first] += severity * self._sensor.range * math.copysign(0.2 + 0.8 * abs(share), share)
        spikes: Floats = self._spike_shape.process(impulses)[:, 0]
        return spikes

    def _new_spike_shape(self) -> Filter:
        decay = float(np.exp(-1.0 / (SPIKE_LENGTH * self.rate)))
        return Filter(np.array([[1.0, 0.0, 0.0, 1.0, -decay, 0.0]]), columns=1)
