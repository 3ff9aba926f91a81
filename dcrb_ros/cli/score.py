"""`dcrb score`: the exam of a fault detector."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dcrb_ros.cli import completion
from dcrb_ros.cli.evaluation import DetectorOptions, evaluate_bags, evaluate_exam, evaluate_measured_folder
from dcrb_ros.cli.options import DetectorFile, Force, JsonOutput, Quiet, Workers, check_speed, refuse_given, worker_count
from dcrb_ros.cli.output_file import PICTURES, check_outputs
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted
from dcrb_ros.text.json import json_text

if TYPE_CHECKING:
    from dcrb_ros.exam.expectation import Expectation
    from dcrb_ros.exam.kinds import AnyExam
    from dcrb_ros.exam.limits import Limits
    from dcrb_ros.exam.report import Report
    from dcrb_ros.exam.vehicle.exam_file import VehicleExam

EVALUATION = (
    *("node", "python", "reference", "detector", "rate", "patience", "block_limit", "scenario_limit", "memory_limit"),
    *("recordings", "workers", "as_json", "junit", "figure", "entry", "force", "name"),
)
"""Options without effect on a list of scenarios."""
HEADS: tuple[str, ...] = ("scenario", "correct verdict", "onset [s]", "duration [s]", "twin")
VEHICLE_HEADS: tuple[str, ...] = ("scenario", "not healthy", "duration [s]")
LONGEST_TABLE = 300
"""Scenarios up to which they are a table with lines; a longer list is plain columns, which take a tenth of the time."""


def score(
    context: typer.Context,
    sources: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="EXAM | BAG ...",
            help="An exam (smoke, standard, graded, blind, full, lubrication, hours, bogie or a YAML file), or recordings.",
            autocompletion=completion.exams,
        ),
    ] = None,
    measured: Annotated[
        Path | None,
        typer.Option(help="Folder of measured recordings with known truth: recordings.csv and recordings/NAME.npz.", file_okay=False),
    ] = None,
    speed: Annotated[str, typer.Option(help="Column of speeds that --measured uses: lines or documented.")] = "lines",
    longest: Annotated[float, typer.Option(help="Longest part of a recording that --measured judges [s], 1 to 60.")] = 60.0,
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
    block_limit: Annotated[
        float, typer.Option(help="Wall time that the class of --python may take for a block [s], above 0 and up to 3600.")
    ] = 60.0,
    scenario_limit: Annotated[
        float, typer.Option(help="Wall time that it may take for a scenario beyond the recorded time [s], above 0 and up to 1e6.")
    ] = 600.0,
    memory_limit: Annotated[int, typer.Option(help="Memory that it may use [MiB], 256 to 1048576.")] = 4096,
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
    force: Force = False,
    name: Annotated[str, typer.Option(help="Name of the detector in the report. Default: its command, its class or its parameters.")] = "",
    show: Annotated[bool, typer.Option("--list", help="List the scenarios and exit.")] = False,
) -> None:
    """Evaluate a fault detector: the shipped one, your own node or Python class, or the diagnoses in recordings.

    Exit status 0 if every criterion is met, 1 if not, 2 if the input is invalid.

    Example: dcrb score smoke --node "python3 examples/naive_detector.py"
    """
    given = [*(sources or ()), *([exam] if exam else [])]
    if measured is not None:
        _check_measured(given, node, speed, longest, other=bool(only or show or recordings or reference))
    else:
        _check(given, rate, patience, node, detector, reference)
    limits = _limits(block_limit, scenario_limit, memory_limit)
    _check_python(python, node, detector, reference, limits)
    _check_effect(context, measured, node, python, show=show)
    count = worker_count(workers)
    check_outputs(("--junit", junit, ()), ("--figure", figure, PICTURES), ("--entry", entry, (".json",)), force=force)
    options = DetectorOptions(node, python, detector, rate, patience, limits, name)
    bags = [source for source in given if _is_recording(Path(source))]
    if bags and len(bags) < len(given):
        exam_given = next(source for source in given if source not in bags)
        raise Refusal(f"{exam_given} is not a recording but {bags[0]} is: give either one exam or recordings")
    if bags and (only or show or recordings):
        raise Refusal(f"--only, --list and --recordings apply to an exam, but {bags[0]} is a recording: leave them out")
    if measured is not None:
        report = evaluate_measured_folder(measured, options, speed, longest, count, quiet=quiet)
    elif bags:
        run_detector = reference or any(option is not None for option in (node, python, detector))
        if not run_detector:
            refuse_given(context, "applies to a detector, but the diagnoses in the recordings are scored: leave it out", "name", "workers")
        report = evaluate_bags([Path(bag) for bag in bags], options, run_detector=run_detector, workers=count, quiet=quiet)
    else:
        from dcrb_ros.exam.kinds import matching, read_any_exam

        if len(given) > 1:
            raise Refusal(f"{len(given)} exams are given ({', '.join(given)}): give one at a time")
        selected = matching(read_any_exam(given[0]), only)
        if show:
            print_scenarios(selected)
            return
        report = evaluate_exam(selected, options, recordings, count, quiet=quiet)
    output_report(report, as_json, junit, figure, entry)
    if not report.passed:
        raise typer.Exit(1)


def _check(given: Sequence[str], rate: float, patience: float, node: str | None, detector: Path | None, reference: bool) -> None:
    from dcrb_ros.settings.shipped import shipped

    if not given:
        raise Refusal(f"there is nothing to score: give an exam ({', '.join(shipped('exam'))} or a YAML file), or recordings")
    if not (math.isfinite(rate) and 0.0 <= rate <= 1000.0):
        raise Refusal(f"--rate {rate} is outside 0 .. 1000: give 0 for as fast as the node answers, 1 for the recorded speed")
    if not (math.isfinite(patience) and 0.0 < patience <= 3600.0):
        raise Refusal(f"--patience {patience} s is outside 0 .. 3600 s: give the time that your node may take to start")
    if node is not None and reference:
        raise Refusal("--node and --reference name two detectors: evaluate them one at a time")
    if node is not None and detector is not None:
        raise Refusal(f"--detector {detector} applies to the shipped detector only: give your node's parameters in its --node command")


def _check_measured(given: Sequence[str], node: str | None, speed: str, longest: float, *, other: bool) -> None:
    from dcrb_ros.exam.measured import LONGEST

    if given or node is not None or other:
        raise Refusal(
            "--measured judges its recordings by the shipped detector or by --python: leave out exams, --node, --reference, "
            "--recordings, --only and --list"
        )
    check_speed(speed)
    if not 1.0 <= longest <= LONGEST:
        raise Refusal(f"--longest {longest} s is outside 1 .. {LONGEST:g} s: give the longest part of a recording to judge")


def _limits(block: float, scenario: float, memory: int) -> Limits:
    from dcrb_ros.exam.limits import Limits

    for option, seconds, most in (("--block-limit", block, 3600.0), ("--scenario-limit", scenario, 1e6)):
        if not (math.isfinite(seconds) and 0.0 < seconds <= most):
            raise Refusal(f"{option} {seconds} s is outside 0 .. {most:g} s: give the wall time that the detector may take")
    if not 256 <= memory <= 1 << 20:
        raise Refusal(f"--memory-limit {memory} MiB is outside 256 .. {1 << 20} MiB: give the memory that the detector may use")
    return Limits(block, scenario, memory)


def _check_python(python: str | None, node: str | None, detector: Path | None, reference: bool, limits: Limits) -> None:
    """Refuse a second detector beside a Python class, and a class that cannot be loaded."""
    if python is None:
        return
    other = "--node" if node is not None else "--detector" if detector is not None else "--reference" if reference else ""
    if other:
        raise Refusal(f"--python and {other} name two detectors: evaluate them one at a time")
    from dcrb_ros.exam.plugin_process import DetectorProcess

    DetectorProcess(python, limits).close()  # refuses what cannot be imported


def _check_effect(context: typer.Context, measured: Path | None, node: str | None, python: str | None, *, show: bool) -> None:
    """Refuse options that would have no effect."""
    if show:
        refuse_given(context, "does not apply to --list, which evaluates nothing: leave it out", *EVALUATION)
    if measured is None:
        refuse_given(context, "applies to --measured only: leave it out", "speed", "longest")
    if node is None:
        refuse_given(context, "applies to --node only: leave it out", "rate", "patience")
    if python is None:
        refuse_given(context, "applies to --python only: leave it out", "block_limit", "scenario_limit", "memory_limit")


def _is_recording(path: Path) -> bool:
    """Return whether a path names a recording or a box in one, and not an exam.

    A folder with the name of a shipped exam is a recording only if it contains one.
    """
    if path.is_dir():
        from dcrb_ros.settings.shipped import shipped

        return str(path) not in shipped("exam") or any(path.glob("*.mcap"))
    from dcrb_ros.recordings.vehicle_folder import box_of

    return bool(box_of(path)[1]) or path.suffix == ".mcap" or (path.is_file() and path.suffix not in (".yaml", ".yml"))


def output_report(report: Report, as_json: bool, junit: Path | None, figure: Path | None, entry: Path | None = None) -> None:
    """Print a report, then write its files; printing comes first so that no result is lost if a file cannot be written.

    A detector that failed in every scenario has no entry.
    """
    if as_json:
        print(json_text(report.described()), flush=True)
    else:
        from dcrb_ros.exam.table import tables
        from dcrb_ros.runtime.terminal import console

        console().print(tables(report))
    if junit is not None:
        from dcrb_ros.exam.junit import write_junit

        write_junit(report, junit)
    if figure is not None:
        from dcrb_ros.exam.figure import write_figure

        write_figure(report, figure)
    if entry is not None and all(result.failure for result in report.results):
        typer.echo(f"the detector failed in every scenario: {entry} is not written", err=True)
    elif entry is not None:
        from dcrb_ros.exam.leaderboard_entry import entry_of, write_entry

        write_entry(entry_of(report), entry)


def print_scenarios(exam: AnyExam) -> None:
    """Print the scenarios of an exam with their correct verdicts, and the hash of them all."""
    from dcrb_ros.exam.exam_file import Exam
    from dcrb_ros.exam.exam_scenarios import expectations
    from dcrb_ros.runtime.terminal import console, table

    title = f"{exam.name}: {exam.about}" if exam.about else exam.name
    if isinstance(exam, Exam):
        expected = expectations(exam)
        heads, rows, kind = HEADS, list(_cells(expected)), "scenario"
        seconds = sum(expectation.duration for expectation in expected)
    else:
        heads, rows, kind = VEHICLE_HEADS, list(_vehicle_cells(exam)), "vehicle"
        seconds = sum(case.duration for case in exam.cases)
    if kind == "scenario" and len(rows) <= LONGEST_TABLE:
        console().print(table(title, heads, rows))
    else:
        widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
        lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in (heads, *rows))
        console().print("\n".join([title, *lines]), soft_wrap=True)
    print(f"{counted(len(rows), kind)}, {seconds:.0f} s simulated, sha256 {exam.digest}")


def _cells(expected: Iterable[Expectation]) -> Iterable[tuple[str, ...]]:
    for expectation in expected:
        name = expectation.name if expectation.required else f"{expectation.name} (not required)"
        onset = f"{expectation.onset:g}" if expectation.faulty else "-"
        yield name, expectation.verdict, onset, f"{expectation.duration:g}", expectation.twin or "-"


def _vehicle_cells(exam: VehicleExam) -> Iterable[tuple[str, ...]]:
    for case in exam.cases:
        yield case.name, ", ".join(f"{box} {verdict}" for box, verdict in case.damaged.items()) or "-", f"{case.duration:g}"
