"""`dcrb validate`: compare the model with the numbers and figures of Fan et al. 2025."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli.options import Workers, announce_compilation, worker_count


def validate(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the report; an earlier report in it is replaced.")] = Path(
        "validation"
    ),
    workers: Workers = 0,
) -> None:
    """Reproduce Fan et al. 2025: a table of numbers with tolerances, and Figs. 8 to 11, as a report.

    Exit status 0 if every number is within its tolerance, 1 if not.

    Example: dcrb validate -o validation
    """
    processes = worker_count(workers)
    from rich.console import Console
    from rich.progress import Progress
    from rich.table import Table

    from dcrb_ros.validation.report import HEADINGS, cells, summary
    from dcrb_ros.validation.validate import all_comparisons, report_folder, run_all, write_report

    folder, console = report_folder(output), Console(stderr=True)
    announce_compilation()
    try:
        with Progress(console=console) as progress:
            task = progress.add_task("runs", total=None)
            runs, agreements = run_all(
                processes,
                lambda done, total, name: progress.update(task, completed=done, total=total, description=name),
            )
    except BaseException:
        with contextlib.suppress(OSError):
            folder.rmdir()  # fails if it contains an earlier report, which is kept
        raise
    comparisons = all_comparisons(runs, agreements)
    table = Table(*HEADINGS, show_lines=True)
    for comparison in comparisons:
        table.add_row(*cells(comparison), style="" if comparison.holds else "bold red")
    Console(width=None if console.is_terminal else 200).print(table)
    report = write_report(folder, comparisons, runs)
    print(f"{summary(comparisons)} Report: {report}")
    if not all(comparison.holds for comparison in comparisons):
        raise typer.Exit(1)
