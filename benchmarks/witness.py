"""Moments at which the machine stood still: on every core an idle process sleeps for a moment and looks how long that was.

What else runs on a core delays such a process by a few milliseconds at most, since the scheduler favours who sleeps. A longer sleep is
the machine's own: a virtual one stops when its host takes the processors away, which no count of stolen time need show.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

NAP = 0.002
"""Time to sleep [s]."""
STOP = 0.010
"""A sleep that takes longer by so much is a stop of the machine [s]."""
Stop = tuple[float, float]
"""Begin and end on the monotonic clock, which all processes share [s]."""


class Witnesses:
    """The stops that the witnesses have seen so far."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def stops(self) -> list[Stop]:
        """Return when any core stood still, in the order of time; stops of several at once are one."""
        lines = [line for path in self._folder.glob("core*") for line in path.read_text(encoding="utf-8").splitlines()]
        found: list[Stop] = []
        for begin, end in sorted((float(begin), float(end)) for begin, end in (line.split() for line in lines)):
            if found and begin <= found[-1][1]:
                found[-1] = found[-1][0], max(end, found[-1][1])
            else:
                found.append((begin, end))
        return found


@contextmanager
def witnesses(folder: Path) -> Iterator[Witnesses]:
    """Let a process on every core look for stops; they write what they see into ``folder``."""
    with ExitStack() as stack:
        for core in sorted(os.sched_getaffinity(0)):
            command = [sys.executable, __file__, str(core), str(folder / f"core{core}")]
            witness = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True)
            stack.callback(witness.wait)
            stack.callback(witness.kill)
        yield Witnesses(folder)


def watch(core: int, path: Path) -> None:
    """Write every stop of a core, until killed or left alone."""
    os.sched_setaffinity(0, {core})
    parent = os.getppid()
    with path.open("w", encoding="utf-8", buffering=1) as file:
        before = time.monotonic()
        while os.getppid() == parent:
            time.sleep(NAP)
            now = time.monotonic()
            if now - before > NAP + STOP:
                file.write(f"{before!r} {now!r}\n")
            before = now


if __name__ == "__main__":
    watch(int(sys.argv[1]), Path(sys.argv[2]))
