"""The report as a figure: probability of detection over width, detection delays, confusion matrix, ROC."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dcrb_ros.exam.criteria import UNLIMITED
from dcrb_ros.exam.marking import report_mark
from dcrb_ros.exam.report import Report
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import FAULTS
from dcrb_ros.text.writing import whole_file

SUFFIXES = (".png", ".svg", ".pdf")


def write_figure(report: Report, file: Path) -> None:
    """Draw the report.

    Raises:
        Refusal: the file type is unknown, or the file cannot be written.
    """
    if file.suffix.lower() not in SUFFIXES:
        raise Refusal(f"--figure {file} has an unknown file type: the name must end in one of {', '.join(SUFFIXES)}")
    panels = {"detection": _detection, "delay": _delay, "confusion": _confusion, "roc": _roc}
    if report.graded_detections():
        figure = Figure(figsize=(15, 8), dpi=90, layout="constrained")
        axes = figure.subplot_mosaic([["detection", "graded", "delay"], ["confusion", "confusion", "roc"]])
        panels["graded"] = _graded
    else:
        figure = Figure(figsize=(11, 8), dpi=90, layout="constrained")
        axes = figure.subplot_mosaic([["detection", "delay"], ["confusion", "roc"]])
    for name, draw in panels.items():
        draw(axes[name], report)
    title = f"{report.exam}: {'passed' if report.passed else 'failed'}, {report.detector}"
    figure.suptitle("\n".join([title, *_marks(report)]), fontsize=12, parse_math=False)
    with whole_file(file) as temporary:
        figure.savefig(temporary)


def _marks(report: Report) -> Iterator[str]:
    """Yield the line below the title: the mark of the report, if it has one."""
    if report.results and report.last_verdict:
        yield f"correct verdicts: {report_mark(report).value:.1f} %"
    elif scores := report.exam_scores():
        yield f"exam score of 100: {', '.join(f'{score.profile} {score.score.value:.1f}' for score in scores)}"


def _empty(axes: Axes, text: str) -> None:
    axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes, color="#666666", wrap=True)
    axes.set_xticks([])
    axes.set_yticks([])


def _detection(axes: Axes, report: Report) -> None:
    axes.set_title("Probability of detection, 95 % confidence", fontsize=10)
    rows = report.detections()
    if not rows:
        of_replica = any(result.expectation.width and result.expectation.last_verdict for result in report.faulty)
        _empty(axes, "widths on different bearings\nare not compared" if of_replica else "no defect with a width")
        return
    verdicts, widest = list(dict.fromkeys(row.verdict for row in rows)), max(row.value for row in rows) * 1e3
    for position, verdict in enumerate(verdicts):
        shown = [row for row in rows if row.verdict == verdict]
        shift = 0.012 * widest * (position - 0.5 * (len(verdicts) - 1))
        shares = [row.probability for row in shown]
        error = [[p.value - p.low for p in shares], [p.high - p.value for p in shares]]
        widths = [row.value * 1e3 + shift for row in shown]
        style: dict[str, Any] = {"marker": "o", "ms": 4, "lw": 1.2, "capsize": 3, "color": FAULTS[verdict].colour}
        axes.errorbar(widths, [p.value for p in shares], error, label=verdict, **style)
    axes.axvline(report.criteria.smallest_width * 1e3, color="black", lw=0.8, ls=":", label="smallest required width")
    axes.set(xlabel="width [mm]", ylabel="detected in time, correct verdict [-]", ylim=(-0.03, 1.03), xlim=(0.0, 1.1 * widest))
    axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3, frameon=False)
    axes.grid(alpha=0.25)


def _graded(axes: Axes, report: Report) -> None:
    """Draw the detections over other parameters than the width, each relative to its largest value."""
    axes.set_title("Probability of detection over other parameters", fontsize=10)
    rows, lowest = report.graded_detections(), 1.0
    for verdict, parameter in dict.fromkeys((row.verdict, row.parameter) for row in rows):
        shown = [row for row in rows if (row.verdict, row.parameter) == (verdict, parameter)]
        largest = max(abs(row.value) for row in shown) or 1.0
        relative = [row.value / largest for row in shown]
        lowest = min([lowest, *(abs(value) for value in relative if value)])
        label = f"{verdict}, {parameter.rsplit('.')[-1]} to {largest:g}"
        axes.plot(relative, [row.probability.value for row in shown], marker="o", ms=4, lw=1.2, color=FAULTS[verdict].colour, label=label)
    axes.set_xscale("symlog", linthresh=lowest)
    axes.set(xlabel="value relative to the largest [-]", ylabel="detected in time, correct verdict [-]", ylim=(-0.03, 1.03))
    axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=2, frameon=False)
    axes.grid(alpha=0.25)


def _delay(axes: Axes, report: Report) -> None:
    axes.set_title("Detection delay", fontsize=10)
    rows = [row for row in report.delays() if row.scenarios]
    if not rows:
        _empty(axes, "no scenario with a fault")
        return
    longest = max(result.expectation.end - result.expectation.onset for result in report.faulty)
    limited = any(row.limit < UNLIMITED for row in rows)
    for position, row in enumerate(rows):
        delays = [m.delay for m in report.faulty if m.expectation.verdict == row.verdict and m.found and m.delay is not None]
        spread = np.linspace(-0.2, 0.2, len(delays)) if len(delays) > 1 else np.zeros(len(delays))
        axes.plot(position + spread, delays, "o", ms=3.5, alpha=0.7, color=FAULTS[row.verdict].colour)
        if math.isfinite(row.median):
            axes.hlines(row.median, position - 0.3, position + 0.3, color="black", lw=1.5)
        if row.limit < UNLIMITED:
            axes.hlines(row.limit, position - 0.4, position + 0.4, color="red", lw=1.0, ls="--")
        if not delays:
            height = 0.5 * (row.limit if limited else longest)
            axes.text(position, height, "none detected\nin time", ha="center", va="center", fontsize=8, color="#666666")
    axes.plot([], [], color="black", lw=1.5, label="median")
    if limited:
        axes.plot([], [], color="red", lw=1.0, ls="--", label="limit")
    axes.set_xticks(range(len(rows)), [f"{row.verdict}\n{row.found} of {row.scenarios}" for row in rows], fontsize=8)
    axes.set(ylabel="delay [s]", ylim=(0.0, None if limited else longest), xlim=(-0.6, len(rows) - 0.4))
    axes.legend(fontsize=8, loc="center right")
    axes.grid(alpha=0.25, axis="y")


def _confusion(axes: Axes, report: Report) -> None:
    axes.set_title("Scenarios by correct verdict (rows) and answer (columns)", fontsize=10)
    counted = report.confusion()
    answers = [answer for answer in next(iter(counted.values()), {}) if answer in counted or any(row[answer] for row in counted.values())]
    counts = np.array([[row[answer] for answer in answers] for row in counted.values()], dtype=float).reshape(len(counted), len(answers))
    if not counts.size:
        _empty(axes, "no scenario")
        return
    words = [
        [f"{row[answer]}{_late(report, verdict) if answer == verdict else ''}" for answer in answers] for verdict, row in counted.items()
    ]
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)
    right = np.array([[answer == verdict for answer in answers] for verdict in counted])
    axes.imshow(np.ma.masked_where(~right, shares), cmap="Blues", vmin=0.0, vmax=1.2, aspect="auto")
    axes.imshow(np.ma.masked_where(right, shares), cmap="Reds", vmin=0.0, vmax=1.2, aspect="auto")
    for i, j in np.ndindex(shares.shape):
        colour, weight = "white" if shares[i, j] > 0.6 else "black", "bold" if right[i, j] else "normal"
        axes.text(j, i, words[i][j], ha="center", va="center", fontsize=9, color=colour, fontweight=weight)
    axes.set_xticks(range(len(answers)), answers, rotation=35, ha="right", fontsize=8)
    axes.set_yticks(range(len(counted)), list(counted), fontsize=8)


def _late(report: Report, verdict: str) -> str:
    """Return how many correct answers of a fault were detections in time, if not all of them were."""
    correct = [result for result in report.faulty if result.expectation.verdict == verdict == result.answer]
    in_time = sum(result.found for result in correct)
    return f"\n{in_time} in time" if in_time < len(correct) else ""


def _roc(axes: Axes, report: Report) -> None:
    curve = report.characteristic()
    axes.set_title("ROC, one score per scenario", fontsize=10)
    if curve is None:
        _empty(axes, "no score or confidence for both\nfaulty and healthy scenarios")
        return
    # Straight lines between the thresholds: where faulty and healthy runs have the same score, the curve is a diagonal.
    axes.plot(curve.false, curve.true, color="#1f6fb4", lw=1.5, label=f"area {curve.area:.3f}")
    axes.plot([0.0, 1.0], [0.0, 1.0], color="#8a8a8a", lw=0.8, ls=":")
    axes.set(xlabel="false positive rate [-]", ylabel="true positive rate, bearing faults [-]", xlim=(-0.02, 1.02), ylim=(-0.02, 1.02))
    axes.legend(fontsize=8, loc="lower right")
    axes.grid(alpha=0.25)
