"""Memory and processor time of a process, on Linux, and a ROS domain for this process."""

from __future__ import annotations

import os
import signal
from collections import defaultdict
from pathlib import Path

import psutil


def resident(pid: int) -> float:
    """Return the resident memory of a process [MB]; 0 after it has ended."""
    try:
        return float(psutil.Process(pid).memory_info().rss / 1e6)
    except psutil.NoSuchProcess:
        return 0.0


def processor_times(pid: int) -> dict[str, float]:
    """Return the processor time of a process's threads by name [s]; that of ended threads has the key ``ended``."""
    process, seconds_of = psutil.Process(pid), defaultdict[str, float](float)
    for thread in process.threads():
        name = Path(f"/proc/{pid}/task/{thread.id}/comm").read_text().rstrip("\n")
        seconds_of[name] += thread.user_time + thread.system_time
    seconds_of["ended"] = max(0.0, sum(process.cpu_times()[:2]) - sum(seconds_of.values()))
    return seconds_of


def take_own_domain() -> None:
    """Take part in ROS in a domain of this process, unless the environment has one; SIGTERM ends the nodes that are started here, too."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
