"""`dcrb score`: the exam of a fault detector."""

from __future__ import annotations

import fnmatch
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from dcrb_ros.runtime.refusal import Refusal

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.exam.case import Case
    from dcrb_ros.exam.design import Exam
    from dcrb_ros.exam.marking import Mark
    from dcrb_ros.exam.opinion import Opinion
    from dcrb_ros.exam.recorded_case import Tape
    from dcrb_ros.exam.report import Report

REFERENCE = "the shipped detector"


class Candidate(NamedTuple):
    """Who is examined: a node, or the shipped detector."""

    name: str
    node: str | None
    """Command of the node."""
    parameters: DetectorParameters
    """Of the shipped detector."""
    rate: float
    patience: float


def score(
    sources: Annotated[
        list[str] | None,
        typer.Argument(metavar="EXAM | BAG ...", help="An exam (smoke, standard, blind, full, hours, a file) or recordings."),
    ] = None,
    exam: Annotated[str | None, typer.Option(help="The exam, as the argument.")] = None,
    node: Annotated[str | None, typer.Option(help="Command of a detector node; it is started for every scenario.")] = None,
    reference: Annotated[bool, typer.Option("--reference", help="Examine the shipped detector on recordings.")] = False,
    detector: Annotated[Path | None, typer.Option(help="Parameters of the shipped detector (YAML).")] = None,
    rate: Annotated[float, typer.Option(help="Recorded over wall time for --node; 0 for as fast as it answers.")] = 0.0,
    patience: Annotated[float, typer.Option(help="Wall time that the node gets to come up [s].")] = 30.0,
    only: Annotated[str, typer.Option(help="Scenarios by name, such as 'outer/*'; their twins come with them.")] = "",
    recordings: Annotated[Path | None, typer.Option(help="Folder that keeps the exam's recordings; by default the user's cache.")] = None,
    workers: Annotated[int, typer.Option(help="Runs at a time; 0 for one per core.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")] = False,
    junit: Annotated[Path | None, typer.Option(help="Write JUnit XML.")] = None,
    figure: Annotated[Path | None, typer.Option(help="Draw the report (.png, .svg, .pdf).")] = None,
    show: Annotated[bool, typer.Option("--list", help="List the scenarios and end.")] = False,
) -> None:
    """Examine a fault detector: the shipped one, a node of yours, or what recordings hold; exit status 1 if it fails."""
    from dcrb_ros.runtime.processes import cores

    given = [*(sources or ()), *([exam] if exam else [])]
    _check(given, rate, patience, workers, node, detector, reference)
    _check_files(junit, figure)
    count, candidate = workers or cores(), _candidate(node, detector, rate, patience)
    bags = [source for source in given if _is_recording(Path(source))]
    if bags and len(bags) < len(given):
        raise Refusal(f"{next(s for s in given if s not in bags)} is no recording and {bags[0]} is one: give one exam, or recordings alone")
    if bags and (only or show or recordings):
        raise Refusal(f"--only, --list and --recordings belong to an exam, and {bags[0]} is a recording: leave them out")
    if bags:
        judged = reference or node is not None or detector is not None
        report = _score_bags([Path(bag) for bag in bags], candidate, judged=judged, workers=count)
    else:
        from dcrb_ros.exam.design import read_exam

        if len(given) > 1:
            raise Refusal(f"{len(given)} exams at once ({', '.join(given)}) are refused: sit one after the other")
        chosen = _only(read_exam(given[0]), only)
        if show:
            _list(chosen)
            return
        report = _sit(chosen, candidate, recordings, count)
    _tell(report, as_json, junit, figure)
    if not report.passed:
        raise typer.Exit(1)


def _check(
    given: Sequence[str], rate: float, patience: float, workers: int, node: str | None, detector: Path | None, reference: bool
) -> None:
    from dcrb_ros.exam.design import shipped_exams

    if not given:
        raise Refusal(f"there is nothing to score: give an exam ({', '.join(shipped_exams())} or a YAML file), or recordings")
    if not (math.isfinite(rate) and 0.0 <= rate <= 1000.0):
        raise Refusal(f"--rate {rate} is outside 0 .. 1000: 0 feeds the node as fast as it answers, 1 at the recorded pace")
    if not (math.isfinite(patience) and 0.0 < patience <= 3600.0):
        raise Refusal(f"--patience {patience} s is outside 0 .. 3600 s: give the seconds that your node may take to come up")
    if not 0 <= workers <= 256:
        raise Refusal(f"--workers {workers} is outside 0 .. 256: 0 takes one per core")
    if node is not None and reference:
        raise Refusal("--node and --reference name two detectors: examine one after the other")
    if node is not None and detector is not None:
        raise Refusal(f"--detector {detector} is for the shipped detector and --node names another: give its parameters in its command")


