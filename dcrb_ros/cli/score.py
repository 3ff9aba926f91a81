"""`dcrb score`: the exam of a fault detector."""

from __future__ import annotations

import fnmatch
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from dcrb_ros.cli import completion
from dcrb_ros.cli.exam_list import print_scenarios
from dcrb_ros.cli.first_start import announce_compilation
from dcrb_ros.cli.options import DetectorFile, JsonOutput, Quiet, Workers, worker_count
from dcrb_ros.cli.output_file import PICTURES, check_output
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


def score(
    sources: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="EXAM | BAG ...",
            help="An exam (smoke, standard, blind, full, hours or a YAML file), or recordings.",
            autocompletion=completion.exams,
        ),
    ] = None,
    measured: Annotated[
        Path | None,
        typer.Option(help="Folder of measured recordings with known truth: recordings.csv and recordings/NAME.npz.", file_okay=False),
    ] = None,
    speed: Annotated[str, typer.Option(help="Column of speeds that --measured uses: lines or documented.")] = "lines",
    exam: Annotated[str | None, typer.Option(help="The exam; the same as the argument.", autocompletion=completion.exams)] = None,
    node: Annotated[str | None, typer.Option(help="Command that starts your detector node; it is started anew for every scenario.")] = None,
    python: Annotated[
        str | None,
        typer.Option(help="Your detector as a Python class: MODULE:CLASS, FILE.py:CLASS or an entry point of dcrb_ros.detectors."),
    ] = None,
    reference: Annotated[
        bool, typer.Option("--reference", help="Run the shipped detector on recordings, instead of scoring the diagnoses in them.")
    ] = False,
    detector: DetectorFile = None,
    rate: Annotated[
        float, typer.Option(help="Recorded over wall time with --node [-], 0 to 1000; 0 sends the signal as fast as the node answers.")
    ] = 0.0,
    patience: Annotated[float, typer.Option(help="Wall time that the node may take to start [s], above 0 and up to 3600.")] = 30.0,
    only: Annotated[str, typer.Option(help="Pattern of scenario names, such as 'outer/*'; their twins are included. Default: all.")] = "",
    recordings: Annotated[
        Path | None, typer.Option(help="Folder that keeps the exam's recordings. Default: a folder in the user's cache.")
    ] = None,
    workers: Workers = 0,
    as_json: JsonOutput = False,
    quiet: Quiet = False,
    junit: Annotated[Path | None, typer.Option(help="Also write the report as JUnit XML to this file.")] = None,
    figure: Annotated[Path | None, typer.Option(help="Also draw the report to this file (.png, .svg or .pdf).")] = None,
    entry: Annotated[Path | None, typer.Option(help="Also write the results as an entry of a leaderboard (.json).")] = None,
    name: Annotated[str, typer.Option(help="Name of the detector in the report. Default: its command, its class or its parameters.")] = "",
    show: Annotated[bool, typer.Option("--list", help="List the scenarios and exit.")] = False,
) -> None:
    """Evaluate a fault detector: the shipped one, your own node, or the diagnoses in recordings.

    Exit status 0 if every criterion is met, 1 if not, 2 if the input is invalid.

    Example: dcrb score smoke --node "python3 examples/naive_detector.py"
    """
    given = [*(sources or ()), *([exam] if exam else [])]
    if measured is not None:
        _check_measured(given, node, speed, other=bool(only or show or recordings or reference))
        _check_python(python, node, detector, reference)
        count = worker_count(workers)
        _check_files(junit, figure, entry)
        report = _evaluate_measured(measured, _candidate(None, python, detector, rate, patience, name), speed, count, quiet=quiet)
        _output(report, as_json, junit, figure, entry)
        if not report.passed:
            raise typer.Exit(1)
        return
    _check(given, rate, patience, node, detector, reference)
    _check_python(python, node, detector, reference)
    count = worker_count(workers)
    _check_files(junit, figure, entry)
    candidate = _candidate(node, python, detector, rate, patience, name)
    bags = [source for source in given if _is_recording(Path(source))]
    if bags and len(bags) < len(given):
        exam_given = next(source for source in given if source not in bags)
        raise Refusal(f"{exam_given} is not a recording but {bags[0]} is: give either one exam or recordings")
    if bags and (only or show or recordings):
        raise Refusal(f"--only, --list and --recordings apply to an exam, but {bags[0]} is a recording: leave them out")
    if bags:
        run_detector = reference or any(one is not None for one in (node, python, detector))
        report = _evaluate_bags([Path(bag) for bag in bags], candidate, run_detector=run_detector, workers=count, quiet=quiet)
    else:
        from dcrb_ros.exam.exam_file import read_exam

        if len(given) > 1:
            raise Refusal(f"{len(given)} exams are given ({', '.join(given)}): give one at a time")
        chosen = _select(read_exam(given[0]), only)
        if show:
            print_scenarios(chosen)
            return
        report = _evaluate_exam(chosen, candidate, recordings, count, quiet=quiet)
    _output(report, as_json, junit, figure, entry)
    if not report.passed:
        raise typer.Exit(1)


