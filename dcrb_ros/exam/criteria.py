"""What it takes to pass."""

from __future__ import annotations

from dcrb_ros.schema.fields import Group, choice, quantity


class DelayLimits(Group):
    """Longest time from the onset to the right verdict, of each fault."""

    outer_ring: float = quantity(5.0, "s", "Longest delay of the verdict outer_ring", 0.0, 1e6)
    inner_ring: float = quantity(5.0, "s", "Longest delay of the verdict inner_ring", 0.0, 1e6)
    roller: float = quantity(5.0, "s", "Longest delay of the verdict roller", 0.0, 1e6)
    cage: float = quantity(20.0, "s", "Longest delay of the verdict cage", 0.0, 1e6)
    compound: float = quantity(5.0, "s", "Longest delay of the verdict compound", 0.0, 1e6)
    sensor: float = quantity(5.0, "s", "Longest delay of the verdict sensor", 0.0, 1e6)

    def of(self, verdict: str) -> float:
        """Return the limit of a verdict [s]."""
        return float(getattr(self, verdict))


class Criteria(Group):
    """What a detector must reach."""

    delay: DelayLimits = DelayLimits()
    found: float = quantity(1.0, "-", "Least share of the required faults that are found in time and named right", 0.0, 1.0)
    smallest_width: float = quantity(
        0.001, "m", "Defects narrower than this count for the statistics alone", 0.0, 0.05, remedy="widths are in metres"
    )
    false_alarms: int = quantity(0, "-", "Most false alarms in all the healthy time", 0, 1_000_000)
    silence: float = quantity(5.0, "s", "Longest time without a diagnosis, at the beginning too", 0.0, 1e6)
    name_right: bool = choice(True, "Whether a fault must be named; else any alarm on the bearing will do")
