"""The comparison of an exam with the field: run it, and write it as JSON, as Markdown and as a figure."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.exam.agreement import by_name
from dcrb_ros.exam.detector_families import BrokenFamily, Member
from dcrb_ros.exam.evaluation import Progress
from dcrb_ros.exam.exam_file import Exam, ReplicaOrigin
from dcrb_ros.exam.leaderboard_entry import Entry
from dcrb_ros.exam.limits import Limits
from dcrb_ros.exam.measured import TABLE, MeasuredRecording, led_scenarios, read_table
from dcrb_ros.exam.predictivity import Compared, Marks, Predictivity, check_families, predictivities
from dcrb_ros.exam.predictivity_marks import answers_of
from dcrb_ros.exam.predictivity_task import Task, measured_tasks, simulate_tasks, simulated_tasks
from dcrb_ros.exam.replica import table_digest
from dcrb_ros.exam.statistics import CONFIDENCE, Interval, class_mean
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal, repeated
from dcrb_ros.text.markdown import table as markdown_table

LABELS = {"srcc": "SRCC", "rho": "rho", "tau_b": "tau-b", "mmrv": "MMRV"}
"""Heads of the statistics."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """An exam compared with the field."""

    marks: Marks
    members: tuple[Predictivity, ...]
    """Over all members of the families."""
    families: tuple[Predictivity, ...]
    """Over the families, each by the member with its published settings."""
    broken: tuple[BrokenFamily, ...]
    """Detectors that were left out."""
    origin: ReplicaOrigin
    counterparts: int
    """Simulated recordings that were compared [-]."""


def origin_of(exam: Exam, table: Path) -> ReplicaOrigin:
    """Return the origin of a replica.

    Raises:
        Refusal: the exam is no replica, or one of another table.
    """
    if exam.replica is None:
        raise Refusal(f"the exam '{exam.name}' is no replica: make one with dcrb exam replica {table}")
    if exam.replica.table_sha256 != table_digest(table):
        raise Refusal(f"the replica '{exam.name}' was made from another table than {table}: make it again with dcrb exam replica {table}")
    return exam.replica


def compare_with_field(
    table: Path,
    replica: Callable[[], Exam],
    members: Sequence[Member],
    broken: Sequence[BrokenFamily],
    recordings: Path,
    limits: Limits,
    workers: int,
    progress: Progress,
) -> Comparison:
    """Return the comparison of a replica with the measured recordings of its table; it is made or read after the detectors were checked.

    Raises:
        Refusal: a recording is not there, the replica is one of another table, two detectors have one name, or fewer than three families
            are left.
    """
    check_families([member.family for member in members], _reasons(broken))
    if (twice := repeated(member.name for member in members)) is not None:
        families = " and ".join(member.family for member in members if member.name == twice)
        raise Refusal(f"the name '{twice}' is that of detectors in {families}: give each another name, in VARIANTS or as its file")
    exam = replica()
    origin = origin_of(exam, table)
    measured = read_table(table, origin.speed)
    first = measured_tasks(measured, origin.longest)
    second = simulated_tasks(exam, measured, recordings)
    simulate_tasks(second, workers, progress)
    tasks: list[Task[Any]] = [*first, *second]
    answers, failed = answers_of(members, tasks, recordings, limits, workers, progress("judged", len(members)))
    kept = [member for member in members if member.name in answers]
    both = [*broken, *failed]
    check_families([member.family for member in kept], _reasons(both))
    marks = _marks(kept, answers, first, second)
    return Comparison(marks, tuple(predictivities(marks)), tuple(predictivities(marks.representatives)), tuple(both), origin, len(second))


def compare_entries(table: Path, exam: Exam, entries: Sequence[Entry], measured: Sequence[Entry]) -> Comparison:
    """Return the comparison that follows from entries of the same detectors in a replica and on the measured recordings of its table.

    Each detector is a family of its own. The measured recordings must have been cut to the longest part of the replica.

    Raises:
        Refusal: the replica is one of another table or task, an entry was made with another exam, another task or another truth, or lacks a
            recording, or fewer than three detectors are in both.
    """
    origin, ours, field = origin_of(exam, table), by_name(entries, "the exam"), by_name(measured, "the measured recordings")
    foreign = next((name for name, entry in ours.items() if entry.scenarios_sha256 != exam.digest), None)
    if foreign is not None:
        raise Refusal(f"the entry '{foreign}' was made with another exam than '{exam.name}': make it with dcrb score REPLICA --entry")
    table_rows = read_table(table, origin.speed)
    tasks, counterparts = simulated_tasks(exam, table_rows, Path()), dict[str, list[str]]()
    for task in tasks:
        counterparts.setdefault(task.original.name, []).append(task.signal.recording.name)
    led = {task.original.name for task in tasks if task.signal.lead is not None}
    recordings = tuple(
        Compared(one.name, one.machine, one.truth, one.bearing, one.name in led) for one in table_rows if one.name in counterparts
    )
    names = tuple(name for name in ours if name in field)
    alone = *_alone(ours, field, "on the measured recordings"), *_alone(field, ours, "in the exam")
    check_families(names, _reasons(alone))
    _check_task(table, table_rows, origin, field)
    right = {name: _right_answers(ours[name]) for name in names}, {name: _right_answers(field[name]) for name in names}
    for name in names:
        _check_scenarios(f"the entry '{name}'", ours[name], {case.name: case.expectation.verdict for case in exam.cases}, exam.name)
        _check_scenarios(f"the entry '{name}' on measured recordings", field[name], {one.name: one.truth for one in recordings}, str(table))
    in_exam = [[float(np.mean([right[0][name][k] for k in counterparts[one.name]])) for one in recordings] for name in names]
    in_field = [[right[1][name][one.name] for one in recordings] for name in names]
    marks = Marks(names, names, (True,) * len(names), recordings, np.array(in_field), np.array(in_exam))
    found = tuple(predictivities(marks))
    return Comparison(marks, found, found, alone, origin, sum(len(counterparts[one.name]) for one in recordings))


def _alone(entries: Mapping[str, Entry], others: Mapping[str, Entry], where: str) -> Iterator[BrokenFamily]:
    """Yield the detectors that have an entry on one side only."""
    for name in entries:
        if name not in others:
            yield BrokenFamily(name, f"it has no entry of this name {where}: give both the same --name")


def _check_task(table: Path, recordings: Sequence[MeasuredRecording], origin: ReplicaOrigin, field: Mapping[str, Entry]) -> None:
    """Refuse entries on measured recordings that were made with another task than that of the replica, if the recordings are there."""
    if not all(one.file.is_file() for one in recordings):
        return
    digest = led_scenarios(recordings, origin.speed, origin.longest).digest
    other = next((name for name, entry in field.items() if entry.scenarios_sha256 != digest), None)
    if other is not None:
        renamed = "" if table.name == TABLE else f"rename the table to {TABLE}, and "
        raise Refusal(
            f"the entry '{other}' was made with another task or other recordings than the replica: {renamed}make it with dcrb score "
            f"--measured {table.parent} --speed {origin.speed} --longest {origin.longest:g} --python CLASS"
        )


def _check_scenarios(what: str, entry: Entry, truths: Mapping[str, str], source: str) -> None:
    """Refuse an entry that lacks a scenario or has another truth of it."""
    stated = {scenario.name: scenario.family for scenario in entry.scenarios}
    lacking = next((name for name in truths if name not in stated), None)
    if lacking is not None:
        raise Refusal(f"{what} lacks {lacking}: make it with all recordings of {source}")
    other = next((name for name, truth in truths.items() if stated[name] != truth), None)
    if other is not None:
        raise Refusal(f"{what} takes {other} as {stated[other]}, but it is {truths[other]} in {source}: make the entry again")


def _right_answers(entry: Entry) -> dict[str, float]:
    """Return by scenario whether the answer is right, 1 or 0."""
    return {scenario.name: float(scenario.right) for scenario in entry.scenarios}


def _reasons(broken: Sequence[BrokenFamily]) -> list[str]:
    return [f"{one.name}: {one.reason}" for one in broken]


def _marks(members: Sequence[Member], answers: Any, measured: Sequence[Task[Any]], simulated: Sequence[Task[Any]]) -> Marks:
    """Return the marks of members whose answers to all tasks are known; recordings without a counterpart are left out."""
    counterparts: dict[str, list[Task[Any]]] = {}
    for task in simulated:
        counterparts.setdefault(task.original.name, []).append(task)
    kept = [task for task in measured if task.original.name in counterparts]
    right = {member.name: answers[member.name] for member in members}

    def mark(member: Member, task: Task[Any]) -> float:
        return float(right[member.name][task.digest] == task.original.truth)

    field = [[mark(member, task) for task in kept] for member in members]
    exam = [[float(np.mean([mark(member, one) for one in counterparts[task.original.name]])) for task in kept] for member in members]
    recordings = tuple(
        Compared(task.original.name, task.original.machine, task.original.truth, task.original.bearing, task.signal.lead is not None)
        for task in kept
    )
    return Marks(
        tuple(member.name for member in members),
        tuple(member.family for member in members),
        tuple(member.published for member in members),
        recordings,
        np.array(field),
        np.array(exam),
    )


def pooled(marks: Marks) -> tuple[Floats, Floats]:
    """Return the pooled marks of each detector in the exam and in the field: the mean over the classes, 0 .. 1 [-]."""
    truths, whole = [recording.truth for recording in marks.recordings], np.ones((len(marks.recordings), 1))
    return class_mean(marks.exam, truths, whole)[:, 0], class_mean(marks.field, truths, whole)[:, 0]


def as_json(comparison: Comparison) -> dict[str, Any]:
    """Return a comparison as a tree for JSON."""
    exam, field = pooled(comparison.marks)
    rows = zip(comparison.marks.detectors, comparison.marks.families, exam, field, strict=True)
    return {
        "replica": comparison.origin.model_dump(),
        "recordings": len(comparison.marks.recordings),
        "counterparts": comparison.counterparts,
        "families": [_tree(one) for one in comparison.families],
        "members": [_tree(one) for one in comparison.members],
        "detectors": [{"name": name, "family": family, "exam": float(e), "field": float(f)} for name, family, e, f in rows],
        "left_out": [{"name": one.name, "reason": one.reason} for one in comparison.broken],
    }


def _tree(one: Predictivity) -> dict[str, Any]:
    about: dict[str, Any] = {"scope": one.scope, "detectors": one.detectors, "recordings": one.recordings}
    for name, value in one.statistics.items():
        about[name] = {
            "value": value.value,
            "over_bearings": [value.bearings.low, value.bearings.high],
            "over_families": [value.families.low, value.families.high],
            "ceiling": [None if math.isnan(each) else each for each in value.ceiling],
        }
    return about


def rows(predictivity: Sequence[Predictivity]) -> list[tuple[str, ...]]:
    """Return the cells of a table of statistics; see `HEADS`."""
    return [(f"{one.scope} ({one.recordings})", *(cell(one, name) for name in LABELS)) for one in predictivity]


HEADS = ("recordings", *LABELS.values())


def cell(one: Predictivity, name: str) -> str:
    """Return a statistic with its intervals over bearings and over families, and its ceiling."""
    value = one.statistics[name]
    ceiling = "–" if math.isnan(value.ceiling.value) else f"{value.ceiling.value:.2f}"
    return f"{value.value:.2f} [{_range(value.bearings)}; {_range(value.families)}], {ceiling}"


def _range(interval: Interval) -> str:
    return f"{interval.low:.2f}..{interval.high:.2f}"


def markdown(comparison: Comparison) -> str:
    """Return a comparison as Markdown: statistics by scope, marks by detector, and what was left out."""
    exam, field = pooled(comparison.marks)
    order = sorted(range(len(exam)), key=lambda k: (-field[k], comparison.marks.detectors[k]))
    detectors = ((comparison.marks.detectors[k], f"{100.0 * exam[k]:.0f}", f"{100.0 * field[k]:.0f}") for k in order)
    families, origin = len(set(comparison.marks.families)), comparison.origin
    without = f", without {', '.join(origin.without)}" if origin.without else ""
    lines = [
        f"{len(comparison.marks.recordings)} measured recordings, {comparison.counterparts} counterparts of at most {origin.longest:g} s "
        f"(seed {origin.seed}{without}), {families} families with {len(exam)} members. Each cell: value "
        f"[{CONFIDENCE:.0%} interval over bearings; over families], ceiling of measured halves.",
        "",
        f"Over the {comparison.families[0].detectors} families, each with its published settings:",
        "",
        markdown_table(HEADS, rows(comparison.families)),
        "",
    ]
    if len(exam) > families:
        lines += [f"Over all {len(exam)} members:", "", markdown_table(HEADS, rows(comparison.members)), ""]
    lines += [markdown_table(("detector", "exam [%]", "field [%]"), detectors), ""]
    lines += [f"Left out: {printable(one.name)}, {printable(one.reason)}" for one in comparison.broken]
    return "\n".join(lines)
