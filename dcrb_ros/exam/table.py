"""The report as tables for a terminal that prints text literally (`dcrb_ros.runtime.terminal`)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rich.console import Group as Stack
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from dcrb_ros.exam.breakdown import PARTIAL, family_areas, overall_area, strata
from dcrb_ros.exam.criteria import UNLIMITED
from dcrb_ros.exam.marking import report_mark
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import ScenarioResult
from dcrb_ros.exam.statistics import CONFIDENCE, Interval
from dcrb_ros.recordings.manifest import model_fingerprint
from dcrb_ros.runtime.terminal import table
from dcrb_ros.runtime.version import __version__
from dcrb_ros.settings.files import fields_by_key

MOST_FAILURES = 40
"""Failed scenarios listed at most [-]; JSON and JUnit contain all of them."""


def number(value: float, digits: int = 2) -> str:
    """Return a number as text, a dash for NaN and infinity."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def bounds(interval: Interval, digits: int = 2) -> str:
    """Return an estimate with its confidence interval as text."""
    return f"{number(interval.value, digits)} ({number(interval.low, digits)} .. {number(interval.high, digits)})"


def tables(report: Report) -> RenderableType:
    """Return all tables and sentences of a report."""
    shown: list[RenderableType] = [
        _checks(report),
        *_scores(report),
        *_delays(report),
        *_detections(report),
        *_graded_detections(report),
        *_strata(report),
        *_rigs(report),
        *_areas(report),
        _confusion(report),
        *_failures(report),
        *sentences(report),
    ]
    return Stack(*shown)


def sentences(report: Report) -> Iterator[str]:
    """Yield the results that are given as sentences."""
    yield (
        "false alarms: not counted, there is no healthy signal"
        if not report.hours
        else f"false alarms: {report.alarms} in {_healthy_time(report)}, {bounds(report.alarm_rate(), 1)} per hour "
        f"({CONFIDENCE:.0%} Poisson confidence interval)"
    )
    if report.healthy_revolutions:
        yield (
            f"false alarms per 1000 bearing-hours: {bounds(Interval(*(1e3 * value for value in report.alarm_rate())), 0)}; per million "
            f"revolutions, of which {report.healthy_revolutions:.0f} are healthy: {bounds(report.alarm_rate_per_turn(), 0)}"
        )
    if report.results and not report.last_verdict:
        yield f"time without a verdict: {report.silent_share:.1%}"
    curve = report.characteristic()
    yield (
        f"ROC: area {curve.area:.3f} over {sum(map(math.isfinite, curve.threshold))} thresholds"
        if curve
        else "ROC: none, the detector publishes no score or confidence for both faulty and healthy scenarios"
    )
    if report.scenarios:
        yield f"scenarios: sha256 {report.scenarios}"
    yield f"dcrb_ros {__version__}, model {model_fingerprint()}"


def _healthy_time(report: Report) -> str:
    """Return the healthy time as text, with the part of it that is not repeated."""
    once = f" ({report.distinct_hours * 60.0:.1f} min without repetitions)" if report.repeats > 1.0 + 1e-9 else ""
    return f"{report.hours * 60.0:.1f} min of healthy signal{once}"


def _checks(report: Report) -> Table:
    title = f"{report.exam}: {'passed' if report.passed else 'FAILED'}, {report.detector}"
    made = Table("criterion", "required", "result", "status", title=title)
    for check in report.checks():
        made.add_row(check.name, check.wanted, check.got, "passed" if check.holds else "FAILED", style="" if check.holds else "bold red")
    return made


