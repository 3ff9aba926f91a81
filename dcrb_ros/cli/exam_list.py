"""The scenarios of an exam as a list on the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from dcrb_ros.runtime.terminal import console, table
from dcrb_ros.text.counts import counted

if TYPE_CHECKING:
    from dcrb_ros.exam.exam_file import Exam
    from dcrb_ros.exam.kinds import AnyExam
    from dcrb_ros.exam.vehicle.exam_file import VehicleExam

HEADS = ("scenario", "correct verdict", "onset [s]", "duration [s]", "twin")
LONGEST_TABLE = 300
"""Scenarios up to which they are a table with lines; a longer list is plain columns, which take a tenth of the time."""


def print_scenarios(exam: AnyExam) -> None:
    """Print the scenarios of an exam with their correct verdicts, and the hash of them all."""
    from dcrb_ros.exam.exam_file import Exam

    if not isinstance(exam, Exam):
        _print_vehicles(exam)
        return
    rows = list(_cells(exam))
    title = _title(exam)
    if len(rows) <= LONGEST_TABLE:
        console().print(table(title, HEADS, rows))
    else:
        _print_columns(title, rows)
    seconds = sum(case.simulation.duration for case in exam.cases)
    print(f"{counted(len(exam.cases), 'scenario')}, {seconds:.0f} s simulated, sha256 {exam.digest}")


def _title(exam: AnyExam) -> str:
    return f"{exam.name}: {exam.about}" if exam.about else exam.name


def _cells(exam: Exam) -> Iterable[tuple[str, ...]]:
    from dcrb_ros.exam.exam_scenarios import expectations

    for expectation in expectations(exam):
        name = expectation.name if expectation.required else f"{expectation.name} (not required)"
        onset = f"{expectation.onset:g}" if expectation.faulty else "-"
        yield name, expectation.verdict, onset, f"{expectation.duration:g}", expectation.twin or "-"


def _print_columns(title: str, rows: Sequence[tuple[str, ...]], heads: tuple[str, ...] = HEADS) -> None:
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in (heads, *rows))
    console().print("\n".join([title, *lines]), soft_wrap=True)


def _print_vehicles(exam: VehicleExam) -> None:
    """Print the vehicles of an exam with the boxes that are not healthy, and the hash of them all."""
    heads = ("scenario", "not healthy", "duration [s]")
    rows = [
        (case.name, ", ".join(f"{box} {verdict}" for box, verdict in case.damaged.items()) or "-", f"{case.duration:g}")
        for case in exam.cases
    ]
    _print_columns(_title(exam), rows, heads)
    seconds = sum(case.duration for case in exam.cases)
    print(f"{counted(len(exam.cases), 'vehicle')}, {seconds:.0f} s simulated, sha256 {exam.digest}")
