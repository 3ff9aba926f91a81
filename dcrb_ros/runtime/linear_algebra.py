"""Threads of the linear algebra libraries."""

from __future__ import annotations

import os

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Environment in which they use one thread: the matrices here have some hundred rows, for which threads mostly wait for each other."""


def one_thread_each() -> None:
    """Let them use one thread, unless the environment says otherwise; numpy must not have been imported yet."""
    for name, value in ONE_THREAD.items():
        os.environ.setdefault(name, value)
