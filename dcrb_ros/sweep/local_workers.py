"""Workers on this machine: processes that receive their tasks through pipes. Nothing listens on a port."""

from __future__ import annotations

import itertools
import multiprocessing
import os
import signal
from collections.abc import Iterator
from contextlib import closing, contextmanager
from multiprocessing.connection import Connection, wait
from typing import cast

from dcrb_ros.runtime.linear_algebra import ONE_THREAD
from dcrb_ros.runtime.processes import OUT_OF_MEMORY, available_memory, cores, resident_memory, watch_parent, worker_signals_blocked
from dcrb_ros.runtime.threads import NamedThread
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.execution import CommonSettings, run_task
from dcrb_ros.sweep.plan import Task
from dcrb_ros.sweep.store import StoreFailed
from dcrb_ros.sweep.workers import Outcome
from dcrb_ros.text.counts import counted

SPAWN = multiprocessing.get_context("spawn")
MOST_ATTEMPTS = 4
"""Times that a task is begun if its worker is lost each time [-]."""
ENDING_TIME = 5.0
"""Longest wait for the exit status of a process that has closed its connection [s]."""


def parsed_memory(memory: str, count: int) -> int | None:
    """Return the memory limit of each of ``count`` workers [byte]; None if the system does not report the memory of a process.

    Raises:
        Refusal: ``memory`` is neither a size nor ``auto``, or it cannot be limited here.
    """
    measurable = resident_memory() is not None
    if memory == "auto":
        return available_memory() // count if measurable else None
    from pydantic import ByteSize, TypeAdapter, ValidationError

    try:
        limit = int(TypeAdapter(ByteSize).validate_python(memory))
    except (ValidationError, OverflowError):
        raise Refusal(f"--memory {memory} is not a size: give one such as 2GB, or auto for an equal share of the machine's") from None
    if not measurable:
        raise Refusal(f"--memory {memory} needs Linux, which tells the memory of a process: leave it out")
    if limit < (needed := resident_memory() or 0):
        raise Refusal(f"--memory {memory} is less than the {needed / 1e6:.0f} MB that a worker needs at its start: give at least 500MB")
    return limit


def local_workers(count: int | None, memory: str) -> closing[LocalWorkers]:
    """Return worker processes on this machine, by default one per core, for a block with which they end.

    ``memory`` limits each of them: a size such as ``2GB``, or ``auto`` for an equal share of the machine's memory.

    Raises:
        Refusal: ``memory`` is not a size, or too small.
    """
    return closing(LocalWorkers(count or cores(), parsed_memory(memory, count or cores())))


class LocalWorkers:
    """Worker processes on this machine."""

    def __init__(self, count: int, memory: int | None) -> None:
        self.count = count
        """Tasks that are processed at the same time [-]."""
        self._memory = memory
        self._busy: dict[Connection, _Process] = {}
        self._idle: list[_Process] = []

    def __str__(self) -> str:
        return counted(self.count, "worker")

    @property
    def process_ids(self) -> list[int]:
        """Ids of the processes that exist; they are started when there are tasks for them."""
        return [process.id for process in (*self._busy.values(), *self._idle)]

    def dispatched(self, common: CommonSettings, tasks: Iterator[Task]) -> Iterator[tuple[Task, Outcome]]:
        """Yield each task with its outcome; see `Workers.dispatched`."""
        for task in itertools.islice(tasks, self.count):
            self._begin(common, task)
        while self._busy:
            for connection in wait(list(self._busy)):
                process = self._busy.pop(cast(Connection, connection))
                task, outcome = process.task, process.outcome()
                if outcome is None:
                    reason = self._lost(process)
                    if process.attempts < MOST_ATTEMPTS:
                        self._begin(common, task, process.attempts + 1)
                        continue
                    outcome = RuntimeError(reason)
                else:
                    self._idle.append(process)
                if isinstance(outcome, StoreFailed):
                    raise outcome
                for following in itertools.islice(tasks, 1):
                    self._begin(common, following)
                yield task, outcome

    def close(self) -> None:
        """End all processes."""
        for process in (*self._busy.values(), *self._idle):
            process.end()

    def _begin(self, common: CommonSettings, task: Task, attempts: int = 1) -> None:
        """Begin a task in an idle process, or in a new one."""
        process = self._idle.pop() if self._idle else _Process(self._memory)
        self._busy[process.connection] = process
        process.begin(common, task, attempts)

    def _lost(self, process: _Process) -> str:
        """Clear up after a process that has ended; return the reason."""
        if process.end(ENDING_TIME) == OUT_OF_MEMORY and self._memory is not None:
            return f"its worker needed more than {self._memory / 1e9:.3g} GB of memory: increase --memory, or shorten the runs"
        return "its worker was lost repeatedly, perhaps out of memory: use fewer --workers, or shorten the runs"


class _Process:
    """A worker process, and the task that it processes."""

    def __init__(self, memory: int | None) -> None:
        self.connection, worker_end = SPAWN.Pipe()
        self._process = SPAWN.Process(target=_process_tasks, args=(worker_end, memory), name="sweep worker", daemon=True)
        with _inherited_settings():
            self._process.start()
        worker_end.close()
        self.task: Task = ()
        self.attempts = 0
        """Times that the task has been begun [-]."""

    @property
    def id(self) -> int:
        return self._process.pid or 0

    def begin(self, common: CommonSettings, task: Task, attempts: int) -> None:
        """Begin a task that has been begun ``attempts`` times, this time included."""
        self.task, self.attempts = task, attempts
        try:
            self.connection.send((common, task))
        except OSError:
            return  # the process has been lost, which `outcome` reports

    def outcome(self) -> Outcome | None:
        """Return the outcome of the task; None if the process has been lost."""
        try:
            outcome: Outcome = self.connection.recv()
            return outcome
        except (EOFError, OSError):
            return None

    def end(self, patience: float = 0.0) -> int | None:
        """End the process, which may end by itself within ``patience`` [s], and return its exit status."""
        self._process.join(patience)
        self._process.kill()
        self._process.join()
        self.connection.close()
        return self._process.exitcode


@contextmanager
def _inherited_settings() -> Iterator[None]:
    """Give the processes started within the block one thread each, and let their parent handle Ctrl-C and other termination signals."""
    before = dict(os.environ)
    os.environ.update(ONE_THREAD)
    try:
        with worker_signals_blocked():
            yield
    finally:
        os.environ.clear()
        os.environ.update(before)


def _process_tasks(connection: Connection, memory: int | None) -> None:
    """Process tasks until the other end of the connection is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # on systems without signal masks
    NamedThread("watch", lambda: watch_parent(memory)).start()
    while True:
        try:
            common, task = connection.recv()
        except EOFError:
            return
        try:
            outcome: Outcome = run_task(common, task)
        except StoreFailed as failure:
            outcome = failure
        except Exception as error:
            outcome = RuntimeError(f"{type(error).__name__}: {error}")
        connection.send(outcome)
