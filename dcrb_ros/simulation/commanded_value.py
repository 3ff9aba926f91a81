"""The range of a commanded speed or load: that of the parameter of operation."""

from __future__ import annotations

import math

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import Operating


def commanded(name: str, key: str, value: float, unit: str) -> float:
    """Return a commanded value that is within the range of a parameter of operation."""
    low, high = (
        next((m.ge for m in Operating.model_fields[key].metadata if hasattr(m, "ge")), -math.inf),
        next((m.le for m in Operating.model_fields[key].metadata if hasattr(m, "le")), math.inf),
    )
    if not (math.isfinite(value) and low <= value <= high):
        raise Refusal(
            f"{name} = {value} {unit} is refused: it must be a number within {low:g} .. {high:g} {unit}; "
            "the previous command remains in effect"
        )
    return float(value)
