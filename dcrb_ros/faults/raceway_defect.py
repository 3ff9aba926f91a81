"""A notch across a raceway; it excites BPFO on the outer ring and BPFI with sidebands at the shaft frequency on the inner ring."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from dcrb_ros.faults.fault import Dimensions, Footprint
from dcrb_ros.faults.geometry import RacewayNotch, Ring
from dcrb_ros.faults.notch import Notch, floor
from dcrb_ros.schema.fields import quantity


class RacewayDefect(Notch):
    """A notch across the raceway of either ring."""

    component: ClassVar[Ring]

    row: int = quantity(0, "-", "Row of the defect; 0 for all rows", 0, 2, run_time=True)
    azimuth: float = quantity(
        0.0,
        "rad",
        "Azimuth of the middle from the load line (-Y), counter-clockwise; on the inner ring at time zero",
        -3.1416,
        3.1416,
        symbol="phi_f",
        remedy="give radians",
        run_time=True,
    )

    def problems(self, key: str, bearing: Dimensions) -> Iterator[str]:
        """Refuse a notch wider than the pitch of the rollers, and one in a missing row."""
        yield from self.too_wide(key, 2.0 * math.pi * self._raceway(bearing) / bearing.rollers_per_row, "pitch")
        if self.row > bearing.rows:
            yield f"faults.{key}.row = {self.row} is outside 0 .. {bearing.rows}: the bearing has {bearing.rows} row(s), 0 means all"

    def footprint(self, bearing: Dimensions) -> Footprint:
        """Return the width of the notch on its raceway."""
        return Footprint(self.component, self.row, 0, self.azimuth, self.width, self._raceway(bearing))

    def damage(self, bearing: Dimensions, edge_radius: float) -> Iterator[RacewayNotch]:
        """Yield the notch."""
        raceway, side = self._raceway(bearing), 1.0 if self.component == "inner_ring" else -1.0
        half = 0.5 * self.width / raceway
        bottom, kink = floor(half, raceway, bearing.roller_radius, raceway + side * (bearing.roller_radius - self.depth), False)
        nearness = math.cos((0.5 * self.width + edge_radius) / raceway)
        yield RacewayNotch(self.component, self.row - 1, half, nearness, bottom, kink, self.depth, self.azimuth)

    def _raceway(self, bearing: Dimensions) -> float:
        """Return the radius of the raceway [m]."""
        return bearing.inner_raceway_radius if self.component == "inner_ring" else bearing.outer_raceway_radius


class OuterRacewayDefect(RacewayDefect):
    """A notch across the outer raceway."""

    keys = ("outer_1", "outer_2")
    component = "outer_ring"


class InnerRacewayDefect(RacewayDefect):
    """A notch across the inner raceway, which turns with the shaft."""

    keys = ("inner_1", "inner_2")
    component = "inner_ring"
