"""How much many bearings at once gain: simulated over wall time with one process and with one per core, against the kernel alone."""

from __future__ import annotations

import argparse
import os
import statistics
import time

from real_time import factors, kernel

from dcrb_ros.configuration import Configuration
from dcrb_ros.many import simulate_many


def throughput(configurations: list[Configuration], duration: float, workers: int) -> float:
    """Return simulated over wall time of all bearings, the processes' start left out."""
    arrived = [time.perf_counter()]
    for _ in simulate_many(configurations, duration, workers=workers):
        arrived.append(time.perf_counter())
    first = arrived[workers]
    return duration * (len(configurations) - workers) / (arrived[-1] - first)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=3.0, help="simulated time of a bearing [s]")
    parser.add_argument("--bearings", type=int, default=6, help="bearings for each process [-]")
    options = parser.parse_args()
    print("| joint | processes | x real time | per process, against the kernel |\n|---|---|---|---|")
    for joint in ("pocket", "revolute"):
        alone = statistics.median(factors(kernel(Configuration.model_validate({"cage": {"joint": joint}})), 1.0, 5))
        for workers in sorted({1, os.cpu_count() or 1}):
            groups = [{"cage": {"joint": joint}, "simulation": {"seed": seed}} for seed in range((1 + options.bearings) * workers)]
            found = throughput([Configuration.model_validate(group) for group in groups], options.duration, workers)
            print(f"| {joint} | {workers} | {found:.2f} | {found / workers / alone:.2f} |", flush=True)


if __name__ == "__main__":
    main()
