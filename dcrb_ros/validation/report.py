"""The report: the table, the figures, what the paper leaves open and where we disagree with it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources

from dcrb_ros import __version__
from dcrb_ros.validation.comparison import Comparison
from dcrb_ros.validation.runs import RunSpec

HEADINGS = ("quantity", "joint", "paper", "ours", "accepted", "verdict")
CAPTIONS = {
    8: "Rotation of the components from a cold start, as Fig. 8.",
    9: "A healthy roller at the inner raceway over its azimuth, as Fig. 9.",
    10: "Forces and friction torque of a roller without and with faults, as Fig. 10.",
    11: "Acceleration of the outer ring and its envelope spectrum, as Fig. 11.",
}


def cells(row: Comparison) -> tuple[str, ...]:
    """Return a row as texts in the order of `HEADINGS`."""
    return row.quantity, row.joint, row.paper, row.ours, row.accept, row.verdict


def summary(rows: Sequence[Comparison]) -> str:
    """Return how many rows hold, as a sentence."""
    short = sum(not row.holds for row in rows)
    return f"All {len(rows)} rows hold." if not short else f"{short} of {len(rows)} rows fall short."


def markdown(rows: Sequence[Comparison], cases: Sequence[RunSpec], figures: Sequence[str]) -> str:
    """Return the report as Markdown; the figures lie beside it."""
    lines = [
        "# dcrb_ros against Fan et al. 2025",
        "",
        f"Made by `dcrb validate` of dcrb_ros {__version__}. The paper: *Lubricants* 13(2), 80. {summary(rows)}",
        "",
        "`revolute` is the paper's model: the shipped configuration `paper`. `pocket` is the default bench, whose rollers are free "
        "between the cage's bars: the shipped configuration `healthy`, here at the paper's speed of 124.8 rad/s.",
        "",
        "## Numbers",
        "",
        "| " + " | ".join(HEADINGS) + " |",
        "|" + "---|" * len(HEADINGS),
        *("| " + " | ".join(cells(row)) + " |" for row in rows),
        "",
        "## Figures",
        "",
    ]
    for name in figures:
        number = int(name.split("_")[1])
        lines += [f"![{CAPTIONS[number]}]({name})", "", f"*{CAPTIONS[number]} {name.split('_')[2].removesuffix('.png').capitalize()}.*", ""]
    lines += [resources.files("dcrb_ros.validation").joinpath("assumptions.md").read_text(encoding="utf-8")]
    lines += ["## Runs", "", "Each run of the table as a command:", ""]
    lines += [f"* {case.name}, {case.joint}: `{case.command}`" for case in cases]
    return "\n".join(lines) + "\n"
