"""The criteria of an exam, all of which a detector must meet to pass."""

from __future__ import annotations

from typing import Any

from pydantic import create_model

from dcrb_ros.schema.fields import Group, choice, quantity
from dcrb_ros.schema.verdicts import FAULTS

UNLIMITED = 1e6
"""Largest delay and silence of the criteria [s]: neither counts, because the last verdict does."""

_LIMITS: dict[str, Any] = {
    name: (float, quantity(fault.delay, "s", f"Longest delay of the verdict {name}", 0.0, UNLIMITED)) for name, fault in FAULTS.items()
}


class DelayLimits(create_model("DelayLimits", __base__=Group, **_LIMITS)):  # type: ignore[misc] # one field for each fault
    """Longest detection delay for each fault: time from the onset to the correct verdict."""

    def of(self, verdict: str) -> float:
        """Return the limit for a verdict [s]."""
        return float(getattr(self, verdict))


class Criteria(Group):
    """Requirements on a detector."""

    delay: DelayLimits = DelayLimits()
    found: float = quantity(1.0, "-", "Smallest share of the required faults to be detected in time with the correct verdict", 0.0, 1.0)
    smallest_width: float = quantity(
        0.001, "m", "Defects narrower than this are not required; they enter the statistics only", 0.0, 0.05, remedy="widths are in metres"
    )
    false_alarms: int = quantity(0, "-", "Largest number of false alarms during the whole healthy time", 0, 1_000_000)
    silence: float = quantity(5.0, "s", "Longest time without a diagnosis, also at the beginning", 0.0, UNLIMITED)
    name_right: bool = choice(True, "Whether the verdict must name the fault; if false, any bearing fault verdict counts as correct")
