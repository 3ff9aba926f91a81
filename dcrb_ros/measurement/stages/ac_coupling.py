"""AC coupling of the supply: a first-order high-pass."""

from __future__ import annotations

from dcrb_ros.measurement.filters import Filter, high_pass
from dcrb_ros.measurement.stage import Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity


class AcCouplingParameters(Group):
    """Corner frequency of the coupling."""

    ac_coupling: float = quantity(
        0.0, "Hz", "AC coupling: -3 dB frequency of a first-order high-pass; 0 for a sensor that measures constant acceleration", 0.0, 100.0
    )


class AcCoupling(Stage):
    """First-order high-pass, -3 dB at the corner frequency."""

    parameters = AcCouplingParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        corner = setup.parameters[AcCouplingParameters].ac_coupling
        self._filter = Filter(high_pass(corner, rate)) if corner > 0.0 else None

    @property
    def active(self) -> bool:
        return self._filter is not None

    def process(self, acceleration: Floats, span: Span) -> Floats:
        return acceleration if self._filter is None else self._filter.process(acceleration)
