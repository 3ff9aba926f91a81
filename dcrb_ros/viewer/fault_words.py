"""The faults of the ground truth, as the viewer shows and names them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from dcrb_ros.simulation.block import Truth


class RacewayFault(NamedTuple):
    """A defect of a raceway."""

    name: str
    azimuth: float
    """Azimuth of its middle [rad]; of the inner ring at rotation angle zero."""
    width: float
    """Width along the raceway [m]."""


class RowFaults(NamedTuple):
    """What is wrong with a row."""

    raceways: tuple[RacewayFault, ...] = ()
    bars: tuple[int, ...] = ()
    """Broken bars, counted from one."""
    words: tuple[str, ...] = ()
    """Every fault in a few words."""


def words_of(name: str, fault: Mapping[str, Any]) -> str:
    """Return a fault in a few words."""
    if name.startswith("broken_bars"):
        return f"bar {int(fault['bar'])} broken"
    if name.startswith("sensor."):
        return f"sensor {name.removeprefix('sensor.')}"
    size = f"{float(fault['width']) * 1e3:g} mm wide"
    return f"{name}: {size} on roller {int(fault['roller'])}" if name.startswith("roller") else f"{name}: {size}"


def faults_of_row(truth: Truth, row: int) -> RowFaults:
    """Return the faults of a row, counted from 0, in the order of their names."""
    found = {name: fault for name, fault in sorted(truth.faults.items()) if int(fault.get("row", 0)) in (0, row + 1)}
    raceways = (name for name in found if name.startswith(("inner", "outer")))
    return RowFaults(
        tuple(RacewayFault(name, float(found[name]["azimuth"]), float(found[name]["width"])) for name in raceways),
        tuple(sorted(int(fault["bar"]) for name, fault in found.items() if name.startswith("broken_bars"))),
        tuple(words_of(name, fault) for name, fault in found.items()),
    )
