"""The measuring range: larger accelerations are clipped, and counted."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dcrb_ros.measurement.parameters import AXES, Accelerometer
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats

LEAST_LIMIT = 0.01
"""Share of its range at which a fully saturated sensor clips [-]."""


class MeasuringRange(Stage):
    """Clips the acceleration at the range, or below it in the axes of a saturated sensor."""

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._limit: Floats | float = 0.0
        self._clipped: list[npt.NDArray[np.bool_]] = []

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        sensor = parameters[Accelerometer]
        self._limit, severity = sensor.range, sensor.severity("saturated")
        if severity > 0.0:
            self._limit = np.full(2, sensor.range)
            self._limit[list(AXES[sensor.fault_axis])] *= LEAST_LIMIT**severity

    def process(self, acceleration: Floats, span: Span) -> Floats:
        beyond = np.abs(acceleration) > self._limit
        self._clipped.append(beyond[:, 0] | beyond[:, 1])
        return np.clip(acceleration, -self._limit, self._limit)

    def take_clipped(self) -> npt.NDArray[np.bool_]:
        """Return which samples since the last call were clipped in any axis, shape (samples,)."""
        clipped, self._clipped = self._clipped, []
        return np.concatenate([np.zeros(0, np.bool_), *clipped])
