"""Work in processes of their own, on all cores."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from typing import TypeVar

Key = TypeVar("Key")
Value = TypeVar("Value")


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_processes(calls: Mapping[Key, Callable[[], Value]], workers: int) -> Iterator[tuple[Key, Value]]:
    """Yield what each call returns, with its key, as they end; calls must be picklable, a partial of a module's function say.

    Whatever ends the iteration, Ctrl-C too, ends the processes at once.
    """
    # Spawned: a process forked from one with threads may never start. Ctrl-C is for the parent, which ends its workers.
    spawning, ignored = multiprocessing.get_context("spawn"), (signal.SIGINT, signal.SIG_IGN)
    with ProcessPoolExecutor(workers, mp_context=spawning, initializer=signal.signal, initargs=ignored) as pool:
        jobs: dict[Future[Value], Key] = {pool.submit(call): key for key, call in calls.items()}
        try:
            for job in as_completed(jobs):
                # What has been handed over is not kept: results may be large and many.
                yield jobs.pop(job), job.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for worker in multiprocessing.active_children():
                worker.terminate()
            raise
