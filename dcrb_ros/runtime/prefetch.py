"""Prefetching: a thread produces the next items while the caller uses the last one."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from dcrb_ros.runtime.threads import show_name

Item = TypeVar("Item")
WRITING_DEPTH = 4
"""Blocks that are simulated while one is written to a recording."""


def prefetch(items: Iterator[Item], wanted: Callable[[], bool] = lambda: True, depth: int = 1) -> Generator[Item, None, None]:
    """Yield ``items`` while a thread produces up to ``depth`` more; this is faster if producing them releases the GIL.

    With a depth of one the thread sleeps until the item is taken, and waking it takes time.

    The first item is produced in the caller's thread, where a compilation can be interrupted. So is an item for which ``wanted`` was
    false when its predecessor was yielded.
    """
    end = object()
    item = next(items, end)
    pending: deque[Future[object]] = deque()
    with ThreadPoolExecutor(1, "prefetch", show_name) as thread:
        while item is not end:
            while len(pending) < depth and wanted():
                pending.append(thread.submit(next, items, end))
            yield item  # type: ignore[misc]
            item = pending.popleft().result() if pending else next(items, end)
