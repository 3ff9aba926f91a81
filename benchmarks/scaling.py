"""How processor time and memory grow with the size of a task, as a Markdown table with fitted exponents.

``python benchmarks/scaling.py`` measures each point in processes of its own, medians of three. The time is that of the task alone: its
process has imported everything, loaded the kernels and run a short task before. The memory is the largest resident memory of the process.
An exponent p is the slope of a straight line through the logarithms: cost = c n^p.
"""

from __future__ import annotations

import argparse
import atexit
import itertools
import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import psutil
from real_time import Run, kernel, recorded

from dcrb_ros.diagnosis.detection import detect
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.loader import sweep_of
from dcrb_ros.sweep.local_workers import local_workers
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.store import Store

BAG = Path(__file__).parents[1] / "bags" / "outer_ring_defect"
"""Recording of 3 s."""
SIMULATED = 1.0
"""Simulated time of a kernel, and of the bench with topics [s]."""
SWEPT = 0.25
"""Simulated time of a bearing in a sweep [s]."""
WARM = 0.1
"""Simulated time before a measurement [s]."""
TOPICS = (
    (),
    ("publishing.contacts=true",),
    ("publishing.clean=true",),
    ("publishing.features=true",),
    ("tacho.pulses_per_turn=60",),
    ("thermal.law=network",),
)
"""Settings that add topics to those of the bench, one after the other."""

Task = Callable[[int], Callable[[], object]]
"""Prepares a task of a size, and returns what runs it."""


class Quantity(NamedTuple):
    """A size with which cost grows."""

    name: str
    unit: str
    """What the time is of."""
    sizes: tuple[int, ...]
    task: Task


def of_rollers(bench: str, rows: int, per_row: int) -> Configuration:
    """Return a bench with other numbers of rollers: the same rollers under the same load each, on a pitch circle in proportion."""
    present = load_configuration(bench)
    b, factor = present.bearing, per_row / present.bearing.rollers_per_row
    pitch = factor * b.pitch_radius
    bearing = {
        "rows": rows,
        "rollers_per_row": per_row,
        "pitch_radius": pitch,
        "inner_raceway_radius": pitch - (b.pitch_radius - b.inner_raceway_radius),
        "outer_raceway_radius": pitch + (b.outer_raceway_radius - b.pitch_radius),
        "inner_ring_mass": factor * b.inner_ring_mass,
        "outer_ring_mass": factor * b.outer_ring_mass,
        "cage_mass": factor * b.cage_mass,
        "cage_inertia": factor**3 * b.cage_inertia,
    }
    load = present.operating.load * rows * factor / b.rows
    return load_configuration(bench, [*(f"bearing.{key}={value!r}" for key, value in bearing.items()), f"operating.load={load!r}"])


def warmed(run: Run, seconds: float) -> Callable[[], object]:
    """Return what runs for a simulated time [s], after a short run."""
    run(WARM)
    return lambda: run(seconds)


