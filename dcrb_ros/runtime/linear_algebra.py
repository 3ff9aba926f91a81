"""Threads of the linear algebra libraries."""

from __future__ import annotations

import os

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Environment in which the libraries use one thread: the matrices here have some hundred rows, for which threads mostly wait."""


def one_thread_each() -> None:
    """Limit the libraries to one thread each, unless the environment says otherwise; numpy must not have been imported yet."""
    for name, value in ONE_THREAD.items():
        os.environ.setdefault(name, value)
