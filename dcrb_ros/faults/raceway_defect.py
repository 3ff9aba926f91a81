"""Damage of a raceway; it excites BPFO on the outer ring and BPFI with sidebands at the shaft frequency on the inner ring."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np

from dcrb_ros.faults.fault import Dimensions, Footprint
from dcrb_ros.faults.geometry import RacewayNotch, Ring, SurfaceHeights
from dcrb_ros.faults.notch import Notch, floor
from dcrb_ros.faults.shapes import SHAPES
from dcrb_ros.faults.shapes.shape import one_place
from dcrb_ros.schema.fields import choice, length, quantity

NOTCH = "notch"
KINDS = (NOTCH, *SHAPES)
"""Values of ``kind``."""
KINDS_DESCRIBED = "; ".join(f"{shape.name}, {shape.summary}" for shape in SHAPES.values())
OF_NOTCH = ("width", "depth", "row", "azimuth")
"""Parameters that describe a notch."""
SAMPLING = 10e-6
"""Distance of the samples of damage along the raceway [m]."""


class RacewayDefect(Notch):
    """A notch across the raceway of either ring, or other damage of it."""

    component: ClassVar[Ring]

    kind: Literal[KINDS] = choice(  # type: ignore[valid-type]
        NOTCH, f"Kind of damage: notch, with sharp edges (the paper); with surfaces.law profile also {KINDS_DESCRIBED}", run_time=True
    )
    share: float = quantity(
        0.0,
        "-",
        "Share of the rollers' length that the damage takes, if it is no notch; 0 for the kind's own",
        0.0,
        1.0,
        run_time=True,
    )
    roughness: float = quantity(0.3, "-", "Roughness of a spall's floor over its depth", 0.0, 1.0, run_time=True)
    period: float = length(0.001, "Distance between the grooves of fluting", 1e-4, 0.05, run_time=True)
    count: int = quantity(40, "-", "Pits of corrosion", 1, 1000, run_time=True)
    seed: int = quantity(1, "-", "Seed of a spall's floor and of the pits of corrosion", 0, 2**31 - 1, run_time=True)

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

    def footprints(self, bearing: Dimensions) -> Iterator[Footprint]:
        """Yield the width of the notch on its raceway, or the reach of other damage at each of its places."""
        shape = SHAPES.get(self.kind)
        width = 2.0 * shape.reach(self) if shape else self.width
        for copy in (shape.places if shape else one_place)(2.0 * math.pi / bearing.rollers_per_row):
            yield Footprint(self.component, self.row, 0, self.azimuth + copy.angle, width, self._raceway(bearing))

    def described(self, key: str) -> dict[str, dict[str, float]]:
        """Return the numbers that the ground truth states: of a notch its size and place."""
        numbers = super().described(key)
        return {name: {part: fields[part] for part in OF_NOTCH} for name, fields in numbers.items()} if self.kind == NOTCH else numbers

    def damage(self, bearing: Dimensions, edge_radius: float) -> Iterator[RacewayNotch | SurfaceHeights]:
        """Yield the notch, or the heights of other damage."""
        if self.kind != NOTCH:
            yield from self._heights(bearing)
            return
        raceway, side = self._raceway(bearing), 1.0 if self.component == "inner_ring" else -1.0
        half = 0.5 * self.width / raceway
        bottom, kink = floor(half, raceway, bearing.roller_radius, raceway + side * (bearing.roller_radius - self.depth), False)
        nearness = math.cos((0.5 * self.width + edge_radius) / raceway)
        yield RacewayNotch(self.component, self.row - 1, half, nearness, bottom, kink, self.depth, self.azimuth)

    def _heights(self, bearing: Dimensions) -> Iterator[SurfaceHeights]:
        """Yield the heights of the damage at each of its places."""
        shape = SHAPES[self.kind]
        half = math.ceil(shape.reach(self) / SAMPLING) + 1
        x = np.asarray(SAMPLING * np.arange(-half, half + 1), np.float64)
        heights = np.where(np.abs(x) <= shape.reach(self), shape.heights(x, self, np.random.default_rng(self.seed)), 0.0)
        share = self.share or shape.share(self, bearing.roller_length)
        for copy in shape.places(2.0 * math.pi / bearing.rollers_per_row):
            at = self.azimuth + copy.angle
            yield SurfaceHeights(self.component, self.row - 1, (copy.scale * heights).tolist(), at, SAMPLING, min(share, 1.0))

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
