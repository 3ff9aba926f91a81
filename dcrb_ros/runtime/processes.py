"""Parallel work in processes, one per core."""

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
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_processes(calls: Mapping[Key, Callable[[], Value]], workers: int) -> Iterator[tuple[Key, Value]]:
    """Yield the key and the result of each call in the order of completion; calls must be picklable, such as partials of functions.

    If the iteration ends early, by Ctrl-C for instance, the processes are terminated at once. An exception in a call is raised here.
    """
    # Spawned, because a process forked from one with threads may deadlock. Ctrl-C is handled by the parent, which ends its workers.
    spawning, ignored = multiprocessing.get_context("spawn"), (signal.SIGINT, signal.SIG_IGN)
    with ProcessPoolExecutor(workers, mp_context=spawning, initializer=signal.signal, initargs=ignored) as pool:
        jobs: dict[Future[Value], Key] = {pool.submit(call): key for key, call in calls.items()}
        try:
            for job in as_completed(jobs):
                # Results may be large and many: drop each one after it has been yielded.
                yield jobs.pop(job), job.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for worker in multiprocessing.active_children():
                worker.terminate()
            raise
