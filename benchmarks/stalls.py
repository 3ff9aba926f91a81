"""Detection of stalls of the machine: an idle process on every core sleeps repeatedly and measures the actual time.

Other processes delay such a process by a few milliseconds at most, since the scheduler favours processes that sleep. A longer delay is
a stall of the machine: the host of a virtual machine may suspend its processors without counting this as stolen time.
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
EXCESS = 0.010
"""Excess over `NAP` from which a sleep counts as a stall [s]."""
Stall = tuple[float, float]
"""Start and end on the monotonic clock, which all processes share [s]."""


class StallMonitor:
    """The stalls recorded so far by the processes of `monitor_stalls`."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def stalls(self) -> list[Stall]:
        """Return the stalls of any core in chronological order; overlapping ones are merged."""
        lines = [line for path in self._folder.glob("core*") for line in path.read_text(encoding="utf-8").splitlines()]
        stalls: list[Stall] = []
        for begin, end in sorted((float(begin), float(end)) for begin, end in (line.split() for line in lines)):
            if stalls and begin <= stalls[-1][1]:
                stalls[-1] = stalls[-1][0], max(end, stalls[-1][1])
            else:
                stalls.append((begin, end))
        return stalls


@contextmanager
def monitor_stalls(folder: Path) -> Iterator[StallMonitor]:
    """Start a process on every core that records stalls in ``folder``."""
    with ExitStack() as stack:
        for core in sorted(os.sched_getaffinity(0)):
            command = [sys.executable, __file__, str(core), str(folder / f"core{core}")]
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True)
            stack.callback(process.wait)
            stack.callback(process.kill)
        yield StallMonitor(folder)


def watch(core: int, path: Path) -> None:
    """Record the stalls of a core until this process is killed or its parent ends."""
    os.sched_setaffinity(0, {core})
    parent = os.getppid()
    with path.open("w", encoding="utf-8", buffering=1) as file:
        before = time.monotonic()
        while os.getppid() == parent:
            time.sleep(NAP)
            now = time.monotonic()
            if now - before > NAP + EXCESS:
                file.write(f"{before!r} {now!r}\n")
            before = now


if __name__ == "__main__":
    watch(int(sys.argv[1]), Path(sys.argv[2]))
