"""`dcrb validate`: the paper's numbers and figures, reproduced."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.runtime.refusal import Refusal


def validate(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the report and its figures.")] = Path("validation"),
    workers: Annotated[int, typer.Option(help="Runs at a time; 0 for one per core.")] = 0,
) -> None:
    """Reproduce Fan et al. 2025: a table of numbers with tolerances, and figures 8 to 11 as a report."""
    if not 0 <= workers <= 256:
        raise Refusal(f"--workers {workers} is outside 0 .. 256: 0 takes one per core")
    from rich.console import Console
    from rich.progress import Progress
    from rich.table import Table

    from dcrb_ros.core import compiled
    from dcrb_ros.runtime.processes import cores
    from dcrb_ros.validation.report import HEADINGS, cells, summary
    from dcrb_ros.validation.validate import made_folder, run_all, table, write_report

    folder, console = made_folder(output), Console(stderr=True)
    if not compiled():
        console.print("compiling the kernels (once, about half a minute) ...")
    try:
        with Progress(console=console) as progress:
            task = progress.add_task("runs", total=None)
            runs, agreements = run_all(
                workers or cores(),
                lambda done, total, name: progress.update(task, completed=done, total=total, description=name),
            )
    except BaseException:
        with contextlib.suppress(OSError):
            folder.rmdir()  # unless an earlier report lies in it
        raise
    rows = table(runs, agreements)
    shown = Table(*HEADINGS, show_lines=True)
    for row in rows:
        shown.add_row(*cells(row), style="" if row.holds else "bold red")
    Console(width=None if console.is_terminal else 200).print(shown)
    report = write_report(folder, rows, runs)
    print(f"{summary(rows)} Report: {report}")
    if not all(row.holds for row in rows):
        raise typer.Exit(1)
