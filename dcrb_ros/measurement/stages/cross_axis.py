"""Cross-axis sensitivity: each axis also measures a share of the other one."""

from __future__ import annotations

from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity


class CrossAxisParameters(Group):
    """Cross-axis sensitivity."""

    cross_axis: float = quantity(
        0.0, "-", "Cross-axis sensitivity: share of the other axis in each signal", 0.0, 0.5, remedy="give a share, not per cent"
    )


class CrossAxis(Stage):
    """Adds to each axis a share of the other."""

    parameters = CrossAxisParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._share = 0.0

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        self._share = parameters[CrossAxisParameters].cross_axis

    @property
    def active(self) -> bool:
        return self._share > 0.0

    def process(self, acceleration: Floats, span: Span) -> Floats:
        after: Floats = acceleration.copy()
        for axis in (0, 1):
            after[:, axis] += self._share * acceleration[:, 1 - axis]
        return after
