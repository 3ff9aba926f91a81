"""The report of an evaluation: on the terminal, and in files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dcrb_ros.exam.report import Report


def output_report(report: Report, as_json: bool, junit: Path | None, figure: Path | None, entry: Path | None = None) -> None:
    """Print a report, then write its files; printing comes first so that no result is lost if a file cannot be written."""
    if as_json:
        print(json.dumps(report.described(), indent=2, allow_nan=False), flush=True)
    else:
        from dcrb_ros.exam.table import tables
        from dcrb_ros.runtime.terminal import console

        console().print(tables(report))
    if junit is not None:
        from dcrb_ros.exam.junit import write_junit

        write_junit(report, junit)
    if figure is not None:
        from dcrb_ros.exam.figure import write_figure

        write_figure(report, figure)
    if entry is not None:
        from dcrb_ros.exam.leaderboard_entry import entry_of, write_entry

        write_entry(entry_of(report), entry)