def _candidate(node: str | None, detector: Path | None, rate: float, patience: float) -> Candidate:
    from dcrb_ros.cli.detect import detector_parameters

    shipped = REFERENCE if detector is None else f"{REFERENCE} with {detector.name}"
    return Candidate(shipped if node is None else node, node, detector_parameters(detector), rate, patience)


def _check_files(junit: Path | None, figure: Path | None) -> None:
    """Refuse files that could not be written: at the end of the exam it would be late to say so."""
    if figure is not None and figure.suffix not in (".png", ".svg", ".pdf"):
        raise Refusal(f"--figure {figure} is of no known kind: the name must end in .png, .svg or .pdf")
    for option, file in (("--junit", junit), ("--figure", figure)):
        if file is None:
            continue
        if not file.parent.is_dir():
            raise Refusal(f"{option} {file} cannot be written: there is no folder {file.parent}; make it or give another file")
        if file.is_dir():
            raise Refusal(f"{option} {file} is a folder: give the name of a file in it")
        if not os.access(file if file.exists() else file.parent, os.W_OK):
            raise Refusal(f"{option} {file} cannot be written: permission denied; give another file")


def _is_recording(path: Path) -> bool:
    """Return whether a path is meant as a recording; what does not exist is looked for among the exams."""
    return path.is_dir() or path.suffix == ".mcap" or (path.is_file() and path.suffix not in (".yaml", ".yml"))


def _only(exam: Exam, pattern: str) -> Exam:
    """Return an exam with the scenarios of a pattern and their twins."""
    import dataclasses

    if not pattern:
        return exam
    chosen = {case.question.name for case in exam.cases if fnmatch.fnmatchcase(case.question.name, pattern)}
    if not chosen:
        raise Refusal(f"--only '{pattern}' fits no scenario of {exam.name}: --list shows their names")
    twins = {case.question.twin for case in exam.cases if case.question.name in chosen}
    kept = tuple(case for case in exam.cases if case.question.name in chosen | twins)
    return dataclasses.replace(exam, name=f"{exam.name} (only {pattern})", cases=kept)


def _list(exam: Exam) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from dcrb_ros.exam.case import scenarios_hash

    # What users name is text: a name in brackets is no markup.
    table = Table("scenario", "right verdict", "onset [s]", "duration [s]", "twin", title=Text(f"{exam.name}: {exam.about}"))
    for case in exam.cases:
        question = case.question
        name = question.name if question.required else f"{question.name} (not required)"
        onset = f"{question.onset:g}" if question.faulty else "-"
        table.add_row(Text(name), question.verdict, onset, f"{question.duration:g}", Text(question.twin or "-"))
    console = Console()
    Console(width=None if console.is_terminal else 160).print(table)
    seconds = sum(case.run.duration for case in exam.cases)
    print(f"{len(exam.cases)} scenarios, {seconds:.0f} s simulated, sha256 {scenarios_hash(exam.cases)}")


def _sit(exam: Exam, candidate: Candidate, recordings: Path | None, workers: int) -> Report:
    """Return the report of an exam."""
    from dcrb_ros.core import compiled
    from dcrb_ros.exam.case import scenarios_hash
    from dcrb_ros.exam.library import checked_folder, default_folder
    from dcrb_ros.exam.marking import mark
    from dcrb_ros.exam.report import Report
    from dcrb_ros.exam.sitting import examine_reference

    folder = checked_folder(recordings or default_folder())
    if not compiled():
        typer.echo("compiling the kernels (once, about half a minute) ...", err=True)
    failures: dict[str, str] = {}
    if candidate.node is None:
        with _progress("examined", len(exam.cases)) as told:
            found: Mapping[str, Sequence[Opinion]] = examine_reference(exam.cases, folder, candidate.parameters, workers, told)
    else:
        bags = _recorded(exam.cases, folder, workers, candidate.node, candidate.patience)
        found, failures = _examine_node(bags, candidate.node, candidate.rate, candidate.patience)
    marks = [
        mark(case.question, found[case.question.name], exam.criteria, failure=failures.get(case.question.name, "")) for case in exam.cases
    ]
    return Report(exam.name, candidate.name, exam.criteria, scenarios_hash(exam.cases), tuple(marks))


