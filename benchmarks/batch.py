"""Throughput of a batch of bearings with one process and with one per core, relative to the kernel alone."""

from __future__ import annotations

import argparse
import os
import statistics
import time

from real_time import factors, kernel

from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.batch import simulate_batch


def throughput(configurations: list[Configuration], duration: float, workers: int) -> float:
    """Return simulated over wall time of all bearings [-], without the start of the processes."""
    finished = [time.perf_counter()]
    for _ in simulate_batch(configurations, duration, workers=workers):
        finished.append(time.perf_counter())
    first = finished[workers]
    return duration * (len(configurations) - workers) / (finished[-1] - first)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=3.0, help="simulated time of a bearing [s]")
    parser.add_argument("--bearings", type=int, default=6, help="number of bearings per process")
    options = parser.parse_args()
    print("| joint | processes | x real time | per process, relative to the kernel |\n|---|---|---|---|")
    for joint in ("pocket", "revolute"):
        alone = statistics.median(factors(kernel(Configuration.model_validate({"cage": {"joint": joint}})), 1.0, 5))
        for workers in sorted({1, os.cpu_count() or 1}):
            groups = [{"cage": {"joint": joint}, "simulation": {"seed": seed}} for seed in range((1 + options.bearings) * workers)]
            factor = throughput([Configuration.model_validate(group) for group in groups], options.duration, workers)
            print(f"| {joint} | {workers} | {factor:.2f} | {factor / workers / alone:.2f} |", flush=True)


if __name__ == "__main__":
    main()
