"""Child processes: they start with signals blocked, and end with the process that started them, however that one ends."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager

from dcrb_ros.runtime.signals import TERMINATION
from dcrb_ros.runtime.threads import NamedThread

STANDARD_INPUT = 0


@contextmanager
def signals_blocked() -> Iterator[None]:
    """Start child processes with termination signals blocked until they accept them, so that none is interrupted during its start."""
    if not hasattr(signal, "pthread_sigmask"):  # not on Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, TERMINATION)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_parent() -> None:
    """Deliver SIGTERM to this process once the other end of its standard input is closed, as the end of the parent process does.

    The parent starts it with ``stdin=PIPE`` and writes nothing. A thread waits, so a parent that has already ended is noticed as well.
    """
    NamedThread("parent", _end_after_input).start()


def _end_after_input() -> None:
    while os.read(STANDARD_INPUT, 4096):
        pass
    os.kill(os.getpid(), signal.SIGTERM)
