"""A detector evaluated on an exam, on recordings or on measured signals, with a progress bar."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

from dcrb_ros.cli.first_start import announce_compilation
from dcrb_ros.schema.refusal import Refusal

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.exam.case import Case
    from dcrb_ros.exam.exam_file import Exam
    from dcrb_ros.exam.report import Report
    from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis

SHIPPED = "the shipped detector"


class Candidate(NamedTuple):
    """The detector under evaluation: a node, a Python class, or the shipped detector."""

    name: str
    node: str | None
    """Command that starts the node; None for a detector in this process."""
    python: str | None
    """Class of a detector written in Python; None for the shipped detector or a node."""
    parameters: DetectorParameters
    """Parameters of the shipped detector."""
    rate: float
    """Recorded over wall time; 0 for as fast as the node answers [-]."""
    patience: float
    """Wall time that the node may take to start [s]."""


def candidate_of(node: str | None, python: str | None, detector: Path | None, rate: float, patience: float, name: str) -> Candidate:
    """Return the detector that the options name, with its parameters from a file."""
    from dcrb_ros.cli.detect import detector_parameters

    shipped = SHIPPED if detector is None else f"{SHIPPED} with {detector.name}"
    return Candidate(name or node or python or shipped, node, python, detector_parameters(detector), rate, patience)


def evaluate_measured_folder(folder: Path, candidate: Candidate, speed: str, workers: int, *, quiet: bool) -> Report:
    """Return the report of measured recordings."""
    from dcrb_ros.exam.measured import evaluate_measured, read_measured
    from dcrb_ros.exam.measured_stream import evaluate_measured_stream

    with progress_of("judged", len(read_measured(folder, speed)), quiet=quiet) as on_done:
        if candidate.python is not None:
            return evaluate_measured_stream(folder, candidate.python, speed, candidate.name, workers, on_done)
        return evaluate_measured(folder, candidate.parameters, speed, candidate.name, workers, on_done)


def evaluate_exam(exam: Exam, candidate: Candidate, recordings: Path | None, workers: int, *, quiet: bool) -> Report:
    """Return the report of an exam."""
    from dcrb_ros.exam.case import scenarios_hash, simulation_seeds
    from dcrb_ros.exam.evaluation import evaluate_plugin, evaluate_shipped
    from dcrb_ros.exam.recording_cache import checked_folder, default_folder
    from dcrb_ros.exam.report import Report
    from dcrb_ros.exam.scoring import score_scenario

    folder = checked_folder(recordings or default_folder())
    announce_compilation(quiet=quiet)
    failures: dict[str, str] = {}
    if candidate.node is None:
        with progress_of("evaluated", len(exam.cases), quiet=quiet) as on_done:
            diagnoses: Mapping[str, Sequence[ReceivedDiagnosis]]
            if candidate.python is None:
                diagnoses = evaluate_shipped(exam.cases, folder, candidate.parameters, workers, on_done)
            else:
                diagnoses = evaluate_plugin(exam.cases, folder, candidate.python, workers, on_done)
    else:
        bags = _recorded(exam.cases, folder, workers, candidate.node, candidate.patience, quiet=quiet)
        diagnoses, failures = _evaluate_node(bags, candidate.node, candidate.rate, candidate.patience, quiet=quiet)
    expectations = [case.expectation for case in exam.cases]
    results = tuple(score_scenario(e, diagnoses[e.name], exam.criteria, failure=failures.get(e.name, "")) for e in expectations)
    digest, seeds = scenarios_hash(exam.cases), simulation_seeds(exam.cases)
    return Report(exam.name, candidate.name, exam.criteria, digest, results, exam.seal, seeds)


def _recorded(cases: Sequence[Case], folder: Path, workers: int, node: str, patience: float, *, quiet: bool) -> dict[str, Path]:
    """Return the recordings of cases; an invalid command is refused before anything is simulated."""
    from dcrb_ros.exam.evaluation import record_all
    from dcrb_ros.nodes.external_detector import ExternalDetector

    ExternalDetector(node, patience=patience)
    with progress_of("simulated", len(cases), quiet=quiet) as on_done:
        paths = record_all(cases, folder, workers, on_done)
    return {case.expectation.name: paths[case.expectation.name] for case in cases}


def _evaluate_node(
    bags: Mapping[str, Path], node: str, rate: float, patience: float, *, quiet: bool
) -> tuple[dict[str, list[ReceivedDiagnosis]], dict[str, str]]:
    """Return a node's diagnoses of recordings, and the failures, by name."""
    from dcrb_ros.nodes.external_detector import ExternalDetector, NoDiagnosis

    detector = ExternalDetector(node, rate=rate, patience=patience)
    diagnoses: dict[str, list[ReceivedDiagnosis]] = {}
    failures: dict[str, str] = {}
    with progress_of("evaluated", len(bags), quiet=quiet) as on_done:
        for name, bag in bags.items():
            found = detector.diagnose(bag)
            if found.failure and not found.received and not diagnoses:
                raise NoDiagnosis(f"the detector '{node}' failed on the first scenario ({name}): {found.failure}")
            diagnoses[name] = found.received
            if found.failure:
                failures[name] = found.failure
            on_done(name)
    return diagnoses, failures


