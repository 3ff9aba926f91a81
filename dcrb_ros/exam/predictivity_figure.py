"""The marks of detectors in the exam over those in the field, as a figure."""

from __future__ import annotations

import math
from pathlib import Path

from matplotlib.figure import Figure

from dcrb_ros.exam.predictivity_report import Comparison, pooled
from dcrb_ros.schema.printable import printable, shortened
from dcrb_ros.text.writing import whole_file

COLOURS = ("#1f6fb4", "#b23a48")
"""Of members with published and with other settings."""
LONGEST = 28
"""Longest name shown [characters]."""


def write_predictivity_figure(comparison: Comparison, file: Path) -> None:
    """Draw the marks of all detectors, those with published settings with their names.

    Raises:
        Refusal: the file cannot be written.
    """
    exam, field = (100.0 * values for values in pooled(comparison.marks))
    figure = Figure(figsize=(9.5, 7.0), dpi=110, layout="constrained")
    axes = figure.subplots()
    axes.plot([0.0, 100.0], [0.0, 100.0], color="0.8", lw=1.0, zorder=0)
    for published, colour, label in ((False, COLOURS[1], "other settings"), (True, COLOURS[0], "published settings")):
        chosen = [k for k, one in enumerate(comparison.marks.published) if one is published]
        if not chosen:
            continue
        axes.plot(exam[chosen], field[chosen], "o", ms=5.0 if published else 3.5, color=colour, label=label, alpha=0.8)
    # Names would cover each other where many detectors have similar marks, so points have numbers in the order of the field.
    named = sorted((k for k in range(len(exam)) if comparison.marks.published[k]), key=lambda k: (-field[k], -exam[k]))
    for number, k in enumerate(named, 1):
        above = number % 2 == 0
        axes.annotate(str(number), (exam[k], field[k]), (4.0, 3.0 if above else -8.0), textcoords="offset points", fontsize=7)
    short = [shortened(printable(comparison.marks.detectors[k]), LONGEST, "…") for k in named]
    listed = "\n".join(f"{number:2d}  {name}" for number, name in enumerate(short, 1))
    axes.text(1.02, 1.0, listed, transform=axes.transAxes, va="top", fontsize=7, linespacing=1.25, parse_math=False)
    low = max(0.0, 10.0 * math.floor(min(float(exam.min()), float(field.min())) / 10.0) - 5.0)
    best = comparison.families[0].statistics
    axes.set_title(
        f"{comparison.families[0].detectors} families: SRCC {best['srcc'].value:.2f}, tau-b {best['tau_b'].value:.2f}", fontsize=11
    )
    axes.set(xlabel="right in the exam of replicas [%]", ylabel="right on measured recordings [%]", xlim=(low, 102.0), ylim=(low, 102.0))
    axes.legend(fontsize=8, loc="lower right")
    axes.grid(alpha=0.25)
    with whole_file(file) as temporary:
        figure.savefig(temporary)
