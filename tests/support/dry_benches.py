"""The bench `dry` with the notches and broken bars of `bags/`, for tests whose numbers belong to it."""

from __future__ import annotations

from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration

OUTER = "faults.outer_1.width=0.002"
INNER = "faults.inner_1.width=0.002"
FAULTS = {
    "healthy": (),
    "outer_ring_defect": (OUTER,),
    "inner_ring_defect": (INNER,),
    "cage_fracture": ("faults.broken_bars=row1/bar15, row2/bar15",),
    "compound": (OUTER, "faults.outer_1.row=1", INNER, "faults.inner_1.row=2", "faults.broken_bars=row1/bar15"),
}
"""Settings with which the bench `dry` is the bearing of a recording in `bags/`."""


def dry_bench(name: str, *settings: str) -> Configuration:
    """Return the bench `dry` with the faults of a recording in `bags/`, and settings on top of them."""
    return load_configuration("dry", (*FAULTS[name], *settings))
