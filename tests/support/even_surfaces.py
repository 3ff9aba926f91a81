"""Surfaces with heights that are all zero: the kernels of the shipped benches, compiled anyway, on a bearing that is perfectly even."""

from __future__ import annotations

from typing import Any

SPREADS = ("roller_spread", "clearance_spread", "row_spread", "run_out", "pocket_spread", "pocket_clearance_spread", "cage_unbalance")
EVEN: dict[str, Any] = {"law": "profile", "waviness": 0, "waviness_spread": 0, "roundness": 0} | dict.fromkeys(SPREADS, 0)
"""Settings of the group `surfaces`."""
