"""The workers of a sweep, on this machine or on a cluster, behind one interface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from dcrb_ros.sweep.execution import CommonSettings
from dcrb_ros.sweep.plan import Task

Outcome = list[tuple[str, str]] | Exception
"""Name and status of each run of a task, or the exception that ended the task."""


class Workers(Protocol):
    """Something that processes tasks; as text, a description for the user."""

    @property
    def count(self) -> int:
        """Tasks that are processed at the same time [-]."""

    def dispatched(self, common: CommonSettings, tasks: Iterator[Task]) -> Iterator[tuple[Task, Outcome]]:
        """Yield each task with its outcome, in the order of completion.

        A task whose worker is lost goes to another one. Only as many tasks are generated as keep the workers busy.

        Raises:
            StoreFailed: the data set cannot be written; no further task begins.
        """
