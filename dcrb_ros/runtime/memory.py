"""Memory that the C library holds for the process, and how often Python searches for unused objects."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import sys

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
"""Parameters of `mallopt` (malloc.h of glibc)."""
KEPT, LARGE = 64 << 20, 16 << 20
"""Most freed memory that is kept, and size from which an array is returned to the system at once [byte]."""

RARELY = 50_000, 20, 100
"""Thresholds of the garbage collector: objects of a generation after which it is searched [-]."""


def collect_rarely() -> None:
    """Let Python search for unused objects less often: imports and compiled kernels make many objects, nearly all of which stay."""
    gc.set_threshold(*RARELY)


def keep_freed_memory() -> None:
    """Let the C library keep freed memory instead of returning it to the system; without effect where it is not glibc.

    Arrays of a megabyte come and go in every hop of a detector. Returned and asked for again, each of their pages costs a page fault, which
    together take a fifth of its time.
    """
    if sys.platform != "linux":
        return
    with contextlib.suppress(OSError, AttributeError):  # musl has no mallopt
        library = ctypes.CDLL(None)
        library.mallopt(M_MMAP_THRESHOLD, LARGE)
        library.mallopt(M_TRIM_THRESHOLD, KEPT)
