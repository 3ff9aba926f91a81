"""The marks of detectors in the exam over those in the field, as a figure."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from dcrb_ros.exam.predictivity_report import Comparison, pooled
from dcrb_ros.text.writing import whole_file

COLOURS = ("#1f6fb4", "#b23a48")
"""Of members with published and with other settings."""
LONGEST = 28
"""Longest name shown [characters]."""
RIGHT_HALF = 60.0
"""Mark in the exam from which labels are on the left of their points [%]."""


def write_predictivity_figure(comparison: Comparison, file: Path) -> None:
    """Draw the marks of all detectors, those with published settings with their names.

    Raises:
        Refusal: the file cannot be written.
    """
    exam, field = (100.0 * values for values in pooled(comparison.marks))
    figure = Figure(figsize=(8.0, 7.0), dpi=110, layout="constrained")
    axes = figure.subplots()
    axes.plot([0.0, 100.0], [0.0, 100.0], color="0.8", lw=1.0, zorder=0)
    for published, colour, label in ((False, COLOURS[1], "other settings"), (True, COLOURS[0], "published settings")):
        chosen = [k for k, one in enumerate(comparison.marks.published) if one is published]
        axes.plot(exam[chosen], field[chosen], "o", ms=5.0 if published else 3.5, color=colour, label=label, alpha=0.8)
    # Detectors with the same marks share a label.
    labels: dict[tuple[float, float], list[str]] = {}
    for k, name in enumerate(comparison.marks.detectors):
        if comparison.marks.published[k]:
            short = name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}…"
            labels.setdefault((round(float(exam[k]), 1), round(float(field[k]), 1)), []).append(short)
    for place, names in labels.items():
        left = place[0] > RIGHT_HALF
        axes.annotate(
            "\n".join(names),
            place,
            (-5.0 if left else 5.0, 0.0),
            textcoords="offset points",
            ha="right" if left else "left",
            va="center",
            fontsize=6,
            parse_math=False,
        )
    best = comparison.families[0].statistics
    axes.set_title(
        f"{len(set(comparison.marks.families))} families: SRCC {best['srcc'].value:.2f}, tau-b {best['tau_b'].value:.2f}", fontsize=11
    )
    axes.set(xlabel="right in the exam of replicas [%]", ylabel="right on measured recordings [%]", xlim=(0.0, 102.0), ylim=(0.0, 102.0))
    axes.legend(fontsize=8, loc="lower right")
    axes.grid(alpha=0.25)
    with whole_file(file) as temporary:
        figure.savefig(temporary)
