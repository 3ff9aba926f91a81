"""Child processes: they start with signals blocked and end with their parent, however it ends."""

from __future__ import annotations

import os
import pickle
import secrets
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from dcrb_ros.runtime.signals import TERMINATION
from dcrb_ros.runtime.threads import NamedThread

STANDARD_INPUT = 0
MARK = "DCRB_ROS_DETECTOR"
"""Variable of the environment by which child processes are found that have left the group of the first."""
GUARD = 'read -r group || exit; read -r _; kill -s INT -- "-$group"; sleep "$0"; kill -s KILL -- "-$group"'
"""Shell script that ends the process group on its standard input once this is closed: like Ctrl-C, and after $0 seconds without mercy."""


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


def received_from_parent() -> Any:
    """Return the object that the parent process has pickled to standard input; exit if it ended before.

    The parent is this user's own process. Only what starts this process may write to its standard input.
    """
    try:
        return pickle.load(sys.stdin.buffer)
    except EOFError:
        sys.exit(1)


def end_with_parent() -> None:
    """Deliver SIGTERM to this process once the other end of its standard input is closed, as the end of the parent process does.

    The parent starts it with ``stdin=PIPE`` and writes nothing more. A thread waits, so a parent that has already ended is noticed as well.
    """
    NamedThread("parent", _end_after_input).start()


def _end_after_input() -> None:
    while os.read(STANDARD_INPUT, 4096):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


@contextmanager
def group_guard(patience: float) -> Iterator[Callable[[int], None]]:
    """Yield a function to call with the number of a process group, which ends if this process ends before the context does.

    Any program can be in the group; it needs no `end_with_parent`. A shell outside of the group, started before it, waits for the end of
    this process, even by SIGKILL. It gives the group a ``patience`` [s] after SIGINT.
    """
    with signals_blocked():
        guard = subprocess.Popen(
            ["/bin/sh", "-c", GUARD, str(patience)], stdin=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True
        )
    assert guard.stdin is not None
    words = guard.stdin.fileno()

    def guarded(group: int) -> None:
        os.write(words, b"%d\n" % group)

    try:
        yield guarded
    finally:
        guard.kill()  # before its standard input is closed
        guard.communicate()


def kill_group(group: int) -> None:
    """Kill a process group by its number, if it has not ended."""
    with suppress(ProcessLookupError):
        os.killpg(group, signal.SIGKILL)


def marked_environment() -> dict[str, str]:
    """Return the environment of this process with a new mark, for a child to be ended by `kill_marked`."""
    return {**os.environ, MARK: secrets.token_hex(16)}


def kill_marked(environment: Mapping[str, str]) -> None:
    """Kill the processes with the mark of an environment, such as those in a session of their own, where there is /proc."""
    entry = f"{MARK}={environment[MARK]}".encode()
    for file in Path("/proc").glob("[0-9]*/environ"):
        with suppress(OSError):  # it has ended, or is another user's
            if entry in file.read_bytes().split(b"\0"):
                os.kill(int(file.parent.name), signal.SIGKILL)
