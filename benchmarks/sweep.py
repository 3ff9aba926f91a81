"""Overhead of a sweep: simulated time per second of processor time relative to the kernel.

The kernel is measured before and after in as many parallel processes as there are workers; processor times are compared.
"""

from __future__ import annotations

import os
import statistics
import tempfile
from functools import partial

import psutil
from real_time import kernel_factor

from dcrb_ros.runtime.processes import in_processes
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.loader import sweep_of
from dcrb_ros.sweep.local_workers import LocalWorkers, local_workers
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.store import Store


def plan(joint: str, runs: int, duration: float) -> Plan:
    """Return a plan of healthy and faulty runs of a duration [s]."""
    cases = {"healthy": {}, "outer": {"faults.outer_1.width": {"low": 0.001, "high": 0.003}}}
    vary = {"operating.load": {"low": 4e4, "high": 1.2e5}}
    tree = {"base": "healthy", "set": {"cage.joint": joint}, "design": "random", "points": max(runs // 2, 1), "vary": vary, "cases": cases}
    return Plan(sweep_of({**tree, "duration": duration}, "benchmark"))


def kernels(joint: str, workers: int) -> list[float]:
    """Return the factor of each of ``workers`` kernels that run in parallel for 3 s [-]."""
    bench = load_configuration("healthy", [f"cage.joint={joint}"])
    return [factor for _, factor in in_processes({k: partial(kernel_factor, bench, 3.0) for k in range(workers)}, workers)]


def processor_time(workers: LocalWorkers) -> float:
    """Return the processor time of all workers [s]."""
    return sum(sum(psutil.Process(number).cpu_times()[:2]) for number in workers.process_ids)


def measured(joint: str, runs: int, duration: float) -> str:
    """Return a row of the table."""
    workers = os.cpu_count() or 1
    before = kernels(joint, workers)
    with tempfile.TemporaryDirectory() as folder, local_workers(workers, "auto") as processes:
        with open_data_set(plan(joint, 2 * workers, 0.1), Store(f"{folder}/warm")) as data_set:
            data_set.make(processes, lambda _: None)
        with open_data_set(plan(joint, runs, duration), Store(f"{folder}/set")) as data_set:
            spent = processor_time(processes)
            tally = data_set.make(processes, lambda _: None)
            spent = processor_time(processes) - spent
    alone = statistics.mean([*before, *kernels(joint, workers)])
    factor = tally.seconds / spent
    return f"| {joint} | {runs} of {duration:g} s | {alone:.2f} | {factor:.2f} | {factor / alone:.2f} |"


def main() -> None:
    """Print the table."""
    print("| `healthy` with the cage joint | runs | simulated seconds per second, kernel | sweep | ratio |\n|---|---|---|---|---|")
    for joint in ("revolute", "pocket"):
        print(measured(joint, 16, 10.0), flush=True)


if __name__ == "__main__":
    main()
