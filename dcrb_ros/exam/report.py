"""What an exam brought: figures, checks and the verdict on the detector."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from dcrb_ros import __version__
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.marking import NOTHING, Mark
from dcrb_ros.exam.opinion import VERDICTS, WAITING
from dcrb_ros.exam.statistics import Characteristic, Interval, characteristic, percentile, rate, share
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.runtime.frames import pandas

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Check:
    """One criterion."""

    name: str
    wanted: str
    got: str
    holds: bool


@dataclass(frozen=True)
class Delay:
    """Delays of one fault."""

    verdict: str
    limit: float
    found: int
    asked: int
    median: float
    late: float
    """95th percentile [s]."""


@dataclass(frozen=True)
class Detection:
    """How many defects of one kind and width were found."""

    verdict: str
    width: float
    """Width [m]."""
    found: int
    asked: int

    @property
    def probability(self) -> Interval:
        """Probability of detection with its bounds."""
        return share(self.found, self.asked)


@dataclass(frozen=True)
class Report:
    """The marks of an exam and what follows from them."""

    exam: str
    detector: str
    criteria: Criteria
    scenarios: str
    """SHA-256 of the scenarios; empty where they came as recordings."""
    marks: tuple[Mark, ...]

    @property
    def passed(self) -> bool:
        """Whether every criterion holds."""
        return all(check.holds for check in self.checks())

    @property
    def faulty(self) -> list[Mark]:
        """The marks of scenarios with something to find."""
        return [mark for mark in self.marks if mark.question.faulty]

    @property
    def hours(self) -> float:
        """Healthy time [h]."""
        return sum(mark.healthy_time for mark in self.marks) / 3600.0

    @property
    def alarms(self) -> int:
        """False alarms in the healthy time."""
        return sum(mark.counted_alarms for mark in self.marks)

    def alarm_rate(self) -> Interval:
        """Return the false alarms per hour with their bounds."""
        return rate(self.alarms, self.hours)

    def checks(self) -> list[Check]:
        """Return every criterion, and whether it holds."""
        required = [mark for mark in self.faulty if mark.question.required]
        found = sum(mark.found for mark in required)
        broken = [mark for mark in self.marks if mark.broken]
        limit, ratio = self.criteria.found, found / len(required) if required else 1.0
        named = " and named right" if self.criteria.name_right else ""
        return [
            Check(f"required faults found in time{named}", f"at least {limit:.0%}", f"{found} of {len(required)}", ratio >= limit),
            Check("false alarms", f"at most {self.criteria.false_alarms}", str(self.alarms), self.alarms <= self.criteria.false_alarms),
            Check("scenarios without a verdict", "0", str(len(broken)), not broken),
        ]

    def delays(self) -> list[Delay]:
        """Return the delays of each fault that was asked for."""
        return [
            Delay(verdict, self.criteria.delay.of(verdict), len(found), len(asked), percentile(found, 50.0), percentile(found, 95.0))
            for verdict, asked in _grouped(self.faulty).items()
            for found in [[mark.delay for mark in asked if mark.delay is not None and mark.found]]
        ]

    def confusion(self) -> dict[str, dict[str, int]]:
        """Return how often each right verdict got each answer."""
        return {
            verdict: {answer: sum(m.answer == answer for m in asked) for answer in (*VERDICTS, WAITING, NOTHING)}
            for verdict, asked in _grouped(self.marks).items()
        }

    def detections(self) -> list[Detection]:
        """Return the probability of detection of each kind and width."""
        sized = [mark for mark in self.faulty if mark.question.width > 0.0]
        return [
            Detection(verdict, width, sum(mark.found for mark in same), len(same))
            for verdict, asked in _grouped(sized).items()
            for width in sorted({mark.question.width for mark in asked})
            for same in [[mark for mark in asked if mark.question.width == width]]
        ]

    def characteristic(self) -> Characteristic | None:
        """Return the receiver operating characteristic of bearing faults; none where the detector publishes no evidence."""
        faulty = [mark.score for mark in self.faulty if mark.score is not None and mark.question.verdict != "sensor"]
        healthy = [mark.score for mark in self.marks if mark.score is not None and not mark.question.faulty]
        return characteristic(faulty, healthy)

    def __repr__(self) -> str:
        return f"<Report: {self.detector} {'passed' if self.passed else 'failed'} {self.exam}, {len(self.marks)} scenarios>"

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame with a row per scenario: right verdict, answer, onset and delay [s], number of false alarms, passed.

        Raises
        ------
        Refusal
            pandas is not installed.
        """
        rows = [
            {
                "right": mark.question.verdict,
                "answer": mark.answer,
                "onset": mark.question.onset if mark.question.faulty else None,
                "delay": mark.delay,
                "false_alarms": len(mark.false_alarms),
                "passed": mark.passed,
            }
            for mark in self.marks
        ]
        return pandas().DataFrame(rows, index=pandas().Index([mark.question.name for mark in self.marks], name="scenario"))

    def described(self) -> dict[str, Any]:
        """Return everything as a tree for JSON; what does not exist is null."""
        curve, alarms = self.characteristic(), self.alarm_rate()
        tree = {
            "exam": self.exam,
            "detector": self.detector,
            "passed": self.passed,
            "scenarios_sha256": self.scenarios or None,
            "dcrb_ros": __version__,
            "model": model_fingerprint(),
            "software": software(),
            "criteria": self.criteria.model_dump(),
            "checks": [vars(check) for check in self.checks()],
            "delay": {
                d.verdict: {"limit": d.limit, "found": d.found, "asked": d.asked, "median": d.median, "p95": d.late} for d in self.delays()
            },
            "false_alarms": {"count": self.alarms, "healthy_hours": self.hours, "per_hour": alarms._asdict()},
            "confusion": self.confusion(),
            "detection": [
                {"verdict": d.verdict, "width": d.width, "found": d.found, "asked": d.asked, "probability": d.probability._asdict()}
                for d in self.detections()
            ],
            "roc": curve._asdict() if curve else None,
            "scenarios": [_described(mark) for mark in self.marks],
        }
        finite: dict[str, Any] = _finite(tree)
        return finite


def _grouped(marks: Iterable[Mark]) -> dict[str, list[Mark]]:
    """Return marks by right verdict, in the order of `VERDICTS`."""
    found = list(marks)
    groups = {verdict: [mark for mark in found if mark.question.verdict == verdict] for verdict in VERDICTS}
    return {verdict: group for verdict, group in groups.items() if group}


def _described(mark: Mark) -> dict[str, Any]:
    question = mark.question
    return {
        "name": question.name,
        "verdict": question.verdict,
        "answer": mark.answer,
        "passed": mark.passed,
        "required": question.required,
        "flaw": mark.flaw,
        "onset": question.onset if question.faulty else None,
        "begin": question.begin,
        "duration": question.duration,
        "delay": mark.delay,
        "alarm_delay": mark.alarm_delay,
        "false_alarms": [vars(alarm) for alarm in mark.false_alarms],
        "score": mark.score,
        "opinions": mark.opinions,
        "twin": question.twin or None,
        "tags": dict(question.tags),
    }


def _finite(tree: Any) -> Any:
    """Return a tree with null for what is no number: JSON has neither NaN nor infinity."""
    if isinstance(tree, Mapping):
        return {key: _finite(value) for key, value in tree.items()}
    if isinstance(tree, Sequence) and not isinstance(tree, str):
        return [_finite(value) for value in tree]
    return None if isinstance(tree, float) and not math.isfinite(tree) else tree
