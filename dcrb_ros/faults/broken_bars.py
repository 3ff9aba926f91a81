"""Broken cage bars; the rollers beside one leave their places once in a turn of the cage, which excites FTF and its harmonics."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from dcrb_ros.faults.fault import Dimensions, Fault
from dcrb_ros.faults.geometry import BrokenBar
from dcrb_ros.schema.fields import choice

BAR = re.compile(r"row(\d{1,3})/bar(\d{1,3})")


class BrokenBars(Fault):
    """All broken bars of a bearing; the only kind whose parameter is a text instead of a group."""

    keys = ("broken_bars",)
    component = "cage"

    text: str = ""
    """The bars as configured, such as ``row1/bar15, row2/bar15``."""

    @classmethod
    def parameter(cls) -> tuple[Any, Any]:
        """Return the type of the text and its field."""
        description = "Broken cage bars, such as 'row1/bar15, row2/bar15'; bar k is between rollers k and k + 1"
        return str, choice("", description, run_time=True)

    @classmethod
    def from_parameter(cls, value: Any) -> BrokenBars:
        """Return the bars that a text names."""
        return cls(text=value)

    @property
    def _names(self) -> list[str]:
        return [word for word in re.split(r"[,\s]+", self.text) if word]

    @property
    def present(self) -> bool:
        """Whether the text names a bar."""
        return bool(self._names)

    def bars(self) -> list[tuple[int, int]]:
        """Return row and number of every broken bar, counted from one, leaving out words that name no bar (see `problems`)."""
        matches = [BAR.fullmatch(word) for word in self._names]
        return [(int(match[1]), int(match[2])) for match in matches if match is not None]

    def problems(self, key: str, bearing: Dimensions) -> Iterator[str]:
        """Reject words that name no bar, bars beyond the cage, bars named twice, and a cage with fewer than two bars."""
        for word in self._names:
            if BAR.fullmatch(word) is None:
                yield f"faults.{key}: '{word}' is not a bar; write row1/bar15, or 'row1/bar15, row2/bar15' for two"
        bars = self.bars()
        for row, bar in bars:
            if not (1 <= row <= bearing.rows and 1 <= bar <= bearing.rollers_per_row):
                yield (
                    f"faults.{key}: row{row}/bar{bar} is outside row1/bar1 .. row{bearing.rows}/bar{bearing.rollers_per_row}: "
                    "bar k is between rollers k and k + 1"
                )
        if len(set(bars)) < len(bars):
            yield f"faults.{key} = '{self.text}' names a bar twice: name each once"
        for row in range(1, bearing.rows + 1):
            if sum(at == row for at, _ in set(bars)) > bearing.rollers_per_row - 2:
                yield f"faults.{key} leaves fewer than two bars in row {row}: a cage needs two to drive its rollers"

    def damage(self, bearing: Dimensions, edge_radius: float) -> Iterator[BrokenBar]:
        """Yield every broken bar."""
        for row, bar in self.bars():
            yield BrokenBar(row - 1, bar - 1)

    def described(self, key: str) -> dict[str, dict[str, float]]:
        """Return row and number of each broken bar as ``broken_bars.row1/bar15``."""
        return {f"{key}.row{row}/bar{bar}": {"row": row, "bar": bar} for row, bar in self.bars()}

    def unhealed(self, after: Fault) -> Iterator[str]:
        """Yield a sentence for each bar that ``after`` no longer names."""
        assert isinstance(after, BrokenBars)
        for row, bar in sorted(set(self.bars()) - set(after.bars())):
            yield f"row{row}/bar{bar} is broken and does not heal while the bench runs; keep it, or reset the bench"

    @classmethod
    def words(cls, name: str, fields: Mapping[str, float]) -> str:
        """Return the number of the bar."""
        return f"bar {int(fields['bar'])} broken"