def _check(given: Sequence[str], rate: float, patience: float, node: str | None, detector: Path | None, reference: bool) -> None:
    from dcrb_ros.exam.exam_file import shipped_exams

    if not given:
        raise Refusal(f"there is nothing to score: give an exam ({', '.join(shipped_exams())} or a YAML file), or recordings")
    if not (math.isfinite(rate) and 0.0 <= rate <= 1000.0):
        raise Refusal(f"--rate {rate} is outside 0 .. 1000: give 0 for as fast as the node answers, 1 for the recorded speed")
    if not (math.isfinite(patience) and 0.0 < patience <= 3600.0):
        raise Refusal(f"--patience {patience} s is outside 0 .. 3600 s: give the time that your node may take to start")
    if node is not None and reference:
        raise Refusal("--node and --reference name two detectors: evaluate them one at a time")
    if node is not None and detector is not None:
        raise Refusal(f"--detector {detector} applies to the shipped detector only: give your node's parameters in its --node command")


def _check_measured(given: Sequence[str], node: str | None, speed: str, *, other: bool) -> None:
    from dcrb_ros.exam.measured import SPEEDS

    if given or node is not None or other:
        raise Refusal(
            "--measured judges its recordings by the shipped detector or by --python: leave out exams, --node, --reference, "
            "--recordings, --only and --list"
        )
    if speed not in SPEEDS:
        raise Refusal(f"--speed {speed} is unknown: give {' or '.join(SPEEDS)}")


def _evaluate_measured(folder: Path, candidate: Candidate, speed: str, workers: int, *, quiet: bool) -> Report:
    """Return the report of measured recordings."""
    from dcrb_ros.exam.measured import evaluate_measured, read_measured
    from dcrb_ros.exam.measured_stream import evaluate_measured_stream

    with _progress("judged", len(read_measured(folder, speed)), quiet=quiet) as on_done:
        if candidate.python is not None:
            return evaluate_measured_stream(folder, candidate.python, speed, candidate.name, workers, on_done)
        return evaluate_measured(folder, candidate.parameters, speed, candidate.name, workers, on_done)


def _check_python(python: str | None, node: str | None, detector: Path | None, reference: bool) -> None:
    """Refuse a second detector beside a Python class, and a class that cannot be loaded."""
    if python is None:
        return
    other = "--node" if node is not None else "--detector" if detector is not None else "--reference" if reference else ""
    if other:
        raise Refusal(f"--python and {other} name two detectors: evaluate them one at a time")
    from dcrb_ros.exam.plugin import load_plugin

    load_plugin(python)


def _candidate(node: str | None, python: str | None, detector: Path | None, rate: float, patience: float, name: str) -> Candidate:
    from dcrb_ros.cli.detect import detector_parameters

    shipped = SHIPPED if detector is None else f"{SHIPPED} with {detector.name}"
    return Candidate(name or node or python or shipped, node, python, detector_parameters(detector), rate, patience)


