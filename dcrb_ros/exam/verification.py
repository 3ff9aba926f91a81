"""The verification of an entry: everything in it is computed again from its diagnoses and the exam with which it was made."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from dcrb_ros.exam.evaluation import Outcome, report_of
from dcrb_ros.exam.exam_file import Exam
from dcrb_ros.exam.exam_scenarios import scenarios_of
from dcrb_ros.exam.leaderboard_entry import Entry, entry_of
from dcrb_ros.runtime.version import __version__

STATED = ("format", "detector", "dcrb_ros", "model", "software", "criteria_sha256", "scenarios")
"""Fields that do not follow from the diagnoses, and the criteria and scenarios, which are compared apart."""
CLOSE = 1e-6
"""Largest relative and absolute difference of two numbers; powers differ between machines in the last digits."""


def differences(entry: Entry, exam: Exam) -> Iterator[str]:
    """Yield a sentence for everything in an entry that does not follow from its diagnoses in an exam."""
    stated = {scenario.name: scenario for scenario in entry.scenarios}
    names = [case.expectation.name for case in exam.cases]
    lacking, foreign = [name for name in names if name not in stated], sorted(set(stated) - set(names))
    if lacking or foreign:
        yield f"it lacks the scenario '{lacking[0]}' of the exam" if lacking else f"the exam has no scenario '{foreign[0]}'"
        return
    outcomes = {name: Outcome(scenario.diagnoses.received(), scenario.failure) for name, scenario in stated.items()}
    follows = entry_of(report_of(scenarios_of(exam, Path()), entry.detector, outcomes))
    if entry.criteria_sha256 != follows.criteria_sha256:
        yield f"its criteria are not those of the exam in dcrb_ros {__version__}; dcrb_ros {entry.dcrb_ros} made it"
    yield from _unequal("", entry.model_dump(exclude=set(STATED)), follows.model_dump(exclude=set(STATED)))
    for computed in follows.scenarios:
        yield from _unequal(f"scenario '{computed.name}': ", stated[computed.name].model_dump(), computed.model_dump())


def _unequal(where: str, stated: Mapping[str, Any], follows: Mapping[str, Any]) -> Iterator[str]:
    for key, value in follows.items():
        if not _close(stated[key], value):
            yield f"{where}{key} is stated as {_shown(stated[key])}, but {_shown(value)} follows"


def _shown(value: Any) -> Any:
    return "nothing" if value is None or value == "" else value


def _close(first: Any, second: Any) -> bool:
    """Return whether two trees are equal except for the last digits of their numbers."""
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        return first.keys() == second.keys() and all(_close(first[key], second[key]) for key in first)
    if isinstance(first, Sequence) and isinstance(second, Sequence) and not isinstance(first, str):
        return len(first) == len(second) and all(map(_close, first, second))
    if isinstance(first, float) and isinstance(second, float):
        return math.isclose(first, second, rel_tol=CLOSE, abs_tol=CLOSE)
    return bool(first == second)
