"""A scenario as it is asked and marked: what is true, and since when."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Question:
    """What a detector should have said of a run."""

    name: str
    verdict: str
    """The right verdict from the onset on; before it, healthy is right."""
    duration: float
    """Simulated time [s]."""
    onset: float = 0.0
    """Since when the verdict is right [s]; without meaning where the bearing is healthy."""
    tags: Mapping[str, str | float] = field(default_factory=dict)
    """Kind and width [m] of the fault, speed [rad/s], load [N] and whatever the exam adds."""
    twin: str = ""
    """Name of the same run without the fault; empty where there is none."""
    first_onset: float | None = None
    """When the first of several faults came [s], where that is before the onset; alarms are false until then."""
    required: bool = True
    """Whether missing it fails the exam; else it counts for the statistics alone."""
    begin: float = 0.0
    """When the signal begins [s]; a recording may begin in the middle of a run."""
    bearing_onset: float | None = None
    """Since when the bearing is at fault too, where the sensor hides it [s]; none where the bearing is sound."""

    @property
    def faulty(self) -> bool:
        """Whether there is something to find."""
        return self.verdict != "healthy"

    @property
    def end(self) -> float:
        """When the signal ends [s]."""
        return self.begin + self.duration

    @property
    def clean_until(self) -> float:
        """Until when every alarm is a false one [s]."""
        if not self.faulty:
            return self.end
        return self.onset if self.first_onset is None else self.first_onset

    @property
    def bearing_clean_until(self) -> float:
        """Until when an alarm on the bearing is a false one [s]."""
        if self.verdict != "sensor":
            return self.clean_until
        return self.end if self.bearing_onset is None else self.bearing_onset

    @property
    def width(self) -> float:
        """Width of the largest defect [m]; 0 where there is none."""
        width = self.tags.get("width", 0.0)
        return width if isinstance(width, float) else 0.0