def _check_files(junit: Path | None, figure: Path | None, entry: Path | None) -> None:
    """Refuse output files that cannot be written before the evaluation starts."""
    for option, file, suffixes in (("--junit", junit, ()), ("--figure", figure, PICTURES), ("--entry", entry, (".json",))):
        if file is not None:
            check_output(option, file, suffixes)


def _is_recording(path: Path) -> bool:
    """Return whether a path is read as a recording; one that does not exist, or a folder of an exam's name without any, is an exam."""
    if path.is_dir():
        from dcrb_ros.exam.exam_file import shipped_exams

        return str(path) not in shipped_exams() or any(path.glob("*.mcap"))
    return path.suffix == ".mcap" or (path.is_file() and path.suffix not in (".yaml", ".yml"))


def _select(exam: Exam, pattern: str) -> Exam:
    """Return an exam with the scenarios that match a pattern, and their twins."""
    import dataclasses

    if not pattern:
        return exam
    chosen = {case.expectation.name for case in exam.cases if fnmatch.fnmatchcase(case.expectation.name, pattern)}
    if not chosen:
        raise Refusal(f"--only '{pattern}' matches no scenario of {exam.name}: --list shows their names")
    twins = {case.expectation.twin for case in exam.cases if case.expectation.name in chosen}
    kept = tuple(case for case in exam.cases if case.expectation.name in chosen | twins)
    return dataclasses.replace(exam, name=f"{exam.name} (only {pattern})", cases=kept)


def _evaluate_exam(exam: Exam, candidate: Candidate, recordings: Path | None, workers: int, *, quiet: bool) -> Report:
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
        with _progress("evaluated", len(exam.cases), quiet=quiet) as on_done:
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
    with _progress("simulated", len(cases), quiet=quiet) as on_done:
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
    with _progress("evaluated", len(bags), quiet=quiet) as on_done:
        for name, bag in bags.items():
            found = detector.diagnose(bag)
            if found.failure and not found.received and not diagnoses:
                raise NoDiagnosis(f"the detector '{node}' failed on the first scenario ({name}): {found.failure}")
            diagnoses[name] = found.received
            if found.failure:
                failures[name] = found.failure
            on_done(name)
    return diagnoses, failures


def _evaluate_bags(bags: Sequence[Path], candidate: Candidate, *, run_detector: bool, workers: int, quiet: bool) -> Report:
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
        with _progress("evaluated", len(recordings), quiet=quiet) as on_done:
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
def _progress(activity: str, total: int, *, quiet: bool) -> Iterator[Callable[[str], None]]:
    """Show a progress bar; yield the function to call with the name of each scenario that is done."""
    from rich.progress import MofNCompleteColumn, TextColumn, TimeElapsedColumn

    from dcrb_ros.runtime.terminal import progress

    columns = (MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.fields[last]}", markup=False))
    with progress(*columns, quiet=quiet) as bar:
        task = bar.add_task(f"scenarios {activity}", total=total, last="")
        yield lambda name: bar.update(task, advance=1, last=name)


def _output(report: Report, as_json: bool, junit: Path | None, figure: Path | None, entry: Path | None = None) -> None:
    """Print a report, then write its files; printing comes first so that no result is lost if a file cannot be written."""
    if as_json:
        print(json.dumps(report.described(), indent=2, allow_nan=False), flush=True)
    else:
        _print(report)
    if junit is not None:
        from dcrb_ros.exam.junit import write_junit

        write_junit(report, junit)
    if figure is not None:
        from dcrb_ros.exam.figure import write_figure

        write_figure(report, figure)
    if entry is not None:
        from dcrb_ros.exam.entry import entry_of, write_entry

        write_entry(entry_of(report), entry)


def _print(report: Report) -> None:
    from dcrb_ros.exam.table import tables
    from dcrb_ros.runtime.terminal import console

    console().print(tables(report))
