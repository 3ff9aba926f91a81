"""The note that the first start compiles the kernels."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import typer

from dcrb_ros.runtime.terminal import console


def announce_compilation(*, quiet: bool = False) -> None:
    """Print a note when kernels are compiled, in this process now or in its workers soon."""
    from dcrb_ros.core import compiled
    from dcrb_ros.core.announcement import SENTENCE
    from dcrb_ros.core.announcement import announce_compilation as announce

    def say(sentence: str) -> None:
        typer.echo(sentence, err=True)

    if quiet:
        return
    if compiled():
        announce(say)
    else:
        say(SENTENCE)


@contextmanager
def compilation_shown(*, quiet: bool = False) -> Iterator[None]:
    """Show a spinner while the kernels are compiled, or a note where there is no terminal; nothing if they are compiled already."""
    from dcrb_ros.core import compiled
    from dcrb_ros.core.announcement import SENTENCE

    shown = console(stderr=True)
    if quiet or compiled() or not shown.is_terminal:
        announce_compilation(quiet=quiet)
        yield
        return
    with shown.status(SENTENCE):
        yield
