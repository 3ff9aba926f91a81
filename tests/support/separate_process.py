"""The command line in a process of its own."""

from __future__ import annotations

import atexit
import functools
import subprocess
import sys

from measured_commands import Commands


def dcrb(*arguments: str, timeout: float = 200.0) -> subprocess.CompletedProcess[str]:
    """Run a command in a fork of a process that has imported everything: it costs what it does, not the start of an interpreter."""
    done = _parent().run(*arguments, seconds=timeout)
    return subprocess.CompletedProcess(["dcrb", *arguments], done.status, done.stdout, done.stderr)


def fresh_dcrb(*arguments: str, timeout: float = 200.0) -> subprocess.CompletedProcess[str]:
    """Run a command in a new interpreter, as a user does: it imports what it needs."""
    command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)


@functools.cache
def _parent() -> Commands:
    parent = Commands()
    atexit.register(parent.close)
    return parent


STOPPED_WHILE_WRITING = """
import os, signal, sys
number, at = getattr(signal, sys.argv.pop(1)), int(sys.argv.pop(1))
sync = os.fsync
def fsync(descriptor):
    global at
    at -= 1
    if at == 0:
        os.kill(os.getpid(), number)
    sync(descriptor)
os.fsync = fsync
from dcrb_ros.cli.program import main
main()
"""


def stopped_dcrb(number: str, at: int, *arguments: str, timeout: float = 200.0) -> subprocess.CompletedProcess[str]:
    """Run a command in a new interpreter that gets a signal, such as SIGKILL, when it waits for the disk for the ``at``-th time."""
    command = [sys.executable, "-c", STOPPED_WHILE_WRITING, number, str(at), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)
