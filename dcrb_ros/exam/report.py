"""The report of an exam: statistics, the check of every criterion, and whether the detector passed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from dcrb_ros.exam.breakdown import compared_scores, family_areas, overall_area, strata
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.exam_score import SEED, Contribution, ExamScore, exam_scores
from dcrb_ros.exam.expectation import repeated_time
from dcrb_ros.exam.scoring import NO_ANSWER, ScenarioResult
from dcrb_ros.exam.statistics import Characteristic, Interval, characteristic, percentile, rate, share
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.runtime.frames import pandas
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.verdicts import FAULT_CLASSES, VERDICTS, is_alarm
from dcrb_ros.text.json import with_nulls

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Check:
    """The check of one criterion."""

    name: str
    wanted: str
    got: str
    holds: bool


@dataclass(frozen=True)
class Delay:
    """Detection delays of one fault."""

    verdict: str
    limit: float
    """Longest delay allowed [s]."""
    found: int
    """Scenarios in which the fault was detected [-]."""
    scenarios: int
    """Scenarios with the fault [-]."""
    median: float
    """Median delay [s]."""
    p95: float
    """95th percentile of the delay [s]."""
    turns: float
    """Median delay in shaft revolutions [-]; NaN if the speed is unknown."""


@dataclass(frozen=True)
class Detection:
    """Detections of faults of one kind and grade."""

    verdict: str
    parameter: str
    """Key of the parameter that the scenario names in ``graded_by``; ``width`` of a defect without it."""
    value: float
    """Its value, in the unit of the parameter; the width in [m]."""
    found: int
    """Scenarios in which the fault was detected [-]."""
    scenarios: int
    """Scenarios with the fault [-]."""

    @property
    def probability(self) -> Interval:
        """Probability of detection with its confidence interval."""
        return share(self.found, self.scenarios)


@dataclass(frozen=True)
class RigResult:
    """Correct answers on one rig for one verdict."""

    rig: str
    verdict: str
    """Correct verdict."""
    right: int
    """Recordings with the correct answer [-]."""
    alarms: int
    """Recordings with any alarm [-]."""
    recordings: int
    """[-]"""


@dataclass(frozen=True)
class Report:
    """The results of an exam and the statistics derived from them."""

    exam: str
    detector: str
    criteria: Criteria
    scenarios: str
    """SHA-256 of the scenarios; empty if they are recordings."""
    results: tuple[ScenarioResult, ...]
    seal: str = ""
    """Hash that was published before a sealed exam; empty if it was not sealed."""
    seeds: tuple[int, ...] = ()
    """Seeds of the simulations; none for recordings."""

    @property
    def passed(self) -> bool:
        """Whether every criterion is met."""
        return all(check.holds for check in self.checks())

    @property
    def last_verdict(self) -> bool:
        """Whether all answers are last verdicts, so that neither delays nor silence count."""
        return all(result.expectation.last_verdict for result in self.results)

    @property
    def faulty(self) -> list[ScenarioResult]:
        """The results of the scenarios with a fault."""
        return [result for result in self.results if result.expectation.faulty]

    @property
    def hours(self) -> float:
        """Healthy time [h]."""
        return sum(result.healthy_time for result in self.results) / 3600.0

    @property
    def distinct_hours(self) -> float:
        """Healthy time in which a recording that precedes several others counts once [h]."""
        return self.hours - repeated_time([result.expectation for result in self.results]) / 3600.0

    @property
    def repeats(self) -> float:
        """How often the healthy time is counted on average [-]; 1 if no recording precedes several others."""
        return self.hours / self.distinct_hours if self.distinct_hours else 1.0

    @property
    def alarms(self) -> int:
        """False alarms in the healthy time."""
        return sum(result.counted_alarms for result in self.results)

    def alarm_rate(self) -> Interval:
        """Return the false alarm rate with its confidence interval [1/h]."""
        return rate(self.alarms, self.hours, self.repeats)

    def alarm_rate_per_turn(self) -> Interval:
        """Return the number of false alarms per million shaft revolutions with its confidence interval [-]."""
        return rate(self.alarms, self.healthy_revolutions / 1e6, self.repeats)

    @property
    def healthy_revolutions(self) -> float:
        """Shaft revolutions in the healthy time [-]."""
        return math.fsum(result.healthy_revolutions for result in self.results)

    def contributions(self) -> list[Contribution]:
        """Return the contribution of each scenario to the exam score."""
        return [Contribution(result.expectation.name, result.expectation.verdict, result.credit) for result in self.results]

    def exam_scores(self) -> list[ExamScore]:
        """Return the exam score for every profile; none without both a fault and healthy time."""
        return exam_scores(self.contributions())

    @property
    def silent_share(self) -> float:
        """Share of the time in which the detector gave no verdict [-]."""
        return math.fsum(r.credit.silent for r in self.results) / math.fsum(r.expectation.duration for r in self.results)

    def checks(self) -> list[Check]:
        """Return the check of every criterion."""
        required = [result for result in self.faulty if result.expectation.required]
        detected = sum(result.found for result in required)
        broken = [result for result in self.results if result.broken]
        limit, ratio = self.criteria.found, detected / len(required) if required else 1.0
        named = " with the correct verdict" if self.criteria.name_right else ""
        return [
            Check(f"required faults detected in time{named}", f"at least {limit:.0%}", f"{detected} of {len(required)}", ratio >= limit),
            Check("false alarms", f"at most {self.criteria.false_alarms}", str(self.alarms), self.alarms <= self.criteria.false_alarms),
            Check("scenarios without a verdict", "0", str(len(broken)), not broken),
        ]

    def delays(self) -> list[Delay]:
        """Return the detection delays of each fault in the exam."""
        return [
            Delay(
                verdict,
                self.criteria.delay.of(verdict),
                len(detected),
                len(group),
                percentile([r.delay for r in detected if r.delay is not None], 50.0),
                percentile([r.delay for r in detected if r.delay is not None], 95.0),
                percentile([r.delay_revolutions for r in detected if r.delay_revolutions is not None and r.expectation.speed_known], 50.0),
            )
            for verdict, group in _grouped(self.faulty).items()
            for detected in [[r for r in group if r.found]]
        ]

    def confusion(self) -> dict[str, dict[str, int]]:
        """Return the confusion matrix: the number of scenarios by correct verdict and answer."""
        return {
            verdict: {answer: sum(m.answer == answer for m in group) for answer in (*VERDICTS, NO_ANSWER)}
            for verdict, group in _grouped(self.results).items()
        }

    def detections(self) -> list[Detection]:
        """Return the probability of detection by kind and width, without scenarios of a replica, of another grade or ``difficulty``."""
        # Equal widths on the bearings of a replica, which have different sizes, are not equal defects.
        sized = [r for r in self.faulty if (e := r.expectation).width and not (e.last_verdict or e.grade or "difficulty" in e.tags)]
        return [
            Detection(verdict, "width", width, sum(result.found for result in same), len(same))
            for verdict, group in _grouped(sized).items()
            for width in sorted({result.expectation.width for result in group})
            for same in [[result for result in group if result.expectation.width == width]]
        ]

    def graded_detections(self) -> list[Detection]:
        """Return the probability of detection over the parameter that a scenario names in ``graded_by``."""
        return [
            Detection(verdict, parameter, value, sum(r.found for r in same), len(same))
            for verdict, group in _grouped(self.faulty).items()
            for parameter, value in sorted({r.expectation.grade for r in group if r.expectation.grade})
            for same in [[r for r in group if r.expectation.grade == (parameter, value)]]
        ]

    def rigs(self) -> list[RigResult]:
        """Return the correct answers by rig and correct verdict; empty if the scenarios have no tag ``rig``."""
        names = sorted({str(result.expectation.tags["rig"]) for result in self.results if "rig" in result.expectation.tags})
        return [
            RigResult(rig, verdict, sum(r.right for r in same), sum(is_alarm(r.answer) for r in same), len(same))
            for rig in names
            for verdict, group in _grouped(self.results).items()
            if (same := [r for r in group if r.expectation.tags.get("rig") == rig])
        ]

    def characteristic(self) -> Characteristic | None:
        """Return the receiver operating characteristic for bearing faults; None if the detector publishes no score."""
        return characteristic(*compared_scores([(result.expectation.verdict, result.score) for result in self.results]))

    def __repr__(self) -> str:
        return f"<Report: {self.detector} {'passed' if self.passed else 'failed'} {self.exam}, {len(self.results)} scenarios>"

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame with a row per scenario: correct verdict, answer, onset and delay [s], number of false alarms, passed.

        Raises
        ------
        Refusal
            pandas is not installed.
        """
        rows = [
            {
                "right": result.expectation.verdict,
                "answer": result.answer,
                "onset": result.expectation.onset if result.expectation.faulty else None,
                "delay": result.delay,
                "false_alarms": len(result.false_alarms),
                "passed": result.passed,
            }
            for result in self.results
        ]
        names = [result.expectation.name for result in self.results]
        return pandas().DataFrame(rows, index=pandas().Index(names, name="scenario"))

    def described(self) -> dict[str, Any]:
        """Return the report as a tree for JSON; a value that does not exist is null."""
        curve, alarms, areas = self.characteristic(), self.alarm_rate(), family_areas(self.results)
        tree: dict[str, Any] = {
            "exam": self.exam,
            "detector": self.detector,
            "passed": self.passed,
            "scenarios_sha256": self.scenarios or None,
            "sealed_sha256": self.seal or None,
            "seeds": list(self.seeds),
            "bootstrap_seed": SEED,
            "dcrb_ros": __version__,
            "model": model_fingerprint(),
            "software": software(),
            "criteria": self.criteria.model_dump(),
            "checks": [vars(check) for check in self.checks()],
            "exam_score": {
                score.profile: {**score.score._asdict(), "detection": score.detection, "clean": score.clean} for score in self.exam_scores()
            },
            "silent_share": self.silent_share if self.results else None,
            "delay": {
                d.verdict: {"limit": d.limit, "found": d.found, "asked": d.scenarios, "median": d.median, "p95": d.p95, "turns": d.turns}
                for d in self.delays()
            },
            "false_alarms": {
                "count": self.alarms,
                "healthy_hours": self.hours,
                "distinct_healthy_hours": self.distinct_hours,
                "per_hour": alarms._asdict(),
                "per_1000_hours": Interval(*(1e3 * value for value in alarms))._asdict(),
                "healthy_turns": self.healthy_revolutions,
                "per_million_turns": self.alarm_rate_per_turn()._asdict(),
            },
            "areas": {"overall": overall_area(areas), "families": [vars(area) for area in areas]},
            "strata": [vars(stratum) for stratum in strata(self.results, self.criteria)],
            "confusion": self.confusion(),
            "detection": [
                {"verdict": d.verdict, "width": d.value, "found": d.found, "asked": d.scenarios, "probability": d.probability._asdict()}
                for d in self.detections()
            ],
            "graded_detection": [{**vars(d), "probability": d.probability._asdict()} for d in self.graded_detections()],
            "rigs": [vars(rig) for rig in self.rigs()],
            "roc": curve._asdict() if curve else None,
            "scenarios": [result.described() for result in self.results],
        }
        return {key: with_nulls(value) for key, value in tree.items()}


def _grouped(results: Sequence[ScenarioResult]) -> dict[str, list[ScenarioResult]]:
    """Return results by correct verdict, in the order of `FAULT_CLASSES`."""
    groups = ((verdict, [r for r in results if r.expectation.verdict == verdict]) for verdict in FAULT_CLASSES)
    return {verdict: group for verdict, group in groups if group}
