"""The exam being sat: every case examined, on all cores where the examinee allows it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.case import Case
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.library import place, recorded
from dcrb_ros.exam.marking import Mark, mark
from dcrb_ros.exam.opinion import Opinion
from dcrb_ros.exam.recorded_case import Tape
from dcrb_ros.exam.reference import examined, opinions
from dcrb_ros.runtime.processes import in_processes
from dcrb_ros.runtime.refusal import Refusal

Value = TypeVar("Value")
Told = Callable[[str], None]
"""Called with the name of every scenario that is done."""


def record_all(cases: Sequence[Case], folder: Path, workers: int, told: Told) -> dict[str, Path]:
    """Return the recording of every case, simulated where there is none yet."""
    there = {case.question.name: place(case, folder) for case in cases}
    found = {name: path for name, path in there.items() if path.is_dir()}
    for name in found:
        told(name)
    return found | _each({c.question.name: partial(recorded, c, folder) for c in cases if c.question.name not in found}, workers, told)


def examine_reference(
    cases: Sequence[Case], folder: Path, parameters: DetectorParameters, workers: int, told: Told
) -> dict[str, list[Opinion]]:
    """Return what the shipped detector says of every case."""
    return _each({case.question.name: partial(examined, case, folder, parameters) for case in cases}, workers, told)


def examine_reference_on(tapes: Sequence[Tape], parameters: DetectorParameters, workers: int, told: Told) -> dict[str, list[Opinion]]:
    """Return what the shipped detector says of recordings."""
    return _each({tape.question.name: partial(opinions, tape.path, parameters) for tape in tapes}, workers, told)


def named(name: str, call: Callable[[], Value]) -> Value:
    """Return what a call returns; what goes wrong in it is told with the scenario's name."""
    try:
        return call()
    except Refusal as refusal:
        raise Refusal(f"scenario '{name}': {refusal}") from None
    except Exception as error:
        raise RuntimeError(f"scenario '{name}' could not be examined: {error or type(error).__name__}") from error


def _each(calls: Mapping[str, Callable[[], Value]], workers: int, told: Told) -> dict[str, Value]:
    found: dict[str, Value] = {}
    told_by = {name: partial(named, name, call) for name, call in calls.items()}
    for name, value in in_processes(told_by, min(workers, len(calls))) if calls else ():
        found[name] = value
        told(name)
    return found


def marked(tapes: Iterable[Tape], criteria: Criteria) -> tuple[Mark, ...]:
    """Return the marks of recordings that hold diagnoses.

    Raises:
        Refusal: one has none.
    """
    marks = []
    for tape in tapes:
        if not tape.opinions:
            raise Refusal(
                f"{tape.path} holds no messages on diagnosis: record it beside a running detector (dcrb bench --record, or "
                "ros2 bag record -a), or have it judged now with --reference or --node COMMAND"
            )
        marks.append(mark(tape.question, tape.opinions, criteria))
    return tuple(marks)
