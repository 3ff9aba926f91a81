"""Work ahead: a source makes its next item while the last one is used."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")


def ahead(items: Iterator[Item]) -> Iterator[Item]:
    """Yield ``items``; a thread makes the next one meanwhile, which pays where that lets go of the interpreter's lock.

    The first is made in the caller's own thread, where a compilation can be interrupted.
    """
    end = object()
    item = next(items, end)
    with ThreadPoolExecutor(1) as thread:
        while item is not end:
            coming = thread.submit(next, items, end)
            yield item  # type: ignore[misc]
            item = coming.result()
