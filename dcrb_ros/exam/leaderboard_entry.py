"""An entry of the leaderboard: the results of one detector in one exam, as a file from which all tables can be computed again."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError

from dcrb_ros.exam.breakdown import areas_of, difficulty, family_areas, overall_area
from dcrb_ros.exam.credit import Credit
from dcrb_ros.exam.exam_score import Contribution, ExamScore, exam_scores
from dcrb_ros.exam.profile import PROFILES, Profile
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import NO_ANSWER, WAITING
from dcrb_ros.messages.received_diagnosis import LATEST, ReceivedDiagnosis
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import first_problem
from dcrb_ros.schema.refusal import Refusal, repeated
from dcrb_ros.schema.verdicts import BEARING_FAULTS, VERDICTS, FaultClass, is_alarm
from dcrb_ros.text.files import checked_path, read_text
from dcrb_ros.text.json import digest_of, parsed_json
from dcrb_ros.text.writing import write_whole

FORMAT: Literal["dcrb exam entry 2"] = "dcrb exam entry 2"
DIGEST = "sha256"
"""Key of a file with the digest of the others."""
AGREEMENT = 1e-4
"""Largest difference between the exam scores stated in an entry and those computed again from its scenarios [-]."""
EXACT = 1e-6
"""Largest such difference of the area [-]."""
BOX = re.compile(r"/axle_\d+/(left|right)$")
"""End of the name of a scenario that is a box of a vehicle."""
LARGEST = 64 * 1024 * 1024
"""Largest file of an entry [bytes]."""
MOST_VALUES = 4_000_000
"""Most values of an entry [-]: four hours of blocks of 0.02 s, each with time, score and signal time received, have 2.2 million."""
LONGEST_FAILURE = 4000
"""Longest reason of a failure that is kept [characters]."""


class StoredDiagnoses(Group):
    """The diagnoses of a scenario, in columns; see `ReceivedDiagnosis`."""

    time: list[float]
    """[s]"""
    verdicts: list[str]
    """The verdicts, without repetitions of the previous one."""
    counts: list[int]
    """How many times in a row each was published [-]."""
    score: list[float | None] | None = None
    """None if no diagnosis has one."""
    issued: list[float | None] | None = None
    """Signal time received [s]; None if every diagnosis arrived at once."""

    @staticmethod
    def of(received: Sequence[ReceivedDiagnosis]) -> StoredDiagnoses:
        """Return the columns of diagnoses."""
        runs = [(verdict, len(list(same))) for verdict, same in groupby(diagnosis.verdict for diagnosis in received)]
        scores, issued = [diagnosis.score for diagnosis in received], [diagnosis.signal_received for diagnosis in received]
        return StoredDiagnoses(
            time=[diagnosis.time for diagnosis in received],
            verdicts=[verdict for verdict, _ in runs],
            counts=[count for _, count in runs],
            score=_column(scores),
            issued=_column(issued),
        )

    def received(self) -> list[ReceivedDiagnosis]:
        """Return the diagnoses; the columns have one length."""
        verdicts = [verdict for verdict, count in zip(self.verdicts, self.counts, strict=True) for _ in range(count)]
        none: list[float | None] = [None] * len(self.time)
        rows = zip(self.time, verdicts, self.score or none, self.issued or none, strict=True)
        return [ReceivedDiagnosis(time, verdict, score, "", issued) for time, verdict, score, issued in rows]

    @property
    def flaw(self) -> str:
        """What is wrong with the columns; the empty string if nothing is."""
        lengths = {len(column) for column in (self.time, self.score, self.issued) if column is not None}
        if min(self.counts, default=1) < 1 or lengths != {sum(self.counts)} or len(self.counts) != len(self.verdicts):
            return "the columns of its diagnoses have different lengths"
        if not all(0.0 <= time <= LATEST for time in self.time):
            return f"the time of a diagnosis is outside 0 .. {LATEST:g} s"
        unknown = sorted(set(self.verdicts) - set(VERDICTS))
        return f"'{unknown[0]}' is not a verdict" if unknown else ""


def _column(values: list[float | None]) -> list[float | None] | None:
    return None if all(value is None for value in values) else values


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
    failure: str = Field("", max_length=LONGEST_FAILURE)
    """Why the detector stopped early; empty if it did not."""
    diagnoses: StoredDiagnoses
    """The diagnoses, from which everything else follows."""

    @property
    def right(self) -> bool:
        """Whether the answer is the correct verdict, and the detector did not fail after it."""
        return self.answer == self.family and not self.failure


class Entry(Group):
    """The results of one detector in one exam."""

    format: Literal["dcrb exam entry 2"]
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
    last_verdict: bool = False
    """Whether the answers are last verdicts, as in a replica; then entries are sorted by the correct ones."""
    criteria_sha256: str = ""
    """Hash of the criteria; empty for last verdicts."""

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
                failure=result.failure[:LONGEST_FAILURE],
                diagnoses=StoredDiagnoses.of(result.received),
            )
            for result in report.results
        ],
        **({"last_verdict": True} if report.last_verdict else {"criteria_sha256": digest_of(report.criteria.model_dump(), "")}),
    )


def write_entry(entry: Entry, file: Path) -> None:
    """Write an entry as one line of JSON.

    Raises:
        Refusal: the file cannot be written, or is larger than `read_entry` reads.
    """
    tree = entry.model_dump(exclude_unset=True)
    text = json.dumps(tree | {DIGEST: digest_of(tree, DIGEST)}, separators=(",", ":"), allow_nan=False) + "\n"
    diagnoses = sum(len(scenario.diagnoses.time) for scenario in entry.scenarios)
    parsed_json(text, f"the entry {file}, with {diagnoses} diagnoses,", LARGEST, MOST_VALUES)
    write_whole(file, text)


def read_entry(path: Path) -> Entry:
    """Return the entry in a file.

    Raises:
        Refusal: the file cannot be read, is not an entry, was changed or has no digest, its scores or area do not follow from its
            scenarios, or a scenario contradicts itself.
    """
    text = read_text(checked_path(path), LARGEST)
    try:
        tree: Any = parsed_json(text, str(path), LARGEST, MOST_VALUES)
    except Refusal as refusal:
        raise Refusal(f"{refusal}; give an entry of dcrb score --entry") from None
    stated = tree.pop(DIGEST, None) if isinstance(tree, dict) else None
    if stated is not None and stated != digest_of(tree, DIGEST):
        raise Refusal(f"{path} was changed: its digest does not match; make it again with dcrb score --entry")
    try:
        entry = Entry.model_validate(tree)
    except ValidationError as error:
        problem = first_problem(error)
        raise Refusal(f"{path} is not an entry ({problem.key or 'the file'}: {problem.reason}): make it with dcrb score --entry") from None
    if flaw := _flaw(entry):
        raise Refusal(f"{path} {flaw} make it again with dcrb score --entry")
    if stated is None:
        raise Refusal(f"{path} has no {DIGEST}, so that a change would not be found: make it again with dcrb score --entry")
    return entry


def _flaw(entry: Entry) -> str:
    """Return what contradicts itself in an entry, as the middle of a sentence, or an empty string."""
    if (twice := repeated(scenario.name for scenario in entry.scenarios)) is not None:
        return f"has the scenario '{twice}' twice:"
    profiles = {profile.name for profile in PROFILES}
    given: dict[str, set[str]] = {}
    for scenario in entry.scenarios:
        given.setdefault(BOX.sub("", scenario.name), set()).update(scenario.diagnoses.verdicts)
    for scenario in entry.scenarios:
        possible = all(0.0 <= credit <= 1.0 for credit in scenario.credit.values()) and scenario.spoiled <= scenario.periods
        if not possible or set(scenario.credit) != (profiles if scenario.family != "healthy" else set()):
            return f"has an impossible credit in the scenario '{scenario.name}':"
        contradiction = _contradiction(scenario, given[BOX.sub("", scenario.name)])
        if contradiction := contradiction or (_contradicted_answer(scenario) if entry.last_verdict else ""):
            return f"contradicts itself in the scenario '{scenario.name}': {contradiction};"
    computed = {score.profile: score.score.value for score in entry.scores()}
    if set(computed) != set(entry.exam_score) or any(abs(entry.exam_score[key] - value) > AGREEMENT for key, value in computed.items()):
        return "states exam scores that do not follow from its scenarios:"
    area = overall_area(areas_of([(scenario.family, scenario.evidence) for scenario in entry.scenarios]))
    follows = area if math.isfinite(area) else None
    if (entry.area is None) != (follows is None) or abs((entry.area or 0.0) - (follows or 0.0)) > EXACT:
        return f"states the area {entry.area}, but {follows} follows from its scenarios:"
    return ""


def _contradiction(scenario: EntryScenario, verdicts: set[str]) -> str:
    """Return what in a scenario does not follow from the rest of it; the empty string if everything does.

    ``verdicts`` are those of the scenario, or of all boxes of its vehicle.
    """
    faulty, delay = scenario.family != "healthy", scenario.delay_turns
    if scenario.diagnoses.flaw:
        return scenario.diagnoses.flaw
    if scenario.answer not in (*VERDICTS, NO_ANSWER):
        return f"'{scenario.answer}' is not a verdict"
    if not faulty and (delay is not None or scenario.stratum is not None):
        return "it has no fault, but the delay or the stratum of one"
    if scenario.found != (faulty and delay is not None and scenario.answer == scenario.family):
        return f"found is {scenario.found}, with the answer {scenario.answer} and the delay {delay}"
    for profile in PROFILES if faulty else ():
        credit = scenario.credit[profile.name]
        if credit > _most_credit(scenario, verdicts, profile) + EXACT:
            return f"a credit of {credit:g} ({profile.name}) for a fault that was not detected in time"
    return ""


def _contradicted_answer(scenario: EntryScenario) -> str:
    """Return how the answer of a scenario differs from its last verdict; the empty string if it does not."""
    # The verdicts before the onset are no answer, so a detector may have none.
    if scenario.answer in (WAITING, NO_ANSWER):
        return ""
    given = [verdict for verdict in scenario.diagnoses.verdicts if verdict != WAITING]
    last = given[-1] if given else NO_ANSWER
    # With criteria.name_right off, every bearing fault is taken as the correct one.
    any_fault = {last, scenario.family} <= set(BEARING_FAULTS) and scenario.answer == scenario.family
    return "" if last == scenario.answer or any_fault else f"the answer is {scenario.answer}, but the last verdict is {last}"


def _most_credit(scenario: EntryScenario, verdicts: set[str], profile: Profile) -> float:
    """Return the largest credit that the verdicts of a scenario allow."""
    alarm = any(map(is_alarm, verdicts))
    # An alarm on the damaged box of a vehicle earns a part of the share of the name without its component.
    named = alarm if BOX.search(scenario.name) else scenario.family in verdicts
    return (1.0 - profile.naming) * alarm + profile.naming * named
