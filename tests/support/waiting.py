"""Waiting for a condition."""

from __future__ import annotations

import time
from collections.abc import Callable

PATIENCE = 20.0


def wait_for(reached: Callable[[], bool], patience: float = PATIENCE) -> None:
    end = time.monotonic() + patience
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.001)
