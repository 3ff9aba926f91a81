"""A notch across a roller; it strikes both raceways in a turn of the roller, which excites twice BSF with sidebands at FTF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from dcrb_ros.faults.fault import Dimensions, Footprint
from dcrb_ros.faults.geometry import RollerNotch
from dcrb_ros.faults.notch import Notch, floor
from dcrb_ros.schema.fields import quantity


class RollerDefect(Notch):
    """A notch across one roller."""

    keys = ("roller_1", "roller_2")
    component = "roller"

    row: int = quantity(1, "-", "Row of the roller", 1, 2, run_time=True)
    roller: int = quantity(1, "-", "Number of the roller in its row", 1, 60, run_time=True)
    azimuth: float = quantity(
        0.0,
        "rad",
        "Angle of the middle on the roller at time zero, from -Y, counter-clockwise",
        -3.1416,
        3.1416,
        run_time=True,
        remedy="give radians",
    )

    def problems(self, key: str, bearing: Dimensions) -> Iterator[str]:
        """Refuse a notch wider than the roller's radius, and one on a missing roller."""
        yield from self.too_wide(key, bearing.roller_radius, "roller's radius")
        if self.row > bearing.rows or self.roller > bearing.rollers_per_row:
            yield (
                f"faults.{key}: there is no roller {self.roller} in row {self.row}; the bearing has {bearing.rows} row(s) of "
                f"{bearing.rollers_per_row} rollers"
            )

    def footprints(self, bearing: Dimensions) -> Iterator[Footprint]:
        """Yield the width of the notch on its roller."""
        yield Footprint(self.component, self.row, self.roller, self.azimuth, self.width, bearing.roller_radius)

    def damage(self, bearing: Dimensions, edge_radius: float) -> Iterator[RollerNotch]:
        """Yield the notch."""
        roller, inner, outer = bearing.roller_radius, bearing.inner_raceway_radius, bearing.outer_raceway_radius
        half = 0.5 * self.width / roller
        inner_bottom, inner_kink = floor(half, roller, inner, inner + roller - self.depth, False)
        outer_bottom, outer_kink = floor(half, roller, outer, outer - roller + self.depth, True)
        bottoms, kinks = (inner_bottom, outer_bottom), (inner_kink, outer_kink)
        yield RollerNotch(self.row - 1, self.roller - 1, half, *bottoms, *kinks, self.depth, self.azimuth)

    @classmethod
    def words(cls, name: str, fields: Mapping[str, float]) -> str:
        """Return width and roller."""
        return f"{super().words(name, fields)} on roller {int(fields['roller'])}"
