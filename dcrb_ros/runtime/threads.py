"""Threads whose names the operating system shows, in ``top -H`` for instance; Python 3.14 and later do this themselves."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

OWN_NAME = Path("/proc/thread-self/comm")
"""File in which Linux keeps the name of the reading thread, 15 bytes of it."""


def show_name() -> None:
    """Pass the name of the calling thread to the operating system, if it has such a file."""
    with contextlib.suppress(OSError):
        OWN_NAME.write_text(threading.current_thread().name)


class NamedThread(threading.Thread):
    """A daemon thread whose name the operating system shows."""

    def __init__(self, name: str, target: Callable[[], None]) -> None:
        super().__init__(name=name, target=target, daemon=True)

    def run(self) -> None:
        """Pass on the name, then run the target."""
        show_name()
        super().run()


@contextlib.contextmanager
def repeating(period: float, call: Callable[[], None]) -> Iterator[None]:
    """Call a function now and every ``period`` of wall time [s] in another thread, which ends with the context."""
    over = threading.Event()

    def run() -> None:
        while not over.is_set():
            call()
            over.wait(period)

    thread = NamedThread("repeating", run)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
