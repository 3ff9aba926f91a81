"""The estimated cost of a sweep: run counts from the plan, time and disk space from a few short runs.

The time is processor time. Other programs on the machine delay the short runs by different times, and the difference of the wall times is
then no measure of the cost per second.
"""

from __future__ import annotations

import dataclasses
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from dcrb_ros.sweep.execution import common_settings, run_task
from dcrb_ros.sweep.label import DONE
from dcrb_ros.sweep.plan import Plan, Task
from dcrb_ros.sweep.store import Store

SHORT_RUN, LONG_RUN = 0.05, 0.35
"""Recorded times of the two calibration runs, from whose difference the cost per second follows [s]."""
CALIBRATION_TASKS = 3
"""Tasks used for the calibration [-]."""


@dataclass(frozen=True)
class Cost:
    """The estimated cost of a sweep."""

    counts: Counter[tuple[str, str]]
    """Runs by split and case."""
    start: float
    """Time of a run before its first sample on an idle core, including its label and its share of a branch point [s]."""
    factor: float
    """Real-time factor of a worker on an idle core after that [-]."""
    per_run: float
    """Disk space of a run without samples [B]."""
    per_second: float
    """Disk space per recorded second [B/s]."""
    duration: float
    refused: int
    """Calibration runs that were refused or failed [-]."""

    @property
    def runs(self) -> int:
        """Runs in the plan [-]."""
        return sum(self.counts.values())

    def seconds(self, workers: int) -> float:
        """Return the wall time of all runs with an idle core for each worker [s]."""
        return self.runs * (self.start + self.duration / self.factor) / workers

    @property
    def size(self) -> float:
        """Disk space of all files [B]."""
        return self.runs * (self.per_run + self.duration * self.per_second)


def estimate(plan: Plan) -> Cost:
    """Return the estimated cost of a sweep on workers as fast as this process."""
    counts = Counter((run.split, run.case) for run in plan.runs())
    tasks = [task for task, _ in zip(plan.groups(), range(CALIBRATION_TASKS), strict=False)]
    file = plan.sweep.file
    window = file.windows.length / plan.sweep.rate if file.windows else 0.0
    _trial(plan, tasks[:1], SHORT_RUN)  # compiles the kernels and loads the modules
    short, long = _trial(plan, tasks, SHORT_RUN + window), _trial(plan, tasks, LONG_RUN + window)
    difference, runs = LONG_RUN - SHORT_RUN, sum(len(task) for task in tasks)
    time_per_second = max((long.seconds - short.seconds) / runs / difference, 1e-6)
    per_second = max((long.size - short.size) / runs / difference, 0.0)
    return Cost(
        counts=counts,
        start=max(short.seconds / runs - (SHORT_RUN + window) * time_per_second, 0.0),
        factor=1.0 / time_per_second,
        per_run=max(short.size / runs - (SHORT_RUN + window) * per_second, 0.0),
        per_second=per_second,
        duration=file.duration,
        refused=long.refused,
    )


@dataclass(frozen=True)
class _Trial:
    seconds: float
    size: float
    refused: int


def _trial(plan: Plan, tasks: list[Task], duration: float) -> _Trial:
    """Run tasks with another duration [s] in a temporary folder."""
    with tempfile.TemporaryDirectory(prefix="dcrb-sweep-") as folder:
        file = plan.sweep.file.model_copy(update={"duration": duration})
        common = common_settings(dataclasses.replace(plan.sweep, file=file), Store(folder))
        begin = time.process_time()
        outcomes = [status for task in tasks for _, status in run_task(common, task)]
        seconds = time.process_time() - begin
        size = sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())
    return _Trial(seconds, size, sum(status != DONE for status in outcomes))
