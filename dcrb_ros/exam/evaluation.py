"""Evaluation of a detector: its diagnoses of every scenario, on all cores if the detector allows it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.case import Case
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.detector_run import run_shipped_detector, run_shipped_detector_on_case
from dcrb_ros.exam.plugin import run_plugin, run_plugin_on_case
from dcrb_ros.exam.recorded_case import RecordedCase
from dcrb_ros.exam.recording_cache import cache_path, cached_recording
from dcrb_ros.exam.scoring import ScenarioResult, score_scenario
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.runtime.processes import in_processes
from dcrb_ros.schema.refusal import Refusal

Value = TypeVar("Value")
OnDone = Callable[[str], None]
"""Called with the name of every scenario that is done."""


def record_all(cases: Sequence[Case], folder: Path, workers: int, on_done: OnDone) -> dict[str, Path]:
    """Return the recording of every case by name; simulate the missing ones."""
    paths = {case.expectation.name: cache_path(case, folder) for case in cases}
    existing = {name: path for name, path in paths.items() if path.is_dir()}
    for name in existing:
        on_done(name)
    missing = {c.expectation.name: partial(cached_recording, c, folder) for c in cases if c.expectation.name not in existing}
    return existing | _run_all(missing, workers, on_done)


def evaluate_shipped(
    cases: Sequence[Case], folder: Path, parameters: DetectorParameters, workers: int, on_done: OnDone
) -> dict[str, list[ReceivedDiagnosis]]:
    """Return the shipped detector's diagnoses of every case by name."""
    calls = {case.expectation.name: partial(run_shipped_detector_on_case, case, folder, parameters) for case in cases}
    return _run_all(calls, workers, on_done)


def evaluate_shipped_on(
    recordings: Sequence[RecordedCase], parameters: DetectorParameters, workers: int, on_done: OnDone
) -> dict[str, list[ReceivedDiagnosis]]:
    """Return the shipped detector's diagnoses of every recording by name."""
    calls = {recorded.expectation.name: partial(run_shipped_detector, recorded.path, parameters) for recorded in recordings}
    return _run_all(calls, workers, on_done)


def evaluate_plugin(cases: Sequence[Case], folder: Path, given: str, workers: int, on_done: OnDone) -> dict[str, list[ReceivedDiagnosis]]:
    """Return the diagnoses of every case by name, by a Python class in the form of `load_plugin`."""
    return _run_all({case.expectation.name: partial(run_plugin_on_case, case, folder, given) for case in cases}, workers, on_done)


def evaluate_plugin_on(recordings: Sequence[RecordedCase], given: str, workers: int, on_done: OnDone) -> dict[str, list[ReceivedDiagnosis]]:
    """Return the diagnoses of every recording by name, by a Python class in the form of `load_plugin`."""
    return _run_all({one.expectation.name: partial(run_plugin, one.path, given) for one in recordings}, workers, on_done)


def named(name: str, call: Callable[[], Value]) -> Value:
    """Return the result of a call; an exception is raised again with the scenario's name in its message."""
    try:
        return call()
    except Refusal as refusal:
        raise Refusal(f"scenario '{name}': {refusal}") from None
    except Exception as error:
        raise RuntimeError(f"scenario '{name}' could not be evaluated: {str(error) or type(error).__name__}") from error


def _run_all(calls: Mapping[str, Callable[[], Value]], workers: int, on_done: OnDone) -> dict[str, Value]:
    results: dict[str, Value] = {}
    named_calls = {name: partial(named, name, call) for name, call in calls.items()}
    for name, value in in_processes(named_calls, min(workers, len(calls))) if calls else ():
        results[name] = value
        on_done(name)
    return results


def score_recordings(recordings: Iterable[RecordedCase], criteria: Criteria) -> tuple[ScenarioResult, ...]:
    """Return the results of recordings that contain diagnoses.

    Raises:
        Refusal: a recording contains no diagnosis.
    """
    results = []
    for recorded in recordings:
        if not recorded.diagnoses:
            raise Refusal(
                f"{recorded.path} has no messages on diagnosis: record it while a detector runs (dcrb bench --record, or "
                "ros2 bag record -a), or run a detector on it with --reference or --node COMMAND"
            )
        results.append(score_scenario(recorded.expectation, recorded.diagnoses, criteria))
    return tuple(results)
