"""Processor time, memory and parts of starts with and without compiled kernels; every figure is measured in a process of its own."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

SPENT = """
import time
import resource
marks = []
def mark(part): marks.append((part, time.process_time()))
def spent():
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)
"""
FIRST_BLOCK = f"""{SPENT}
from dcrb_ros.settings.files import load_configuration as load
from dcrb_ros.simulation.loop import Simulation
next(Simulation(load('healthy', ['cage.joint={{}}'])).blocks())
print(spent())
"""
PARTS = f"""{SPENT}
mark("Python")
import numpy; mark("import of numpy")
import dcrb_ros.core; mark("import of numba")
import pydantic; from pydantic import BaseModel; mark("import of pydantic")
from dcrb_ros.settings.files import load_configuration as load
from dcrb_ros.simulation.loop import Simulation; mark("other imports")
configuration = load("healthy"); mark("configuration, checked")
simulation = Simulation(configuration); mark("equilibrium, surfaces and sensor")
next(simulation.blocks()); mark("loading the time loop, first block")
print(*(f"{{part}};{{time}}" for part, time in marks), sep="\\n")
"""
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
    """Run a command and return its cost; Python keeps compiled sources, as it does for users."""
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": "77", **changes}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    begin = time.perf_counter()
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(command, env=environment, stdout=output, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
        output.seek(0)
        text = output.read().decode(errors="replace")
    if status != 0:
        raise RuntimeError(f"{' '.join(command)} ended with status {status}: {text}")
    return Cost(time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6, text)


def first_block(joint: str, **changes: str) -> Cost:
    """Return the cost of a Python program up to its first block."""
    found = cost([sys.executable, "-c", FIRST_BLOCK.format(joint)], **changes)
    return found._replace(processor=float(found.output))


def program(*arguments: str) -> Cost:
    """Return the cost of a `dcrb` command."""
    return cost([sys.executable, "-m", "dcrb_ros.cli.program", *arguments])


def print_starts(folder: Path) -> None:
    """Print the cost of starts with compiled kernels, medians of alternating processes."""
    bag = str(folder / "bag")
    program("simulate", "outer_ring_defect", "--duration", str(RECORDED), "--output", bag)
    works: dict[str, Callable[[], Cost]] = {
        "Python program to the first block of `healthy`": lambda: first_block("pocket"),
        f"`dcrb detect` on {RECORDED:g} s": lambda: program("detect", bag),
        "`dcrb info`": lambda: program("info", bag),
        "`dcrb --help`": lambda: program("--help"),
    }
    for work in works.values():
        work()
    measured = [{name: work() for name, work in works.items()} for _ in range(STARTED)]
    print("| start with compiled kernels | processor time [s] | memory [MB] |\n|---|---|---|")
    for name in works:
        costs = [run[name] for run in measured]
        processor, memory = statistics.median(c.processor for c in costs), statistics.median(c.memory for c in costs)
        print(f"| {name} | {processor:.2f} | {memory:.0f} |", flush=True)


def print_parts() -> None:
    """Print the parts of a start, medians."""
    runs = [[line.split(";") for line in cost([sys.executable, "-c", PARTS]).output.splitlines()] for _ in range(STARTED)]
    print("\n| part of the program to the first block | processor time [s] |\n|---|---|")
    for k, (part, _) in enumerate(runs[0]):
        print(f"| {part} | {statistics.median(float(run[k][1]) - (float(run[k - 1][1]) if k else 0.0) for run in runs):.2f} |")


def print_first_starts() -> None:
    """Print the cost of starts that compile the kernels."""
    print("\n| start that compiles | wall time [s] | processor time [s] | memory [MB] | cache [MB] |\n|---|---|---|---|---|")
    for name, joint in (("`healthy`", "pocket"), ("`healthy`, pinned rollers", "revolute")):
        with tempfile.TemporaryDirectory() as folder:
            found = first_block(joint, NUMBA_CACHE_DIR=folder)
            size = sum(file.stat().st_size for file in Path(folder).rglob("*") if file.is_file())
            print(f"| {name} | {found.wall:.0f} | {found.processor:.0f} | {found.memory:.0f} | {size / 1e6:.0f} |", flush=True)


def main() -> None:
    """Print the tables."""
    with tempfile.TemporaryDirectory() as folder:
        print_starts(Path(folder))
    print_parts()
    print_first_starts()


if __name__ == "__main__":
    main()
