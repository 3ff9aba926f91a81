"""Long arrays in pieces: intermediate results of a few columns take little memory, and the progress can be shown."""

from __future__ import annotations

from collections.abc import Callable, Iterator

PIECE = 1 << 20
"""Samples in a piece [-]."""

Show = Callable[[str, int, int], None]
"""Takes the name of a stage, what is done of it, and its total, which is 0 if it is unknown."""


def unseen(_stage: str, _done: int = 0, _total: int = 0) -> None:
    """Show no progress."""


def pieces(length: int, show: Show = unseen, stage: str = "") -> Iterator[slice]:
    """Yield the pieces of an array of ``length`` samples, one after the other; ``show`` those done of a ``stage``."""
    for begin in range(0, length, PIECE):
        show(stage, begin, length)
        yield slice(begin, min(begin + PIECE, length))
