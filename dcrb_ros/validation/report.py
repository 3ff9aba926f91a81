"""The report: table, figures, the assumptions where the paper is incomplete, and the differences from the paper."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources

from dcrb_ros.runtime.version import __version__
from dcrb_ros.text.markdown import table
from dcrb_ros.validation.comparison import Comparison
from dcrb_ros.validation.oiled_runs import OiledSpec
from dcrb_ros.validation.runs import RunSpec

HEADINGS = ("quantity", "joint", "paper", "this model", "accepted", "result")
CAPTIONS = {
    8: "Rotation of the components from a cold start, as in Fig. 8.",
    9: "A healthy roller at the inner raceway over its azimuth, as in Fig. 9.",
    10: "Forces and friction torque of a roller without and with faults, as in Fig. 10.",
    11: "Acceleration of the outer ring and its envelope spectrum, as in Fig. 11.",
}


def cells(comparison: Comparison) -> tuple[str, ...]:
    """Return the cells of a comparison in the order of `HEADINGS`."""
    return comparison.quantity, comparison.joint, comparison.paper, comparison.found, comparison.accepted, comparison.verdict


def summary(comparisons: Sequence[Comparison]) -> str:
    """Return a sentence on how many comparisons hold."""
    short = sum(not comparison.holds for comparison in comparisons)
    return f"All {len(comparisons)} comparisons hold." if not short else f"{short} of {len(comparisons)} comparisons fall short."


def chapters(comparisons: Sequence[Comparison]) -> dict[str, list[Comparison]]:
    """Return the comparisons by chapter, in their order."""
    found: dict[str, list[Comparison]] = {}
    for comparison in comparisons:
        found.setdefault(comparison.chapter, []).append(comparison)
    return found


def tables(comparisons: Sequence[Comparison]) -> list[str]:
    """Return a heading and a table for each chapter."""
    lines: list[str] = []
    for title, part in chapters(comparisons).items():
        lines += [f"### {title}", "", table(HEADINGS, map(cells, part)), ""]
    return lines


def markdown(comparisons: Sequence[Comparison], specs: Sequence[RunSpec | OiledSpec], figures: Sequence[str]) -> str:
    """Return the report as Markdown; the figures are files in the same folder."""
    lines = [
        "# Validation of dcrb_ros against Fan et al. 2025",
        "",
        f"Made by `dcrb validate` of dcrb_ros {__version__}. The paper: *Lubricants* 13(2), 80. {summary(comparisons)}",
        "",
        "`revolute` is the paper's model, the shipped configuration `paper`. In `pocket` the rollers are free "
        "between the cage bars: the shipped configuration `dry`, here at the paper's speed of 124.8 rad/s.",
        "",
        "## Numbers",
        "",
        *tables(comparisons),
        "## Figures",
        "",
    ]
    for name in figures:
        number = int(name.split("_")[1])
        lines += [f"![{CAPTIONS[number]}]({name})", "", f"*{CAPTIONS[number]} {name.split('_')[2].removesuffix('.png').capitalize()}.*", ""]
    lines += [resources.files("dcrb_ros.validation").joinpath("assumptions.md").read_text(encoding="utf-8")]
    lines += ["## Runs", "", "The commands that record the runs of the table:", ""]
    lines += [f"* {spec.label}: `{spec.command}`" for spec in specs]
    return "\n".join(lines) + "\n"
