"""The note that kernels are compiled: at the first start, and for laws that have not been simulated on this machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import typer

from dcrb_ros.runtime.terminal import console


def announce_compilation(*, quiet: bool = False) -> None:
    """Print a note whenever kernels are compiled, in this process or in its workers."""
    from dcrb_ros.core.announcement import announce_compilation as announce
    from dcrb_ros.core.announcement import no_announcement

    def say(sentence: str) -> None:
        typer.echo(sentence, err=True)

    if quiet:
        no_announcement()
    else:
        announce(say)


@contextmanager
def compilation_shown(*, quiet: bool = False) -> Iterator[None]:
    """Show a spinner while kernels are compiled, or a note where there is no terminal; nothing if they are compiled already."""
    from dcrb_ros.core.announcement import announce_compilation as announce

    announce_compilation(quiet=quiet)
    shown = console(stderr=True)
    if quiet or not shown.is_terminal:
        yield
        return
    status = shown.status("")

    def say(sentence: str) -> None:
        status.update(sentence)
        status.start()

    announce(say)
    try:
        yield
    finally:
        status.stop()
        announce_compilation()
