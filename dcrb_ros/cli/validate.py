"""`dcrb validate`: compare the model with the numbers and figures of Fan et al. 2025."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dcrb_ros.cli.first_start import announce_compilation
from dcrb_ros.cli.options import JsonOutput, Quiet, Workers, worker_count
from dcrb_ros.text.json import json_text

if TYPE_CHECKING:
    from dcrb_ros.validation.report_row import ReportRow


def validate(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the report; an earlier report in it is replaced.")] = Path(
        "validation"
    ),
    workers: Workers = 0,
    quiet: Quiet = False,
    as_json: JsonOutput = False,
) -> None:
    """Check the physics: the numbers and Figs. 8 to 11 of Fan et al. 2025, time integration, balls, oil film, friction, surfaces, realism.

    Exit status 0 if every number is within its tolerance, 1 if not.

    Example: dcrb validate -o validation
    """
    processes = worker_count(workers)
    from dcrb_ros.runtime.terminal import progress
    from dcrb_ros.validation.report import summary
    from dcrb_ros.validation.validate import all_rows, report_folder, run_all, write_report

    folder = report_folder(output)
    announce_compilation(quiet=quiet)
    try:
        with progress(quiet=quiet) as bar:
            task = bar.add_task("runs", total=None)
            results = run_all(
                processes,
                lambda done, total, name: bar.update(task, completed=done, total=total, description=name),
            )
    except BaseException:
        with contextlib.suppress(OSError):
            folder.rmdir()  # fails if it contains an earlier report, which is kept
        raise
    comparisons = all_rows(results)
    # The results are printed first, so that they are not lost if the report cannot be written.
    _print(comparisons, as_json=as_json)
    report = write_report(folder, comparisons, results.runs)
    if not as_json:
        print(f"{summary(comparisons)} Report: {report}")
    if not all(comparison.holds for comparison in comparisons):
        raise typer.Exit(1)


def _print(comparisons: Sequence[ReportRow], *, as_json: bool) -> None:
    from rich.table import Table

    from dcrb_ros.runtime.terminal import console
    from dcrb_ros.validation.report import HEADINGS, cells, chapters

    if as_json:
        rows = [{**asdict(comparison), "verdict": comparison.verdict} for comparison in comparisons]
        print(json_text({"holds": all(comparison.holds for comparison in comparisons), "comparisons": rows}))
        return
    for title, part in chapters(comparisons).items():
        table = Table(*HEADINGS, title=title, show_lines=True)
        for comparison in part:
            table.add_row(*cells(comparison), style="" if comparison.holds else "bold red")
        console().print(table)
