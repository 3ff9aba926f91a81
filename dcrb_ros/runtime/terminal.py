"""Output on a terminal. Text is printed literally: units in brackets, and names of any form, are not read as markup."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, ProgressColumn

UNLIMITED = 200
"""Width of a line where nothing limits it, such as in a file [characters]."""


def console(*, stderr: bool = False) -> Console:
    """Return the standard output or the standard error output for tables and sentences."""
    from dcrb_ros.runtime.literal_console import LiteralConsole

    made = LiteralConsole(stderr=stderr)
    if not made.is_terminal and "COLUMNS" not in os.environ:
        made.width = UNLIMITED
    return made


def progress(*columns: ProgressColumn, quiet: bool = False) -> Progress:
    """Return a progress bar on the standard error output, with a description before it and ``columns`` after it."""
    from rich.progress import BarColumn, Progress, TextColumn

    description = TextColumn("{task.description}", markup=False)
    return Progress(description, BarColumn(), *columns, console=console(stderr=True), disable=quiet)
