"""What a sweep would cost: counts from the plan, time and room from a short calibration."""

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

SHORT, LONG = 0.05, 0.35
"""Recorded times of the two runs that a calibration compares [s]."""
CALIBRATED = 3
"""Groups of runs that are calibrated [-]."""


@dataclass(frozen=True)
class Estimate:
    """What a sweep would cost."""

    counts: Counter[tuple[str, str]]
    """Runs by split and case."""
    start: float
    """Time that a run takes before its first sample, its label and its share of a branch included [s]."""
    factor: float
    """Simulated over wall time of a worker from there on [-]."""
    per_run: float
    """Room of a run without samples [B]."""
    per_second: float
    """Room of a recorded second [B/s]."""
    duration: float
    refused: int
    """Runs of the calibration that were refused or failed [-]."""

    @property
    def runs(self) -> int:
        """Runs in the plan [-]."""
        return sum(self.counts.values())

    def seconds(self, workers: int) -> float:
        """Return the time that all runs take [s]."""
        return self.runs * (self.start + self.duration / self.factor) / workers

    @property
    def room(self) -> float:
        """Room of all files [B]."""
        return self.runs * (self.per_run + self.duration * self.per_second)


def estimate(plan: Plan) -> Estimate:
    """Return what a sweep would cost on workers like this process."""
    counts = Counter((run.split, run.case) for run in plan.runs())
    tasks = [task for task, _ in zip(plan.groups(), range(CALIBRATED), strict=False)]
    file = plan.sweep.file
    rate = float(plan.sweep.base["sensor.sampling_rate"])
    least = file.windows.length / rate if file.windows else 0.0
    _tried(plan, tasks[:1], SHORT)  # compiled and loaded
    brief, whole = _tried(plan, tasks, SHORT + least), _tried(plan, tasks, LONG + least)
    apart, runs = (LONG - SHORT), sum(len(task) for task in tasks)
    pace = max((whole.seconds - brief.seconds) / runs / apart, 1e-6)
    size = max((whole.room - brief.room) / runs / apart, 0.0)
    return Estimate(
        counts=counts,
        start=max(brief.seconds / runs - (SHORT + least) * pace, 0.0),
        factor=1.0 / pace,
        per_run=max(brief.room / runs - (SHORT + least) * size, 0.0),
        per_second=size,
        duration=file.duration,
        refused=whole.refused,
    )


@dataclass(frozen=True)
class _Trial:
    seconds: float
    room: float
    refused: int


def _tried(plan: Plan, tasks: list[Task], duration: float) -> _Trial:
    """Carry tasks out with another duration [s], into a folder that goes."""
    with tempfile.TemporaryDirectory(prefix="dcrb-sweep-") as folder:
        common = dataclasses.replace(common_settings(plan.sweep, Store(folder)), duration=duration)
        begin = time.perf_counter()
        outcomes = [status for task in tasks for _, status in run_task(common, task)]
        seconds = time.perf_counter() - begin
        room = sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())
    return _Trial(seconds, room, sum(status != DONE for status in outcomes))
