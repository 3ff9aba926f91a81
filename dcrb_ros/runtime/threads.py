"""Threads that show their name to the operating system too, in ``top -H`` say; Python does so by itself from 3.14 on."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from pathlib import Path

OWN_NAME = Path("/proc/thread-self/comm")
"""Where Linux keeps the name of the thread that looks: its first 15 bytes."""


def show_name() -> None:
    """Show the name of the thread that calls, where that is possible."""
    with contextlib.suppress(OSError):
        OWN_NAME.write_text(threading.current_thread().name)


class NamedThread(threading.Thread):
    """A thread that ends with the program and shows its name."""

    def __init__(self, name: str, target: Callable[[], None]) -> None:
        super().__init__(name=name, target=target, daemon=True)

    def run(self) -> None:
        """Show the name, then do the work."""
        show_name()
        super().run()
