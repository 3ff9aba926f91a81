"""The expected diagnosis of a scenario: which verdict is correct, and from when on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from dcrb_ros.exam.revolutions import Knot, revolutions
from dcrb_ros.schema.arrays import Floats

FEWEST_REVOLUTIONS = 10.0
"""Revolutions from which on a bearing can be judged [-]: a broken bar strikes once in 2.2 to 2.5 revolutions, so four times in them."""


@dataclass(frozen=True)
class Expectation:
    """The ground truth of a scenario, as the evaluation needs it."""

    name: str
    verdict: str
    """Correct verdict from the onset on; before the onset the correct verdict is healthy."""
    duration: float
    """Simulated time [s]."""
    onset: float = 0.0
    """Time from which the verdict is correct [s]; unused if the bearing is healthy."""
    tags: Mapping[str, str | float] = field(default_factory=dict)
    """Kind and width [m] of the fault, speed [rad/s], load [N] and the tags of the exam file."""
    twin: str = ""
    """Name of the same scenario without the fault; empty if there is none."""
    first_onset: float | None = None
    """Onset of the first of several faults [s], if it precedes `onset`; alarms before it are false."""
    required: bool = True
    """Whether a missed detection fails the exam; if false, the scenario enters the statistics only."""
    begin: float = 0.0
    """Start of the signal [s]; a recording may start in the middle of a run."""
    bearing_onset: float | None = None
    """Onset of a bearing fault hidden by a sensor fault [s]; None if the bearing is healthy."""
    last_verdict: bool = False
    """Whether the answer is the last verdict from the onset on, instead of the most frequent one; also of a healthy bearing."""
    lead: str = ""
    """Name of the healthy signal that ends at the onset, which several scenarios may share; empty if there is none."""
    speeds: tuple[Knot, ...] = ()
    """Times [s] and speeds [rad/s] between which the speed is linear; if empty, it is constant at the tag ``speed``."""

    @property
    def faulty(self) -> bool:
        """Whether there is a fault to detect."""
        return self.verdict != "healthy"

    @property
    def end(self) -> float:
        """End of the signal [s]."""
        return self.begin + self.duration

    @property
    def clean_until(self) -> float:
        """Time before which every alarm is false [s]."""
        if not self.faulty:
            return self.end
        return self.onset if self.first_onset is None else self.first_onset

    @property
    def bearing_clean_until(self) -> float:
        """Time before which every bearing alarm is false [s]."""
        if self.verdict != "sensor":
            return self.clean_until
        return self.end if self.bearing_onset is None else self.bearing_onset

    @property
    def healthy_span(self) -> tuple[float, float]:
        """Begin and end of the time during which a bearing alarm is false, without the part that the twin contains [s]."""
        return self.onset if self.twin else self.begin, self.bearing_clean_until

    @property
    def healthy_parts(self) -> Mapping[str, float]:
        """Length of each recording in this time by its name [s]."""
        begin, end = self.healthy_span
        if not self.lead:
            return {self.name: end - begin}
        return {self.lead: self.onset - begin, self.name: end - self.onset}

    @property
    def grade(self) -> tuple[str, float] | None:
        """Parameter that grades the scenario, if it is not the width, and its value."""
        parameter, value = self.tags.get("graded_by"), self.tags.get("grade")
        return (parameter, value) if isinstance(parameter, str) and isinstance(value, float) else None

    def revolutions(self, begin: float, end: float) -> float:
        """Return the shaft revolutions from ``begin`` to ``end`` [s], in either direction [-]."""
        return revolutions(self._knots, begin, end)

    @cached_property
    def _knots(self) -> Floats:
        """Times [s] and speeds [rad/s], shape (knots, 2); none if the speed is unknown."""
        speed = self.tags.get("speed")
        return np.array(self.speeds or ([(0.0, speed)] if isinstance(speed, float) else []), np.float64)

    @property
    def speed_known(self) -> bool:
        """Whether the speed of the shaft is known."""
        return len(self._knots) > 0

    def judgeable(self, begin: float, end: float) -> bool:
        """Return whether the shaft turns enough between two times [s] for a verdict; also if its speed is unknown."""
        return not self.speed_known or self.revolutions(begin, end) >= FEWEST_REVOLUTIONS

    @property
    def width(self) -> float:
        """Width of the largest defect [m]; 0 without one."""
        width = self.tags.get("width", 0.0)
        return width if isinstance(width, float) else 0.0


def repeated_time(expectations: Sequence[Expectation]) -> float:
    """Return the healthy time that is counted again because one recording precedes several others [s]."""
    parts: dict[str, list[float]] = {}
    for expectation in expectations:
        for name, seconds in expectation.healthy_parts.items():
            parts.setdefault(name, []).append(seconds)
    leads = sorted({expectation.lead for expectation in expectations} - {""})
    return sum(sum(parts[lead]) - max(parts[lead]) for lead in leads)
