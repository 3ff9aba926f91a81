"""Memory and processor time of a process, from Linux's /proc."""

from __future__ import annotations

import os
from collections import defaultdict
from pathlib import Path

TICK = os.sysconf("SC_CLK_TCK")
"""Ticks of processor time per second [Hz]."""


def resident(pid: int) -> float:
    """Return the resident memory of a process [MB]; 0 after it has ended."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    except (OSError, IndexError):
        return 0.0


def processor_times(pid: int) -> dict[str, float]:
    """Return the processor time of a process's threads by name [s]; that of ended threads has the key ``ended``."""
    seconds_of: defaultdict[str, float] = defaultdict(float)
    for task in Path(f"/proc/{pid}/task").iterdir():
        name, seconds = _processor_time(task / "stat")
        seconds_of[name] += seconds
    seconds_of["ended"] = max(0.0, _processor_time(Path(f"/proc/{pid}/stat"))[1] - sum(seconds_of.values()))
    return seconds_of


def _processor_time(stat: Path) -> tuple[str, float]:
    """Return the name and the processor time [s] in a file ``stat``."""
    name, _, rest = stat.read_text().partition("(")[2].rpartition(")")
    user, system = rest.split()[11:13]
    return name, (int(user) + int(system)) / TICK
