"""The report as tables on a terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rich.console import Group as Stack
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from dcrb_ros import __version__
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.statistics import CONFIDENCE, Interval
from dcrb_ros.recordings.manifest import model_fingerprint

MOST_FLAWS = 40
"""Scenarios that went wrong and are listed; JSON and JUnit have them all."""


def number(value: float, digits: int = 2) -> str:
    """Return a number, or a dash where there is none."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def bounds(interval: Interval, digits: int = 2) -> str:
    """Return an estimate with its bounds."""
    return f"{number(interval.value, digits)} ({number(interval.low, digits)} .. {number(interval.high, digits)})"


def tables(report: Report) -> RenderableType:
    """Return everything that a terminal shows of a report."""
    shown: list[RenderableType] = [
        _checks(report),
        *_delays(report),
        *_detections(report),
        _confusion(report),
        *_flaws(report),
        *words(report),
    ]
    return Stack(*shown)


def words(report: Report) -> Iterator[str]:
    """Yield what takes a sentence."""
    yield (
        "false alarms: nothing to count, for there is no healthy signal"
        if not report.hours
        else f"false alarms: {report.alarms} in {report.hours * 60.0:.1f} min of healthy signal, {bounds(report.alarm_rate(), 1)} an hour "
        f"({CONFIDENCE:.0%} Poisson bounds)"
    )
    curve = report.characteristic()
    yield (
        f"ROC: area {curve.area:.3f} over {len(curve.threshold)} thresholds"
        if curve
        else "ROC: none, for the detector publishes neither score nor confidence, or not on both faulty and healthy scenarios"
    )
    if report.scenarios:
        yield f"scenarios: sha256 {report.scenarios}"
    yield f"dcrb_ros {__version__}, model {model_fingerprint()}"


def _checks(report: Report) -> Table:
    # What users name is text: a name in brackets is no markup.
    title = Text(f"{report.exam}: {'passed' if report.passed else 'FAILED'}, {report.detector}")
    table = Table("criterion", "wanted", "got", "", title=title)
    for check in report.checks():
        table.add_row(check.name, check.wanted, check.got, "holds" if check.holds else "FAILS", style="" if check.holds else "bold red")
    return table


def _delays(report: Report) -> Iterator[Table]:
    rows = report.delays()
    if rows:
        table = Table("fault", "found", "delay, median [s]", "95 % [s]", "limit [s]", title="Delay of the right verdict")
        for row in rows:
            table.add_row(row.verdict, f"{row.found} of {row.asked}", number(row.median), number(row.late), f"{row.limit:g}")
        yield table


def _detections(report: Report) -> Iterator[Table]:
    rows = report.detections()
    if rows:
        table = Table(
            "fault", "width [mm]", "found", "probability of detection", title=f"By width, {CONFIDENCE:.0%} bounds (Clopper-Pearson)"
        )
        for row in rows:
            table.add_row(row.verdict, f"{row.width * 1e3:g}", f"{row.found} of {row.asked}", bounds(row.probability))
        yield table


def _confusion(report: Report) -> Table:
    found = report.confusion()
    answers = [answer for answer in next(iter(found.values()), {}) if any(row[answer] for row in found.values())]
    table = Table("true \\ said", *answers, title="Right verdict and answer")
    for verdict, row in found.items():
        cells = [f"[bold]{row[a]}[/bold]" if a == verdict else f"[red]{row[a]}[/red]" if row[a] else "." for a in answers]
        table.add_row(verdict, *cells)
    return table


def _flaws(report: Report) -> Iterator[RenderableType]:
    wrong = [mark for mark in report.marks if not mark.passed]
    if not wrong:
        return
    table = Table("scenario", "right", "what went wrong", title=f"{len(wrong)} of {len(report.marks)} scenarios went wrong")
    for mark in wrong[:MOST_FLAWS]:
        counts = "" if mark.question.required else " (not required)"
        table.add_row(Text(mark.question.name + counts), mark.question.verdict, Text(mark.flaw))
    yield table
    if len(wrong) > MOST_FLAWS:
        yield f"and {len(wrong) - MOST_FLAWS} more: --json or --junit has them all"
