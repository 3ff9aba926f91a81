"""Baselines of bearings that are known to be loud when healthy.

The simulated bearing of the paper has no roughness, no lubricant and much radial clearance, so its idle rollers strike the raceway at BPFO
as they enter the load zone. Those lines modulate the squared envelope as deeply as a defect's, and only their size tells the two apart. The
baseline applies to the bearing with exactly this geometry, which is in the description of its sensor. It does not apply to measured ones.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple


class Baseline(NamedTuple):
    """Sizes of the BPFO lines of a healthy bearing, scaled to a shaft frequency of 20 Hz, with a margin of 3 dB."""

    whole: float
    """In the whole band [m/s^2]."""
    high: float
    """In the upper quarter of the band [m/s^2]."""


PAPER_BEARING = {
    "rollers_per_row": 16.0,
    "inner_raceway_radius": 0.07886,
    "outer_raceway_radius": 0.10914,
    "pitch_radius": 0.094,
    "roller_radius": 0.015,
}
"""Geometry of the bearing of Fan et al. 2025, Table 1, with a diametral clearance of 0.28 mm [m]."""
PAPER_BASELINE = Baseline(38.0, 12.0)
"""Healthy runs at 300 to 3820 rpm and 30 to 160 kN have up to 26 and, with a resonant mount, 10 m/s^2."""


def baseline_of(bearing: object) -> Baseline | None:
    """Return the baseline of a described bearing, a mapping of the fields of `dcrb_ros.Bearing` or such an object; None for any other."""
    for name, value in PAPER_BEARING.items():
        given = bearing.get(name) if isinstance(bearing, Mapping) else getattr(bearing, name, None)
        if isinstance(given, bool) or not isinstance(given, (int, float)) or not math.isclose(given, value, rel_tol=1e-6):
            return None
    return PAPER_BASELINE
