"""Data sets that tests make in their own process."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.execution import CommonSettings, run_task
from dcrb_ros.sweep.kinds import plan_of
from dcrb_ros.sweep.loader import sweep_of
from dcrb_ros.sweep.plan import Plan, Task
from dcrb_ros.sweep.store import Store
from dcrb_ros.sweep.workers import Outcome


class Here:
    """A worker in this process that remembers its runs."""

    count = 1

    def __init__(self) -> None:
        self.runs: list[str] = []

    def dispatched(self, common: CommonSettings, tasks: Iterator[Task]) -> Iterator[tuple[Task, Outcome]]:
        for task in tasks:
            self.runs += [run.name for run in task]
            yield task, run_task(common, task)


def made(given: Plan | Mapping[str, Any], folder: Path) -> list[str]:
    """Make, continue or extend the data set of a plan, or of a sweep as written; return the names of the runs that were simulated."""
    worker = Here()
    plan = given if isinstance(given, Plan) else plan_of(sweep_of(given, "sweep.yaml", text=yaml.safe_dump(given, sort_keys=False)))
    with open_data_set(plan, Store(str(folder))) as data_set:
        data_set.make(worker, lambda _: None)
    return worker.runs
