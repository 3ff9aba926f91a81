"""The first compilation, on two cores: another process compiles the raceways' contacts, this one the rest, and both meet in the cache."""

from __future__ import annotations

import contextlib
import gc
import hashlib
import os
import pickle
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numba

from dcrb_ros.core import CACHE
from dcrb_ros.core.announcement import announce_laws, announce_progress
from dcrb_ros.core.contacts.conformal import linearize_cages
from dcrb_ros.core.contacts.raceway import linearize_raceways
from dcrb_ros.core.laws.registry import law_of
from dcrb_ros.core.layout.state import State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance, advance_unbound, find_bound, solve
from dcrb_ros.core.solver.update import store_bound

MODULE = "dcrb_ros.core.compilation"
COUNT = numba.types.int64
ORPHANED = 75
"""Exit status of the other process when this one has ended before it."""


class Part(NamedTuple):
    """A part of the time loop that is compiled by itself."""

    name: str
    kernel: Any
    more: tuple[Any, ...]
    """Types of what it takes besides payload, state and work."""
    share: float
    """Its time over that of all parts in `HERE` and `LAST` [-]."""


HERE = (
    Part("bound rollers", find_bound, (), 0.43),
    Part("cages", linearize_cages, (COUNT,), 0.2),
    Part("velocities", solve, (COUNT, COUNT), 0.18),
)
"""Parts that this process compiles."""
THERE = (
    Part("free rollers", advance_unbound, (), 0.3),
    Part("raceways", linearize_raceways, (COUNT,), 0.25),
    Part("results of a step", store_bound, (COUNT,), 0.1),
)
"""Those that the other one compiles meanwhile."""
LAST = (Part("time loop", advance, (numba.types.float64[:, ::1], numba.types.float64[::1]), 0.19),)
"""What joins them, compiled by this process."""
PROGRESS = "compiling the kernels: {name}, part {at} of {of}, done in {left:.0f} s ..."


class Progress:
    """Says before each part but the first which one is compiled, and when all of them will be done."""

    def __init__(self, parts: int, *, alone: bool) -> None:
        """Expect so many parts; ``alone`` those of the other process, too."""
        self._parts, self._begun, self._done = parts, 0, 0.0
        self._work = sum(part.share for part in (*HERE, *(THERE if alone else ()), *LAST))
        self._began = time.monotonic()

    def begin(self, part: Part) -> None:
        """Begin a part."""
        self._begun += 1
        if self._done > 0.0:
            left = (time.monotonic() - self._began) * (self._work / self._done - 1.0)
            announce_progress(PROGRESS.format(name=part.name, at=self._begun, of=self._parts, left=left))
        self._done += part.share


RARE_COLLECTIONS = (50_000, 20, 100)
"""Thresholds of the collector during compilation: at Python's own it takes a seventh of the time, for objects that nearly all stay."""


@contextlib.contextmanager
def rare_collections() -> Iterator[None]:
    """Let Python search for unused objects less often."""
    usual = gc.get_threshold()
    gc.set_threshold(*RARE_COLLECTIONS)
    try:
        yield
    finally:
        gc.set_threshold(*usual)


def set_aside() -> None:
    """Exempt the compiler's objects from garbage collection: one search of them lasts for many blocks, and paced blocks would be late."""
    gc.collect()
    gc.freeze()


def compile_parts(parts: tuple[Part, ...], arguments: tuple[object, ...], progress: Progress | None = None) -> None:
    """Compile parts for the types of payload, state and work into the cache."""
    with rare_collections():
        for part in parts:
            if progress is not None:
                progress.begin(part)
            part.kernel.compile((*arguments, *part.more))


def compile_ahead(payload: Payload, state: State, work: Workspace) -> None:
    """Compile the time loop part by part, on two cores where there are two, unless it lies compiled in the cache already.

    What the other process could not do is compiled here when it is needed.
    """
    announce_laws(_laws(payload))
    arguments = tuple(numba.typeof(part) for part in (payload, state, work))  # type: ignore[no-untyped-call]
    if _marker(arguments).exists() or getattr(numba.config, "DISABLE_JIT"):  # noqa: B009 - untyped
        return
    with _other_process(arguments) as other:
        here = HERE if other is not None else (*HERE, *THERE)
        progress = Progress(len(here) + len(LAST), alone=other is None)
        compile_parts(here, arguments, progress)
        if other is not None:
            other.wait()
        compile_parts(LAST, arguments, progress)
        _marker(arguments).touch()
    set_aside()


@contextlib.contextmanager
def _other_process(arguments: tuple[object, ...]) -> Iterator[subprocess.Popen[bytes] | None]:
    """Let another process compile `THERE`; None without a second core, or without room for a process."""
    # The other process adds the name of the folder.
    command, environment = [sys.executable, "-m", MODULE], {**os.environ, "NUMBA_CACHE_DIR": str(CACHE.parent)}
    silent = subprocess.DEVNULL
    other = None
    if (os.cpu_count() or 1) > 1:
        with contextlib.suppress(OSError):
            other = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=silent, stderr=silent, env=environment)
    if other is None:
        yield None
        return
    assert other.stdin is not None
    try:
        with contextlib.suppress(BrokenPipeError):  # it has ended already
            pickle.dump(arguments, other.stdin)
            other.stdin.flush()
        yield other
    finally:
        with contextlib.suppress(BrokenPipeError):
            other.stdin.close()
        other.kill()
        other.wait()


def _laws(payload: Payload) -> str:
    """Return the names of the laws for which the kernels are compiled."""
    constants = (payload.normal_law, payload.traction_law, payload.cage_traction_law, payload.lubrication)
    return ", ".join(dict.fromkeys(law.name for law in map(law_of, constants) if law is not None))


def _marker(arguments: tuple[object, ...]) -> Path:
    """Return the file that says that the pieces lie compiled in the cache for these types."""
    return CACHE / f"pieces-{hashlib.sha256(repr(arguments).encode()).hexdigest()[:16]}"


def _end_with_parent() -> None:
    """End this process once the one that started it is no more."""
    sys.stdin.buffer.read()
    os._exit(ORPHANED)


if __name__ == "__main__":
    wanted = pickle.load(sys.stdin.buffer)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    compile_parts(THERE, wanted)
    # The thread waits in a read, under which the interpreter cannot be taken down.
    os._exit(0)
