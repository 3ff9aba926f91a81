"""The result of the comparing detector of a vehicle at the end of a hop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from dcrb_ros.schema.verdicts import COMPONENTS, is_alarm
from dcrb_ros.stream.diagnosis import Diagnosis

UNDECIDED = "undecided"
"""Verdict where the signals allow several causes."""
QUIET_VERDICTS = ("healthy", UNDECIDED, "waiting")
"""Verdicts that any status may have and that report nothing."""
BOX_PARTS = ("bearing", "wheel", "sensor")
"""Parts of a box that have a status each."""
VEHICLE_VERDICTS: dict[str, tuple[str, ...]] = {
    "bearing": (*COMPONENTS, "lubrication", "overheating", "compound"),
    "wheel": ("flat", "polygon", "unbalance"),
    "sensor": ("sensor", "swapped", "clock"),
    "gear": ("gear", "motor"),
    "track": ("joint", "crossing", "corrugation"),
}
"""Verdicts of each kind of status besides `QUIET_VERDICTS`; those of the gear and of the track name a cause, which is no fault."""


@dataclass(frozen=True)
class Status:
    """The verdict on one part of a vehicle."""

    verdict: str
    reason: str
    """The evidence in one sentence."""
    confidence: float = 0.0
    """Probability that the verdict is right: 0.5 at a threshold; 0 without a verdict."""
    score: float = 0.0
    """Evidence relative to its threshold [dB]."""


@dataclass(frozen=True)
class VehicleDiagnosis:
    """The result of the comparing detector at the end of one hop."""

    index: int
    """Index of the last sample of the hop."""
    time: float
    """Time of that sample [s]."""
    statuses: Mapping[str, Status]
    """By name: ``axle_1/left/bearing``, ``axle_1/left/wheel`` and ``axle_1/left/sensor`` of each box, ``axle_1/gear`` of each wheelset with
    a gear, and ``track``."""
    indicators: Mapping[str, float]
    """Quantities behind the verdicts by name, such as ``axle_1/left/BPFO`` [dB] or ``left/lag`` [s]."""
    boxes: Mapping[str, Diagnosis] = field(default_factory=dict)
    """The diagnosis of each box by itself, by name."""

    @property
    def time_ns(self) -> int:
        """Time of the last sample [ns]."""
        return round(self.time * 1e9)

    def damaged(self) -> dict[str, str]:
        """Return the verdicts on the bearings that report a fault, by box."""
        ending = "/bearing"
        return {
            name.removesuffix(ending): status.verdict
            for name, status in self.statuses.items()
            if name.endswith(ending) and is_alarm(status.verdict) and status.verdict != UNDECIDED
        }


def kind_of(name: str) -> str:
    """Return the kind of a status by its name: bearing, wheel, sensor, gear or track."""
    return name.rsplit("/", 1)[-1]