def evaluate_bags(bags: Sequence[Path], candidate: Candidate, *, run_detector: bool, workers: int, quiet: bool) -> Report:
    """Return the report of recordings: of the candidate if ``run_detector``, otherwise of the diagnoses in the recordings."""
    from dcrb_ros.exam.criteria import Criteria
    from dcrb_ros.exam.evaluation import evaluate_plugin_on, evaluate_shipped_on, score_recordings
    from dcrb_ros.exam.recorded_case import read_recorded_case
    from dcrb_ros.exam.report import Report
    from dcrb_ros.exam.scoring import score_scenario

    names = _names(bags)
    recordings = [read_recorded_case(bag, name=name) for bag, name in zip(bags, names, strict=True)]
    for recorded in recordings:
        for damage in recorded.damage:
            typer.echo(f"{recorded.path}: {damage}; the readable part is scored", err=True)
    criteria = Criteria()
    failures: dict[str, str] = {}
    if not run_detector:
        return Report("recordings", "the recorded diagnoses", criteria, "", score_recordings(recordings, criteria))
    if candidate.node is None:
        with progress_of("evaluated", len(recordings), quiet=quiet) as on_done:
            if candidate.python is None:
                diagnoses = evaluate_shipped_on(recordings, candidate.parameters, workers, on_done)
            else:
                diagnoses = evaluate_plugin_on(recordings, candidate.python, workers, on_done)
    else:
        paths = dict(zip(names, bags, strict=True))
        diagnoses, failures = _evaluate_node(paths, candidate.node, candidate.rate, candidate.patience, quiet=quiet)
    expectations = [recorded.expectation for recorded in recordings]
    results = tuple(score_scenario(e, diagnoses[e.name], criteria, failure=failures.get(e.name, "")) for e in expectations)
    return Report("recordings", candidate.name, criteria, "", results)


def _names(bags: Sequence[Path]) -> list[str]:
    """Return a name for each recording: the name of its folder, or the whole path if two folders have the same name."""
    short = [bag.resolve().name for bag in bags]
    names = [name if short.count(name) == 1 else str(bag) for name, bag in zip(short, bags, strict=True)]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise Refusal(f"{twice} is given twice: give every recording once")
    return names


@contextmanager
def progress_of(activity: str, total: int, *, quiet: bool) -> Iterator[Callable[[str], None]]:
    """Show a progress bar; yield the function to call with the name of each scenario that is done."""
    from rich.progress import MofNCompleteColumn, TextColumn, TimeElapsedColumn

    from dcrb_ros.runtime.terminal import progress

    columns = (MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.fields[last]}", markup=False))
    with progress(*columns, quiet=quiet) as bar:
        task = bar.add_task(f"scenarios {activity}", total=total, last="")
        yield lambda name: bar.update(task, advance=1, last=name)
