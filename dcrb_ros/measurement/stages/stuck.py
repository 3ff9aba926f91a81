"""A sensor that sticks: it repeats its last sample for a share of the time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dcrb_ros.measurement.parameters import AXES, Accelerometer
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats

PERIOD = 0.1
"""Period of sticking [s]; the sensor sticks for its severity's share of it."""


class Stuck(Stage):
    """Repeats the last sample; it always runs, because the last sample before the fault must be known."""

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._last, self._onset = np.zeros(2), 0
        self._sensor, self._severity, self._fault = setup.parameters[Accelerometer], 0.0, "none"

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        """Start a new fault at a tick; a fault that stays keeps its period."""
        self._sensor = parameters[Accelerometer]
        if self._sensor.present_fault != self._fault:
            self._onset = tick
        self._fault, self._severity = self._sensor.present_fault, self._sensor.severity("stuck")

    def process(self, acceleration: Floats, span: Span) -> Floats:
        after = acceleration
        if self._severity > 0.0:
            after = acceleration.copy()
            period = max(2, round(PERIOD * self.rate))
            phase = (np.arange(span.first, span.first + len(after)) - self._onset) % period
            sticks: npt.NDArray[np.bool_] = phase < self._severity * period
            last_moving = np.maximum.accumulate(np.where(sticks, -1, np.arange(len(after))))
            for axis in AXES[self._sensor.fault_axis]:
                known = np.concatenate([[self._last[axis]], after[:, axis]])
                after[:, axis] = known[last_moving + 1]
        if len(after):
            self._last = after[-1].copy()
        return after