def _filled(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[Table]:
    """Yield a table, unless it has no rows."""
    if rows:
        yield table(title, heads, rows)


def _scores(report: Report) -> Iterator[RenderableType]:
    # The exam score counts delays and silence, which are no part of the task if only the last verdict counts.
    if report.results and report.last_verdict:
        mark = bounds(report_mark(report), 1)
        yield f"correct verdicts in the required scenarios, mean over their classes: {mark} % ({CONFIDENCE:.0%} bootstrap interval)"
        return
    rows = [(row.profile, bounds(row.score, 1), number(row.detection, 3), number(row.clean, 3)) for row in report.exam_scores()]
    if not rows:
        yield "exam score: none, it takes both faults and healthy time"
    title = f"Exam score, 0 to 100, {CONFIDENCE:.0%} confidence (bootstrap over scenarios)"
    yield from _filled(title, ("profile", "exam score", "credit for faults", "factor for false alarms"), rows)


def _strata(report: Report) -> Iterator[Table]:
    rows = [(row.name, f"{row.found} of {row.scenarios}", number(row.credit)) for row in strata(report.results, report.criteria)]
    if len(rows) > 1:
        yield table("By difficulty", ("width of the defect", "detected", "credit"), rows)


def _areas(report: Report) -> Iterator[Table]:
    areas = family_areas(report.results)
    title = f"Published score, without a threshold (harmonic mean {number(overall_area(areas), 3)})"
    rows = [(row.verdict, number(row.area, 3), "-" if row.partial is None else number(row.partial, 3)) for row in areas]
    return _filled(title, ("fault", "ROC area", f"ROC area up to {PARTIAL:g} false positives"), rows)


def _delays(report: Report) -> Iterator[Table]:
    rows = [
        (row.verdict, f"{row.found} of {row.scenarios}", number(row.median), number(row.p95), _limit(row.limit), number(row.turns, 1))
        for row in report.delays()
    ]
    return _filled("Detection delay", ("fault", "detected", "median [s]", "95 % [s]", "limit [s]", "median [revolutions]"), rows)


def _limit(limit: float) -> str:
    """Return a limit of the delay as text [s], a dash if there is none."""
    return f"{limit:g}" if limit < UNLIMITED else "-"


def _detections(report: Report) -> Iterator[Table]:
    rows = [
        (row.verdict, f"{row.value * 1e3:g}", f"{row.found} of {row.scenarios}", bounds(row.probability)) for row in report.detections()
    ]
    title = f"Detection by width, {CONFIDENCE:.0%} confidence (Clopper-Pearson)"
    return _filled(title, ("fault", "width [mm]", "detected", "probability of detection"), rows)


def _graded_detections(report: Report) -> Iterator[Table]:
    rows = [
        (row.verdict, _with_unit(row.parameter), f"{row.value:g}", f"{row.found} of {row.scenarios}", bounds(row.probability))
        for row in report.graded_detections()
    ]
    title = f"Detection by another parameter than the width, {CONFIDENCE:.0%} confidence (Clopper-Pearson)"
    return _filled(title, ("fault", "parameter", "value", "detected", "probability of detection"), rows)


def _with_unit(key: str) -> str:
    """Return a parameter with its unit."""
    field = fields_by_key().get(key)
    return f"{key} [{field.unit}]" if field and field.unit not in ("", "-") else key


def _rigs(report: Report) -> Iterator[Table]:
    rows = [(row.rig, row.verdict, f"{row.right} of {row.recordings}", f"{row.alarms} of {row.recordings}") for row in report.rigs()]
    return _filled("Recordings by rig", ("rig", "correct verdict", "correct", "any alarm"), rows)


def _confusion(report: Report) -> Table:
    counts = report.confusion()
    answers = [answer for answer in next(iter(counts.values()), {}) if any(row[answer] for row in counts.values())]
    rows: list[list[str | Text]] = [
        [verdict, *(_count(row[answer], correct=answer == verdict) for answer in answers)] for verdict, row in counts.items()
    ]
    return table("Scenarios by correct verdict and answer", ("correct \\ answer", *answers), rows)


def _count(count: int, *, correct: bool) -> Text:
    """Return a number of scenarios: correct answers bold, wrong ones red, or a dot if there are none."""
    if correct:
        return Text(str(count), style="bold")
    return Text(str(count), style="red") if count else Text(".")


def _failures(report: Report) -> Iterator[RenderableType]:
    wrong = [result for result in report.results if not result.passed]
    shown = ((result, result.expectation) for result in wrong[:MOST_FAILURES])
    rows = [(e.name + (" (not required)" if result.excused else ""), e.verdict, _reason(result)) for result, e in shown]
    yield from _filled(f"{len(wrong)} of {len(report.results)} scenarios failed", ("scenario", "correct verdict", "reason"), rows)
    if len(wrong) > MOST_FAILURES:
        yield f"and {len(wrong) - MOST_FAILURES} more: --json and --junit list all of them"


def _reason(result: ScenarioResult) -> str:
    """Return why a scenario failed, with the detector's reason for a wrong verdict ``sensor``."""
    if result.broken or "sensor" not in result.flaw:
        return result.flaw
    given = next((diagnosis.reason for diagnosis in result.received if diagnosis.verdict == "sensor"), "")
    return f"{result.flaw}: {given}" if given else result.flaw
