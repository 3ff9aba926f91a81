"""The scenarios of an exam as a list on the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from dcrb_ros.runtime.terminal import console, table
from dcrb_ros.text.counts import counted

if TYPE_CHECKING:
    from dcrb_ros.exam.exam_file import Exam
    from dcrb_ros.exam.kinds import AnyExam
    from dcrb_ros.exam.vehicle.exam_file import VehicleExam

HEADS: tuple[str, ...] = ("scenario", "correct verdict", "onset [s]", "duration [s]", "twin")
VEHICLE_HEADS: tuple[str, ...] = ("scenario", "not healthy", "duration [s]")
LONGEST_TABLE = 300
"""Scenarios up to which they are a table with lines; a longer list is plain columns, which take a tenth of the time."""


def print_scenarios(exam: AnyExam) -> None:
    """Print the scenarios of an exam with their correct verdicts, and the hash of them all."""
    from dcrb_ros.exam.exam_file import Exam

    title = f"{exam.name}: {exam.about}" if exam.about else exam.name
    if isinstance(exam, Exam):
        heads, rows, kind = HEADS, list(_cells(exam)), "scenario"
        seconds = sum(case.simulation.duration for case in exam.cases)
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


def _cells(exam: Exam) -> Iterable[tuple[str, ...]]:
    from dcrb_ros.exam.exam_scenarios import expectations

    for expectation in expectations(exam):
        name = expectation.name if expectation.required else f"{expectation.name} (not required)"
        onset = f"{expectation.onset:g}" if expectation.faulty else "-"
        yield name, expectation.verdict, onset, f"{expectation.duration:g}", expectation.twin or "-"


def _vehicle_cells(exam: VehicleExam) -> Iterable[tuple[str, ...]]:
    for case in exam.cases:
        yield case.name, ", ".join(f"{box} {verdict}" for box, verdict in case.damaged.items()) or "-", f"{case.duration:g}"
