"""Memory and processor time of a process, from Linux's /proc, and a ROS domain for this process."""

from __future__ import annotations

import os
import signal
from collections import defaultdict
from pathlib import Path

import psutil

TICK = os.sysconf("SC_CLK_TCK")
"""Ticks of processor time per second [Hz]."""


def resident(pid: int) -> float:
    """Return the resident memory of a process [MB]; 0 after it has ended."""
    try:
        return float(psutil.Process(pid).memory_info().rss / 1e6)
    except psutil.NoSuchProcess:
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


def take_own_domain() -> None:
    """Take part in ROS in a domain of this process, unless the environment has one; SIGTERM ends the nodes that are started here, too."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
