"""Marks of detectors on tasks: whether the last verdict is right. Each detector runs in a process of its own; answers are kept."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Any

from dcrb_ros.exam.detector_families import BrokenFamily, Member, left_out
from dcrb_ros.exam.evaluation import OnDone
from dcrb_ros.exam.limits import Limits
from dcrb_ros.exam.measured import measured_criteria
from dcrb_ros.exam.plugin_process import DetectorProcess
from dcrb_ros.exam.predictivity_task import Task
from dcrb_ros.exam.recording_cache import OTHER_FOLDER, keep, kept_content
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.runtime.processes import in_processes
from dcrb_ros.schema.refusal import Refusal

ANSWERS = "answers"
"""Subfolder of the answers in the folder of the exam's recordings."""
FORMAT = 3
"""Version of the way in which verdicts become answers; another one makes kept answers outdated."""


def answers_of(
    members: Sequence[Member],
    tasks: Sequence[Task[Any]],
    folder: Path,
    limits: Limits,
    workers: int,
    progress: AbstractContextManager[OnDone],
) -> tuple[dict[str, Mapping[str, str]], list[BrokenFamily]]:
    """Return the answers by the name of the member and the digest of the task, and the members that failed in any task.

    The answers of the same detector to the same signal are read from ``folder``. Nothing of a member that failed is kept.
    """
    store = folder / ANSWERS
    try:
        store.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Refusal(f"{store} cannot hold the answers: {error.strerror}; {OTHER_FOLDER}") from None
    answers: dict[str, Mapping[str, str]] = {}
    broken: list[BrokenFamily] = []
    kept = {member: _kept(store, member) for member in members}
    calls = {}
    with progress as on_done:
        for member, known in kept.items():
            if missing := [task for task in tasks if task.digest not in known]:
                calls[member] = partial(run_member, member.given, missing, limits)
            else:
                answers[member.name] = known
                on_done(member.name)
        for member, outcome in in_processes(calls, workers):
            if isinstance(outcome, str):
                broken.append(BrokenFamily(member.name, outcome))
            else:
                answers[member.name] = {**kept[member], **outcome}
                keep(_file(store, member), json.dumps(answers[member.name]).encode())
            on_done(member.name)
    return answers, broken


def run_member(given: str, tasks: Sequence[Task[Any]], limits: Limits) -> dict[str, str] | str:
    """Return the answers of a detector by the digest of the task, or why it failed."""
    criteria, found = measured_criteria(), {}
    process: DetectorProcess | None = None
    try:
        for task in tasks:
            if process is None or process.closed:
                process = DetectorProcess(given, limits)
            outcome = process.diagnose(task.signal)
            if outcome.failure:
                return f"it failed on {task.signal.recording.name}: {outcome.failure}"
            found[task.digest] = score_scenario(task.signal.expectation(), outcome.received, criteria).answer
    except Refusal as refusal:
        return left_out(refusal)
    finally:
        if process is not None:
            process.close()
    return found


def _file(store: Path, member: Member) -> Path:
    return store / f"{hashlib.sha256(f'{FORMAT} {member.digest}'.encode()).hexdigest()[:32]}.answers"


def _kept(store: Path, member: Member) -> Mapping[str, str]:
    """Return the kept answers of a member by the digest of the task."""
    return dict(json.loads(kept_content(_file(store, member), f"{member.name} judges the recordings again") or "{}"))
