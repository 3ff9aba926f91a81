"""Faults that the bench can carry, as the user says them."""

from __future__ import annotations

from collections.abc import Iterator

from dcrb_ros.parameters import Group, length, quantity


class RacewayDefect(Group):
    """A notch across a raceway (Eqs. 8, 9 and 13 to 15 of Fan et al. 2025)."""

    row: int = quantity(0, "-", "Row of the defect; 0 for all rows", 0, 2, run_time=True)
    width: float = length(0.0, "Width along the raceway; 0 for no defect", 0.0, 0.05, symbol="b", run_time=True)
    depth: float = length(0.0003, "Depth", 0.0, 0.01, symbol="h", run_time=True)
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


class Faults(Group):
    """Every fault by name; a width of zero means that it is absent."""

    outer_1: RacewayDefect = RacewayDefect()
    outer_2: RacewayDefect = RacewayDefect()
    inner_1: RacewayDefect = RacewayDefect()
    inner_2: RacewayDefect = RacewayDefect()

    def present(self) -> Iterator[tuple[str, RacewayDefect]]:
        """Yield name and defect of every fault with a size."""
        for name in type(self).model_fields:
            defect: RacewayDefect = getattr(self, name)
            if defect.width > 0.0:
                yield name, defect
