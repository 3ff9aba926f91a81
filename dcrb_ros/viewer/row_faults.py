"""The faults of one row in the ground truth: their positions in the picture, and their texts."""

from __future__ import annotations

from typing import NamedTuple

from dcrb_ros.faults.ground_truth import kind_of, words_of
from dcrb_ros.schema.verdicts import Component
from dcrb_ros.stream.block import Truth


class RacewayMark(NamedTuple):
    """A stretch of a raceway that is drawn as damaged."""

    ring: Component
    azimuth: float
    """Azimuth of its middle [rad]; of the inner ring at rotation angle zero."""
    width: float
    """Width along the raceway [m]."""


class RowFaults(NamedTuple):
    """The faults of one row."""

    raceways: tuple[RacewayMark, ...] = ()
    bars: tuple[int, ...] = ()
    """Broken bars, counted from one."""
    words: tuple[str, ...] = ()
    """Every fault in a few words."""


def faults_of_row(truth: Truth, row: int) -> RowFaults:
    """Return the faults of a row, counted from 0, in the order of their names.

    A fault of a ring with an azimuth and a width is drawn on its raceway, one with the number of a bar at the cage.
    """
    faults = {name: fault for name, fault in sorted(truth.faults.items()) if int(fault.get("row", 0)) in (0, row + 1)}
    marks = []
    for name, fault in faults.items():
        kind = kind_of(name)
        if kind and kind.component in ("outer_ring", "inner_ring") and {"azimuth", "width"} <= set(fault):
            marks.append(RacewayMark(kind.component, float(fault["azimuth"]), float(fault["width"])))
    return RowFaults(
        tuple(marks),
        tuple(sorted(int(fault["bar"]) for fault in faults.values() if "bar" in fault)),
        tuple(words_of(name, fault) for name, fault in faults.items()),
    )
