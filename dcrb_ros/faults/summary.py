"""Faults in a few words, for the representation of configurations and runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def fault_summary(faults: Mapping[str, Mapping[str, Any]]) -> str:
    """Return faults by name, as the ground truth has them, as text: ``outer_1 2 mm wide, sensor.stuck``; ``healthy`` without any."""
    words = (f"{name} {float(fault['width']) * 1e3:g} mm wide" if "width" in fault else name for name, fault in faults.items())
    return ", ".join(words) or "healthy"
