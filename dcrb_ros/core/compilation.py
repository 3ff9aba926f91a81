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
from collections.abc import Iterator
from pathlib import Path

import numba

from dcrb_ros.core import CACHE
from dcrb_ros.core.announcement import announce_laws
from dcrb_ros.core.contacts.conformal import linearize_cages
from dcrb_ros.core.contacts.raceway import linearize_raceways
from dcrb_ros.core.laws.registry import law_of
from dcrb_ros.core.layout.state import State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance_unbound, find_bound, solve
from dcrb_ros.core.solver.update import store_bound

MODULE = "dcrb_ros.core.compilation"
COUNT = numba.types.int64
HERE = ((find_bound, ()), (linearize_cages, (COUNT,)), (solve, (COUNT, COUNT)), (store_bound, (COUNT,)))
"""Pieces of the time loop that this process compiles, and the types of what they take besides payload, state and work."""
ORPHANED = 75
"""Exit status of the other process when this one has ended before it."""
THERE = ((advance_unbound, ()), (linearize_raceways, (COUNT,)))
"""Those that the other one compiles meanwhile: half of the work."""


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


def compile_pieces(pieces: tuple[tuple[object, tuple[object, ...]], ...], arguments: tuple[object, ...]) -> None:
    """Compile pieces for the types of payload, state and work into the cache."""
    with rare_collections():
        for piece, more in pieces:
            piece.compile((*arguments, *more))  # type: ignore[attr-defined] # numba's dispatchers are untyped


def compile_ahead(payload: Payload, state: State, work: Workspace) -> None:
    """Compile the pieces of the time loop on two cores, unless it lies compiled in the cache already or there is but one core.

    What the other process could not do is compiled here when it is needed.
    """
    announce_laws(_laws(payload))
    arguments = tuple(numba.typeof(part) for part in (payload, state, work))  # type: ignore[no-untyped-call]
    if _marker(arguments).exists() or getattr(numba.config, "DISABLE_JIT") or (os.cpu_count() or 1) < 2:  # noqa: B009 - untyped
        return
    # The other process adds the name of the folder.
    command, environment = [sys.executable, "-m", MODULE], {**os.environ, "NUMBA_CACHE_DIR": str(CACHE.parent)}
    silent = subprocess.DEVNULL
    try:
        other = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=silent, stderr=silent, env=environment)
    except OSError:  # no room for another process
        return
    assert other.stdin is not None
    try:
        with contextlib.suppress(BrokenPipeError):  # it has ended already
            pickle.dump(arguments, other.stdin)
            other.stdin.flush()
        compile_pieces(HERE, arguments)
        other.wait()
        _marker(arguments).touch()
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
    compile_pieces(THERE, wanted)
    # The thread waits in a read, under which the interpreter cannot be taken down.
    os._exit(0)
