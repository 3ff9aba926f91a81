"""An entry of the leaderboard: the results of one detector in one exam, as a file from which all tables can be computed again."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError

from dcrb_ros.exam.breakdown import difficulty, family_areas, overall_area
from dcrb_ros.exam.credit import Credit
from dcrb_ros.exam.exam_score import Contribution, ExamScore, exam_scores
from dcrb_ros.exam.profile import PROFILES
from dcrb_ros.exam.report import Report
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import first_problem
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import FaultClass
from dcrb_ros.text.files import checked_path, read_text
from dcrb_ros.text.json import LARGEST, parsed_json
from dcrb_ros.text.writing import write_whole

FORMAT: Literal["dcrb exam entry 1"] = "dcrb exam entry 1"
AGREEMENT = 1e-4
"""Largest difference between the exam scores stated in an entry and those computed again from its scenarios [-]."""


class EntryScenario(Group):
    """A scenario of an entry."""

    name: str
    family: FaultClass
    """Correct verdict."""
    stratum: str | None
    """Difficulty; None without a fault."""
    required: bool
    answer: str
    found: bool
    delay_turns: float | None = Field(ge=0.0)
    """Detection delay in shaft revolutions [-]."""
    evidence: float | None
    """Largest published score [-]."""
    credit: dict[str, float]
    """Credit for the fault by profile, 0 .. 1 [-]."""
    periods: int = Field(ge=0)
    """Healthy periods [-]."""
    spoiled: int = Field(ge=0)
    """Healthy periods with a false alarm or without a verdict [-]."""
    silent: float = Field(ge=0.0)
    """Time without a verdict [s]."""


class Entry(Group):
    """The results of one detector in one exam."""

    format: Literal["dcrb exam entry 1"]
    detector: str = Field(min_length=1, max_length=200)
    exam: str
    scenarios_sha256: str
    """Hash of the scenarios; empty for recordings."""
    sealed_sha256: str
    """Hash that was published before a sealed exam; empty if it was not sealed."""
    dcrb_ros: str
    model: str
    """Fingerprint of the simulation's sources."""
    software: dict[str, str]
    seeds: list[int] = Field(default_factory=list)
    """Seeds of the simulations; none for recordings."""
    passed: bool
    exam_score: dict[str, float]
    """Exam score by profile, 0 .. 100 [-]."""
    area: float | None
    """Harmonic mean of the areas and partial areas of all families [-]."""
    false_alarms: int = Field(ge=0)
    healthy_hours: float = Field(ge=0.0)
    scenarios: list[EntryScenario] = Field(min_length=1)

    def contributions(self) -> list[Contribution]:
        """Return what each scenario contributes to the exam score."""
        return [Contribution(s.name, s.family, Credit(s.credit, s.periods, s.spoiled, s.silent)) for s in self.scenarios]

    def scores(self) -> list[ExamScore]:
        """Return the exam score for every profile, computed from the scenarios."""
        return exam_scores(self.contributions())


def entry_of(report: Report, name: str = "") -> Entry:
    """Return the entry of a report, under another name of the detector if one is given."""
    area = overall_area(family_areas(report.results))
    return Entry(
        format=FORMAT,
        detector=name or report.detector[:200],
        exam=report.exam,
        scenarios_sha256=report.scenarios,
        sealed_sha256=report.seal,
        dcrb_ros=__version__,
        model=model_fingerprint(),
        software={key: str(value) for key, value in software().items()},
        seeds=list(report.seeds),
        passed=report.passed,
        exam_score={score.profile: score.score.value for score in report.exam_scores()},
        area=area if math.isfinite(area) else None,
        false_alarms=report.alarms,
        healthy_hours=report.hours,
        scenarios=[
            EntryScenario(
                name=result.expectation.name,
                family=result.expectation.verdict,
                stratum=difficulty(result.expectation, report.criteria)[1] if result.expectation.faulty else None,
                required=result.expectation.required,
                answer=result.answer,
                found=result.found,
                delay_turns=result.delay_revolutions,
                evidence=result.score,
                credit=dict(result.credit.detection),
                periods=result.credit.periods,
                spoiled=result.credit.failed,
                silent=result.credit.silent,
            )
            for result in report.results
        ],
    )


def write_entry(entry: Entry, file: Path) -> None:
    """Write an entry as one line of JSON.

    Raises:
        Refusal: the file cannot be written.
    """
    write_whole(file, json.dumps(entry.model_dump(), separators=(",", ":"), allow_nan=False) + "\n")


def read_entry(path: Path) -> Entry:
    """Return the entry in a file.

    Raises:
        Refusal: the file cannot be read or is not an entry, or its exam scores do not follow from its scenarios.
    """
    tree: Any = parsed_json(read_text(checked_path(path), LARGEST), str(path))
    try:
        entry = Entry.model_validate(tree)
    except ValidationError as error:
        problem = first_problem(error)
        raise Refusal(f"{path} is not an entry ({problem.key or 'the file'}: {problem.reason}): make it with dcrb score --entry") from None
    _check(entry, path)
    return entry


def _check(entry: Entry, path: Path) -> None:
    names = [scenario.name for scenario in entry.scenarios]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise Refusal(f"{path} has the scenario '{twice}' twice: make it again with dcrb score --entry")
    profiles = {profile.name for profile in PROFILES}
    for scenario in entry.scenarios:
        faulty = scenario.family != "healthy"
        invalid = set(scenario.credit) != (profiles if faulty else set()) or not all(
            0.0 <= credit <= 1.0 for credit in scenario.credit.values()
        )
        if invalid or scenario.spoiled > scenario.periods:
            raise Refusal(f"{path} has an impossible credit in the scenario '{scenario.name}': make it again with dcrb score --entry")
    computed = {score.profile: score.score.value for score in entry.scores()}
    if set(computed) != set(entry.exam_score) or any(abs(entry.exam_score[key] - value) > AGREEMENT for key, value in computed.items()):
        raise Refusal(f"{path} states exam scores that do not follow from its scenarios: make it again with dcrb score --entry")
