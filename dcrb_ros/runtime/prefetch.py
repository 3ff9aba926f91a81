"""Work ahead: a source makes its next items while the last one is used."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from dcrb_ros.runtime.threads import show_name

Item = TypeVar("Item")


def ahead(items: Iterator[Item], wanted: Callable[[], bool] = lambda: True, most: int = 1) -> Generator[Item, None, None]:
    """Yield ``items``; a thread makes up to ``most`` more meanwhile, which pays where that lets go of the interpreter's lock.

    With one only, the thread sleeps until the item is taken, and waking it takes a while.

    The first is made in the caller's own thread, where a compilation can be interrupted; so is one that was not ``wanted`` ahead
    when the last one came.
    """
    end = object()
    item = next(items, end)
    coming: deque[Future[object]] = deque()
    with ThreadPoolExecutor(1, "ahead", show_name) as thread:
        while item is not end:
            while len(coming) < most and wanted():
                coming.append(thread.submit(next, items, end))
            yield item  # type: ignore[misc]
            item = coming.popleft().result() if coming else next(items, end)
