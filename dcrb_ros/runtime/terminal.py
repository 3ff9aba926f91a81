"""Output on a terminal. Text is printed literally: units in brackets, and names of any form, are not read as markup."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.progress import Progress, ProgressColumn, TaskID
    from rich.table import Table

UNLIMITED = 200
"""Width of a line where nothing limits it, such as in a file [characters]."""


def console(*, stderr: bool = False) -> Console:
    """Return the standard output or the standard error output for tables and sentences."""
    from dcrb_ros.runtime.literal_console import LiteralConsole

    made = LiteralConsole(stderr=stderr)
    if not made.is_terminal and "COLUMNS" not in os.environ:
        made.width = UNLIMITED
    return made


def table(title: str, heads: Sequence[str], rows: Iterable[Sequence[RenderableType]], caption: str = "") -> Table:
    """Return a table with a title above it and a caption below it, which may be empty."""
    from rich.table import Table

    made = Table(*heads, title=title or None, caption=caption or None)
    for row in rows:
        made.add_row(*row)
    return made


def progress(*columns: ProgressColumn, quiet: bool = False, transient: bool = False) -> Progress:
    """Return a progress bar on the standard error output, with a description before it and ``columns`` after it.

    One that is ``transient`` disappears at its end.
    """
    from rich.progress import BarColumn, Progress, TextColumn

    description = TextColumn("{task.description}", markup=False)
    return Progress(description, BarColumn(), *columns, console=console(stderr=True), disable=quiet, transient=transient)


@contextmanager
def stages() -> Iterator[Callable[[str, int, int], None]]:
    """Show a progress bar of one stage after the other on a terminal, and nothing elsewhere.

    Yield the function to call with the name of a stage, what is done of it, and its total, which is 0 if it is unknown.
    """
    from rich.progress import TaskProgressColumn, TimeElapsedColumn, TimeRemainingColumn

    output = console(stderr=True)
    with progress(TaskProgressColumn(), TimeElapsedColumn(), TimeRemainingColumn(), quiet=not output.is_terminal, transient=True) as bar:
        tasks: dict[str, TaskID] = {}

        def show(stage: str, done: int = 0, total: int = 0) -> None:
            if stage not in tasks:
                for shown in tasks.values():
                    bar.update(shown, visible=False)
                tasks[stage] = bar.add_task(stage, total=total or None)
            bar.update(tasks[stage], completed=done, total=total or None)

        yield show


@contextmanager
def steps(total: int, *, quiet: bool = False) -> Iterator[Callable[[str], None]]:
    """Show a progress bar of ``total`` steps; yield the function to call with the description of each step as it begins."""
    from rich.progress import MofNCompleteColumn, TimeElapsedColumn

    with progress(MofNCompleteColumn(), TimeElapsedColumn(), quiet=quiet) as bar:
        task, begun = bar.add_task("starting", total=total), count()

        def begin(description: str) -> None:
            bar.update(task, completed=next(begun), description=description, refresh=True)

        yield begin
        bar.update(task, completed=total, description="done")
