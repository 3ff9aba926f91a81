"""Work ahead: a source makes its next item while the last one is used."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from dcrb_ros.threads import show_name

Item = TypeVar("Item")


def ahead(items: Iterator[Item], wanted: Callable[[], bool] = lambda: True) -> Generator[Item, None, None]:
    """Yield ``items``; a thread makes the next one meanwhile, which pays where that lets go of the interpreter's lock.

    The first is made in the caller's own thread, where a compilation can be interrupted; so is one that was not ``wanted`` ahead
    when the last one came.
    """
    end = object()
    item = next(items, end)
    with ThreadPoolExecutor(1, "ahead", show_name) as thread:
        while item is not end:
            coming = thread.submit(next, items, end) if wanted() else None
            yield item  # type: ignore[misc]
            item = coming.result() if coming else next(items, end)
