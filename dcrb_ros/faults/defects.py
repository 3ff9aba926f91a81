"""Faults that the bench can carry, as the user says them."""

from __future__ import annotations

import re
from collections.abc import Iterator

from dcrb_ros.schema.fields import Group, choice, length, quantity

BAR = re.compile(r"row(\d{1,3})/bar(\d{1,3})")


class Notch(Group):
    """What every notch has."""

    width: float = length(0.0, "Width along the surface; 0 for no defect", 0.0, 0.05, symbol="b", run_time=True)
    depth: float = length(0.0003, "Depth", 0.0, 0.01, symbol="h", run_time=True)


class RacewayDefect(Notch):
    """A notch across a raceway (Eqs. 8, 9 and 13 to 15 of Fan et al. 2025)."""

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


class RollerDefect(Notch):
    """A notch across a roller; it strikes both raceways in a turn, which gives twice BSF."""

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


class Faults(Group):
    """Every fault by name; a width of zero means that it is absent."""

    outer_1: RacewayDefect = RacewayDefect()
    outer_2: RacewayDefect = RacewayDefect()
    inner_1: RacewayDefect = RacewayDefect()
    inner_2: RacewayDefect = RacewayDefect()
    roller_1: RollerDefect = RollerDefect()
    roller_2: RollerDefect = RollerDefect()
    broken_bars: str = choice(
        "", "Broken cage bars, such as 'row1/bar15, row2/bar15'; bar k stands between rollers k and k + 1", run_time=True
    )

    def raceway_defects(self, ring: str) -> Iterator[tuple[str, RacewayDefect]]:
        """Yield name and defect of every notch with a size on the ``inner`` or ``outer`` raceway."""
        for name, notch in self.present():
            if isinstance(notch, RacewayDefect) and name.startswith(ring):
                yield name, notch

    def roller_defects(self) -> Iterator[tuple[str, RollerDefect]]:
        """Yield name and defect of every notch with a size on a roller."""
        for name, notch in self.present():
            if isinstance(notch, RollerDefect):
                yield name, notch

    def present(self) -> Iterator[tuple[str, RacewayDefect | RollerDefect]]:
        """Yield name and defect of every notch with a size."""
        for name in type(self).model_fields:
            notch = getattr(self, name)
            if isinstance(notch, (RacewayDefect, RollerDefect)) and notch.width > 0.0:
                yield name, notch

    def described(self) -> dict[str, dict[str, float]]:
        """Return the fields of every fault by name; a broken bar is named ``broken_bars.row1/bar15``."""
        found: dict[str, dict[str, float]] = {name: notch.model_dump() for name, notch in self.present()}
        return found | {f"broken_bars.row{row}/bar{bar}": {"row": row, "bar": bar} for row, bar in self.bars()}

    def bars(self) -> list[tuple[int, int]]:
        """Return row and bar of every broken bar, counted from one.

        Raises:
            ValueError: a text that is no list of bars.
        """
        words = [word for word in re.split(r"[,\s]+", self.broken_bars) if word]
        found = [BAR.fullmatch(word) for word in words]
        for word, match in zip(words, found, strict=True):
            if match is None:
                raise ValueError(f"faults.broken_bars: '{word}' is no bar; write row1/bar15, or 'row1/bar15, row2/bar15' for two")
        return [(int(match[1]), int(match[2])) for match in found if match is not None]
