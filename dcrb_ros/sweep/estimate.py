"""The estimated cost of a sweep: run counts from the plan, time and disk space from a few short runs.

The time is processor time. Other programs on the machine delay the short runs by different times, and the difference of the wall times is
then no measure of the cost per second. The wall time of all short runs together over their processor time is the delay at present.
"""

from __future__ import annotations

import dataclasses
import math
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from dcrb_ros.runtime.processes import cores
from dcrb_ros.sweep.execution import common_settings, run_task
from dcrb_ros.sweep.label import DONE
from dcrb_ros.sweep.plan import Plan, Task
from dcrb_ros.sweep.store import Store

SHORT_RUN, LONG_RUN = 0.05, 0.35
"""Recorded times of the two calibration runs, from whose difference the cost per second follows [s]."""
CALIBRATION_TASKS, CALIBRATION_RUNS = 3, 16
"""Tasks used for the calibration, and the largest number of runs of each [-]."""


@dataclass(frozen=True)
class Cost:
    """The estimated cost of a sweep."""

    counts: Counter[tuple[str, str]]
    """Runs by split and case."""
    worker_start: float
    """Time in which a worker process starts [s]."""
    start: float
    """Time of a run before its first sample on an idle core, including its label and its share of a branch point [s]."""
    factor: float
    """Real-time factor of a worker on an idle core after that [-]."""
    per_run: float
    """Disk space of a run without samples [B]."""
    per_second: float
    """Disk space per recorded second [B/s]."""
    duration: float
    delay: float
    """Wall time of the calibration runs over their processor time, above 1 with a slow disk or other programs on the cores [-]."""
    refused: int
    """Calibration runs that were refused or failed [-]."""

    @property
    def runs(self) -> int:
        """Runs in the plan [-]."""
        return sum(self.counts.values())

    def seconds(self, workers: int) -> float:
        """Return the wall time of all runs on idle cores, which the workers share if they are more than the cores [s]."""
        starts = min(workers, self.runs) * self.worker_start
        return (starts + self.runs * (self.start + self.duration / self.factor)) / min(workers, cores())

    @property
    def size(self) -> float:
        """Disk space of all files [B]."""
        return self.runs * (self.per_run + self.duration * self.per_second)


def estimate(plan: Plan) -> Cost:
    """Return the estimated cost of a sweep on workers as fast as this process."""
    counts: Counter[tuple[str, str]] = Counter()
    tasks = _spread(plan.groups(), counts)
    file = plan.sweep.file
    window = file.windows.length / plan.sweep.rate if file.windows else 0.0
    _trial(plan, tasks[:1], SHORT_RUN)  # compiles the kernels and loads the modules
    short, long = _trial(plan, tasks, SHORT_RUN + window), _trial(plan, tasks, LONG_RUN + window)
    difference, runs = LONG_RUN - SHORT_RUN, sum(len(task) for task in tasks)
    time_per_second = max((long.seconds - short.seconds) / runs / difference, 1e-6)
    per_second = max((long.size - short.size) / runs / difference, 0.0)
    return Cost(
        counts=counts,
        worker_start=_worker_start(),
        start=max(short.seconds / runs - (SHORT_RUN + window) * time_per_second, 0.0),
        factor=1.0 / time_per_second,
        per_run=max(short.size / runs - (SHORT_RUN + window) * per_second, 0.0),
        per_second=per_second,
        duration=file.duration,
        delay=max((short.wall + long.wall) / max(short.seconds + long.seconds, 1e-6), 1.0),
        refused=long.refused,
    )


def _worker_start() -> float:
    """Return the processor time in which a process loads what a worker needs [s]."""
    before = os.times()
    subprocess.run([sys.executable, "-c", "import dcrb_ros.sweep.local_workers, dcrb_ros.core"], check=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def _spread(groups: Iterator[Task], counts: Counter[tuple[str, str]]) -> list[Task]:
    """Return tasks for the calibration from the whole plan, whose first runs may be the cheapest ones, such as those of new bearings.

    All runs are added to ``counts``, by split and case.
    """
    kept: list[Task] = []
    stride = 1
    for number, group in enumerate(groups):
        counts.update((run.split, run.case) for run in group)
        if number % stride == 0:
            kept.append(group)
        if len(kept) > 2 * CALIBRATION_TASKS:
            kept, stride = kept[::2], 2 * stride
    count = min(CALIBRATION_TASKS, len(kept))
    middles = [kept[(2 * k + 1) * len(kept) // (2 * count)] for k in range(count)]
    return [task[:: math.ceil(len(task) / CALIBRATION_RUNS)] for task in middles]


@dataclass(frozen=True)
class _Trial:
    seconds: float
    """Processor time [s]."""
    wall: float
    """Wall time [s]."""
    size: float
    refused: int


def _trial(plan: Plan, tasks: list[Task], duration: float) -> _Trial:
    """Run tasks with another duration [s] in a temporary folder."""
    with tempfile.TemporaryDirectory(prefix="dcrb-sweep-") as folder:
        file = plan.sweep.file.model_copy(update={"duration": duration})
        common = common_settings(dataclasses.replace(plan.sweep, file=file), Store(folder))
        begin, begin_wall = time.process_time(), time.perf_counter()
        outcomes = [status for task in tasks for _, status in run_task(common, task)]
        seconds, wall = time.process_time() - begin, time.perf_counter() - begin_wall
        size = sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())
    return _Trial(seconds, wall, size, sum(status != DONE for status in outcomes))
