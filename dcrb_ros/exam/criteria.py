"""The criteria of an exam, all of which a detector must meet to pass."""

from __future__ import annotations

from dcrb_ros.schema.fields import Group, choice, quantity


class DelayLimits(Group):
    """Longest detection delay for each fault: time from the onset to the correct verdict."""

    outer_ring: float = quantity(5.0, "s", "Longest delay of the verdict outer_ring", 0.0, 1e6)
    inner_ring: float = quantity(5.0, "s", "Longest delay of the verdict inner_ring", 0.0, 1e6)
    roller: float = quantity(5.0, "s", "Longest delay of the verdict roller", 0.0, 1e6)
    cage: float = quantity(20.0, "s", "Longest delay of the verdict cage", 0.0, 1e6)
    lubrication: float = quantity(20.0, "s", "Longest delay of the verdict lubrication", 0.0, 1e6)
    overheating: float = quantity(20.0, "s", "Longest delay of the verdict overheating", 0.0, 1e6)
    compound: float = quantity(5.0, "s", "Longest delay of the verdict compound", 0.0, 1e6)
    sensor: float = quantity(5.0, "s", "Longest delay of the verdict sensor", 0.0, 1e6)

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
    silence: float = quantity(5.0, "s", "Longest time without a diagnosis, also at the beginning", 0.0, 1e6)
    name_right: bool = choice(True, "Whether the verdict must name the fault; if false, any bearing fault verdict counts as correct")
