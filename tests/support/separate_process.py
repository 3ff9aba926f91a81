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
