"""Time to the first block with and without cached kernels; every figure is measured in a process of its own."""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

FIRST_BLOCK = "from dcrb_ros.settings.files import load_configuration as load; from dcrb_ros.simulation.loop import Simulation; "
FIRST_BLOCK += "next(Simulation(load('healthy', ['cage.joint={}'])).blocks())"


STARTED = 7
"""Starts of which the median is printed."""
RECORDED = 4.0
"""Signal that `dcrb detect` receives [s]."""


class Cost(NamedTuple):
    """Cost of a process."""

    wall: float
    """[s]."""
    processor: float
    """[s]."""
    memory: float
    """Largest resident memory [MB]."""
    output: str
    """Its printed output."""


def cost(command: list[str], **changes: str) -> Cost:
    """Run a command and return its cost."""
    begin, environment = time.perf_counter(), {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": "77", **changes}
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(command, env=environment, stdout=output, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
        output.seek(0)
        text = output.read().decode(errors="replace")
    if status != 0:
        raise RuntimeError(f"{' '.join(command)} ended with status {status}: {text}")
    return Cost(time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6, text)


def warm_starts() -> None:
    """Print the processor time of the first block and of `dcrb detect`, medians of alternating processes with warm caches."""
    with tempfile.TemporaryDirectory() as folder:
        bag = str(Path(folder) / "bag")
        cost([sys.executable, "-m", "dcrb_ros.cli.program", "simulate", "outer_ring_defect", "--duration", str(RECORDED), "--output", bag])
        commands = {
            "first block": [sys.executable, "-c", FIRST_BLOCK.format("pocket")],
            f"`dcrb detect`, {RECORDED:g} s": [sys.executable, "-m", "dcrb_ros.cli.program", "detect", bag],
        }
        for command in commands.values():
            cost(command)
        measured = [{name: cost(command) for name, command in commands.items()} for _ in range(STARTED)]
    for name in commands:
        costs = [run[name] for run in measured]
        wall, processor = statistics.median(c.wall for c in costs), statistics.median(c.processor for c in costs)
        memory = statistics.median(c.memory for c in costs)
        print(f"| {name}, median of {STARTED} | {wall:.1f} | {processor:.2f} | {memory:.0f} |", flush=True)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--warm", action="store_true", help="measure only starts with warm caches")
    given = parser.parse_args()
    print("| process | wall [s] | processor [s] | memory [MB] |\n|---|---|---|---|")
    warm_starts()
    if given.warm:
        return
    for joint in ("pocket", "revolute"):
        command = [sys.executable, "-c", FIRST_BLOCK.format(joint)]
        with tempfile.TemporaryDirectory() as folder:
            for name in ("cold", "warm"):
                found = cost(command, NUMBA_CACHE_DIR=folder)
                print(f"| first block, {name}, {joint} | {found.wall:.1f} | {found.processor:.1f} | {found.memory:.0f} |", flush=True)


if __name__ == "__main__":
    main()
