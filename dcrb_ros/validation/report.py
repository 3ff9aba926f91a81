"""The report: table, figures, the assumptions where the paper is incomplete, and the differences from the paper."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources

from dcrb_ros.runtime.version import __version__
from dcrb_ros.text.markdown import table
from dcrb_ros.validation.report_row import ReportRow
from dcrb_ros.validation.runs import RunSpec

HEADINGS = ("quantity", "joint", "paper", "this model", "accepted", "result")
CAPTIONS = {
    8: "Rotation of the components from a cold start, as in Fig. 8.",
    9: "A healthy roller at the inner raceway over its azimuth, as in Fig. 9.",
    10: "Forces and friction torque of a roller without and with faults, as in Fig. 10.",
    11: "Acceleration of the outer ring and its envelope spectrum, as in Fig. 11.",
}


def cells(row: ReportRow) -> tuple[str, ...]:
    """Return the cells of a row in the order of `HEADINGS`."""
    return row.quantity, row.joint, row.paper, row.found, row.accepted, row.verdict


def summary(rows: Sequence[ReportRow]) -> str:
    """Return a sentence on how many rows hold."""
    short = sum(not row.holds for row in rows)
    return f"All {len(rows)} comparisons hold." if not short else f"{short} of {len(rows)} comparisons fall short."


def chapters(rows: Sequence[ReportRow]) -> dict[str, list[ReportRow]]:
    """Return the rows by chapter, in their order."""
    by_chapter: dict[str, list[ReportRow]] = {}
    for row in rows:
        by_chapter.setdefault(row.chapter, []).append(row)
    return by_chapter


def tables(rows: Sequence[ReportRow]) -> list[str]:
    """Return a heading and a table for each chapter."""
    lines: list[str] = []
    for title, part in chapters(rows).items():
        lines += [f"### {title}", "", table(HEADINGS, map(cells, part)), ""]
    return lines


def markdown(rows: Sequence[ReportRow], specs: Sequence[RunSpec], figures: Sequence[str]) -> str:
    """Return the report as Markdown; the figures are files in the same folder."""
    lines = [
        "# Validation of dcrb_ros against Fan et al. 2025",
        "",
        f"Made by `dcrb validate` of dcrb_ros {__version__}. The paper: *Lubricants* 13(2), 80. {summary(rows)}",
        "",
        "`revolute` is the paper's model, the shipped configuration `paper`. In `pocket` the rollers are free "
        "between the cage bars: the shipped configuration `dry`, here at the paper's speed of 124.8 rad/s.",
        "",
        "## Numbers",
        "",
        *tables(rows),
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