def _recorded(cases: Sequence[Case], folder: Path, workers: int, node: str, patience: float) -> dict[str, Path]:
    """Return the recordings of cases; a command that cannot work is refused before they are simulated."""
    from dcrb_ros.exam.sitting import record_all
    from dcrb_ros.nodes.examinee import Examinee

    Examinee(node, patience=patience)
    with _progress("simulated", len(cases)) as told:
        made = record_all(cases, folder, workers, told)
    return {case.question.name: made[case.question.name] for case in cases}


def _examine_node(bags: Mapping[str, Path], node: str, rate: float, patience: float) -> tuple[dict[str, list[Opinion]], dict[str, str]]:
    """Return what a node says of recordings, and what broke."""
    from dcrb_ros.nodes.examinee import Examinee, Unanswered

    examinee = Examinee(node, rate=rate, patience=patience)
    found: dict[str, list[Opinion]] = {}
    failures: dict[str, str] = {}
    with _progress("examined", len(bags)) as told:
        for name, bag in bags.items():
            answers = examinee.examine(bag)
            if answers.failure and not answers.opinions and not found:
                raise Unanswered(f"the detector '{node}' failed on the first scenario ({name}): {answers.failure}")
            found[name] = answers.opinions
            if answers.failure:
                failures[name] = answers.failure
            told(name)
    return found, failures


def _score_bags(bags: Sequence[Path], candidate: Candidate, *, judged: bool, workers: int) -> Report:
    """Return the report of recordings: of the candidate where they are to be ``judged`` now, or of the diagnoses in them."""
    from dcrb_ros.exam.criteria import Criteria
    from dcrb_ros.exam.marking import mark
    from dcrb_ros.exam.recorded_case import read_tape
    from dcrb_ros.exam.report import Report
    from dcrb_ros.exam.sitting import examine_reference_on, marked

    names = _names(bags)
    tapes: list[Tape] = [read_tape(bag, name=name) for bag, name in zip(bags, names, strict=True)]
    for tape in tapes:
        for words in tape.damage:
            typer.echo(f"{tape.path}: {words}; what is readable is scored", err=True)
    criteria = Criteria()
    failures: dict[str, str] = {}
    marks: tuple[Mark, ...]
    if not judged:
        return Report("recordings", "the recorded diagnoses", criteria, "", marked(tapes, criteria))
    if candidate.node is None:
        with _progress("examined", len(tapes)) as told:
            found = examine_reference_on(tapes, candidate.parameters, workers, told)
    else:
        found, failures = _examine_node(dict(zip(names, bags, strict=True)), candidate.node, candidate.rate, candidate.patience)
    marks = tuple(mark(t.question, found[t.question.name], criteria, failure=failures.get(t.question.name, "")) for t in tapes)
    return Report("recordings", candidate.name, criteria, "", marks)


def _names(bags: Sequence[Path]) -> list[str]:
    """Return a name for each recording: its folder's, or the whole path where two have the same."""
    short = [bag.resolve().name for bag in bags]
    names = [name if short.count(name) == 1 else str(bag) for name, bag in zip(short, bags, strict=True)]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise Refusal(f"{twice} is given twice: a recording counts once")
    return names


@contextmanager
def _progress(words: str, total: int) -> Iterator[Callable[[str], None]]:
    """Yield what is called with the name of each scenario that is done."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("scenarios " + words),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.description}", markup=False),
    )
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task("", total=total)
        yield lambda name: progress.update(task, advance=1, description=name)


def _tell(report: Report, as_json: bool, junit: Path | None, figure: Path | None) -> None:
    """Print a report, and then write it: what is printed is there even where a file cannot be written."""
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


def _print(report: Report) -> None:
    from rich.console import Console

    from dcrb_ros.exam.table import tables

    console = Console()
    Console(width=None if console.is_terminal else 140, highlight=False).print(tables(report))
