"""Waiting for a condition, such as the end of a process."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

PATIENCE = 200.0
"""Longest wait for anything [s]: on a busy machine a process may take a minute to start."""


def wait_for(reached: Callable[[], bool], patience: float = PATIENCE) -> None:
    end = time.monotonic() + patience
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.001)


def runs(process: int) -> bool:
    """Return whether a process exists and is not a zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