def rollers_in(bench: str, rows: int) -> Task:
    """Return the task of the kernel of a bench with a number of rollers in some rows."""
    return lambda rollers: warmed(kernel(of_rollers(bench, rows, rollers // rows)), SIMULATED)


def duration(seconds: int) -> Callable[[], object]:
    """Prepare a recording of some length [s]."""
    return warmed(recorded(load_configuration("healthy")), float(seconds))


def topics(more: int) -> Callable[[], object]:
    """Prepare a recording with more topics."""
    settings = list(itertools.chain.from_iterable(TOPICS[: more + 1]))
    return warmed(recorded(load_configuration("healthy", settings)), 5.0 * SIMULATED)


def recordings(count: int) -> Callable[[], object]:
    """Prepare the diagnosis of recordings, one after the other."""
    detect(Recording(BAG))
    return lambda: [detect(Recording(BAG)).verdict for _ in range(count)]


def detectors(count: int) -> Callable[[], object]:
    """Prepare detectors that receive the same signal block by block, as those of a train's axle boxes do."""
    recording = Recording(BAG)
    pieces = list(recording.pieces())

    def run(count: int) -> None:
        started = [FaultDetector(recording.orders, recording.sampling_rate) for _ in range(count)]
        for detector in started:
            detector.take_bearing(recording.bearing)
        for piece, detector in itertools.product(pieces, started):
            detector.update(piece.first_index, piece.acceleration, piece.shaft_angle)

    run(1)
    return lambda: run(count)


def bearings(count: int) -> Callable[[], object]:
    """Prepare a sweep of bearings by one worker, which has been started."""
    resources = ExitStack()
    folder, worker = resources.enter_context(tempfile.TemporaryDirectory()), resources.enter_context(local_workers(1, "auto"))

    def run(count: int, name: str) -> None:
        vary = {"surfaces.seed": {"low": 1, "high": 2_000_000_000}}
        tree: dict[str, Any] = {"base": "healthy", "design": "random", "points": count, "vary": vary, "cases": {"healthy": {}}}
        plan = Plan(sweep_of({**tree, "duration": SWEPT}, "benchmark"))
        with open_data_set(plan, Store(f"{folder}/{name}")) as data_set:
            data_set.make(worker, lambda _: None)

    run(1, "warm")
    atexit.register(resources.close)
    return lambda: run(count, "set")


QUANTITIES = {
    "dry-1": Quantity("rollers in one row, `dry`", f"{SIMULATED:g} s of the kernel", (8, 16, 32, 60), rollers_in("dry", 1)),
    "dry-2": Quantity("rollers in two rows, `dry`", f"{SIMULATED:g} s of the kernel", (16, 32, 64), rollers_in("dry", 2)),
    "healthy-1": Quantity("rollers in one row, `healthy`", f"{SIMULATED:g} s of the kernel", (8, 16, 32, 60), rollers_in("healthy", 1)),
    "healthy-2": Quantity("rollers in two rows, `healthy`", f"{SIMULATED:g} s of the kernel", (16, 32, 64), rollers_in("healthy", 2)),
    "bearings": Quantity("bearings in a sweep", f"{SWEPT:g} s each by one worker; memory of the worker", (1, 4, 16, 64), bearings),
    "duration": Quantity("duration [s]", "`dcrb simulate healthy` to a recording", (1, 10, 60), duration),
    "topics": Quantity("topics beside those of `healthy`", f"{5 * SIMULATED:g} s to a recording", tuple(range(len(TOPICS))), topics),
    "recordings": Quantity("recordings", "`detect` on 3 s each", (1, 4, 16), recordings),
    "detectors": Quantity("detectors in one process", "3 s of signal each", (1, 4, 16, 64), detectors),
}


class Cost(NamedTuple):
    """Cost of a point."""

    seconds: float
    """Processor time of the task [s]."""
    memory: float
    """Largest resident memory [MB]."""


def processor_time() -> float:
    """Return the processor time of this process and of those that it has started [s]."""
    return time.process_time() + sum(sum(child.cpu_times()[:2]) for child in psutil.Process().children())


def largest_memory() -> float:
    """Return the largest resident memory of this process, or of that which it has started [MB]."""
    started = [Path(f"/proc/{child.pid}/status").read_text() for child in psutil.Process().children()]
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    largest = max((int(status.partition("VmHWM:")[2].split()[0]) for status in started if "VmHWM:" in status), default=own)
    return largest * 1024 / 1e6


def point(key: str, size: int) -> Cost:
    """Measure a point in this process."""
    run = QUANTITIES[key].task(size)
    begin = processor_time()
    run()
    taken = processor_time() - begin
    return Cost(taken, largest_memory())


def measured(key: str, size: int) -> Cost:
    """Return the medians of a point, each time in a new process."""
    command = [sys.executable, __file__, "--point", key, str(size)]
    costs = [Cost(*json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)) for _ in range(3)]
    return Cost(statistics.median(cost.seconds for cost in costs), statistics.median(cost.memory for cost in costs))


def exponent(sizes: Iterable[float], values: Iterable[float]) -> float:
    """Return the slope of the straight line through the logarithms [-]."""
    return float(np.polyfit(np.log(list(sizes)), np.log(list(values)), 1)[0])


def row(quantity: Quantity, costs: dict[int, Cost]) -> str:
    """Return a row of the table; nothing is fitted to a quantity that begins with 0."""
    seconds, memory = zip(*costs.values(), strict=True)
    fitted = ["-", "-"] if 0 in costs else [f"{exponent(costs, values):.2f}" for values in (seconds, memory)]
    cells = [", ".join(map(str, costs)), ", ".join(f"{time:.3g}" for time in seconds), ", ".join(f"{most:.0f}" for most in memory)]
    return f"| {quantity.name} | {quantity.unit} | {' | '.join(cells + fitted)} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--point", nargs=2, metavar=("QUANTITY", "SIZE"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.point:
        print(json.dumps(point(options.point[0], int(options.point[1]))))
        return
    print("| quantity | of | sizes | processor time [s] | memory [MB] | exponent of time | of memory |\n|---|---|---|---|---|---|---|")
    costs = {}
    for key, quantity in QUANTITIES.items():
        costs[key] = {size: measured(key, size) for size in quantity.sizes}
        print(row(quantity, costs[key]), flush=True)
    longest, cost = list(costs["duration"].items())[-1]
    print(f"\nAn hour of `healthy` takes {cost.seconds * 60 / longest:.0f} min, extrapolated from {longest} s.")


if __name__ == "__main__":
    main()
