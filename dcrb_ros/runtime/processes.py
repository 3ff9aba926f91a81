"""Parallel work in processes, one per core, and their memory."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from pathlib import Path
from typing import TypeVar

from dcrb_ros.runtime.children import signals_blocked
from dcrb_ros.runtime.memory import keep_freed_memory
from dcrb_ros.runtime.signals import accept_termination
from dcrb_ros.runtime.threads import NamedThread
from dcrb_ros.schema.refusal import AlteredSamples

OUT_OF_MEMORY, ORPHANED = 74, 75
"""Exit statuses of a worker that exceeded its memory limit, or whose parent process has ended."""
CHECK_INTERVAL = 0.2
"""Time between two checks of a worker's memory [s]."""
Key = TypeVar("Key")
Value = TypeVar("Value")


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def available_memory() -> int:
    """Return the memory that this process and its children may use together [byte]: the machine's, or its container's."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    with contextlib.suppress(OSError, ValueError):  # no control group, or one without a limit
        memory = min(memory, int(Path("/sys/fs/cgroup/memory.max").read_text()))
    return memory


def resident_memory() -> int | None:
    """Return the memory that this process uses [byte]; None if the system does not report it."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return None


def in_processes(calls: Mapping[Key, Callable[[], Value]], workers: int) -> Iterator[tuple[Key, Value]]:
    """Yield the key and the result of each call in the order of completion; calls must be picklable, such as partials of functions.

    If the iteration ends early, by Ctrl-C for instance, the processes have been terminated; they also end with this process. An exception
    in a call is raised here.
    """
    # Spawned, because a process forked from one with threads may deadlock.
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), initializer=_prepare_worker) as pool:
        try:
            with worker_signals_blocked():  # a signal takes effect at its end
                jobs: dict[Future[Value], Key] = {pool.submit(call): key for key, call in calls.items()}
            for job in as_completed(jobs):
                # Results may be large and many: drop each one after it has been yielded.
                yield jobs.pop(job), job.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            stopped = multiprocessing.active_children()
            for worker in stopped:
                worker.terminate()
            for worker in stopped:
                worker.join()
            raise


@contextlib.contextmanager
def worker_signals_blocked() -> Iterator[None]:
    """Start processes of `multiprocessing` with termination signals blocked."""
    if hasattr(signal, "pthread_sigmask"):
        resource_tracker.ensure_running()  # its start would unblock the signals
    with signals_blocked():
        yield


def _prepare_worker() -> None:
    """Ignore SIGINT, exit with the parent, and keep freed memory. The parent warns of altered samples."""
    warnings.simplefilter("ignore", AlteredSamples)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    accept_termination()
    keep_freed_memory()
    NamedThread("parent", watch_parent).start()


def watch_parent(memory: int | None = None) -> None:
    """End this process, a worker, when its parent has ended or it exceeds a memory limit [byte]."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    while not wait([parent.sentinel], None if memory is None else CHECK_INTERVAL):
        if memory is not None and (resident_memory() or 0) > memory:
            os._exit(OUT_OF_MEMORY)
    os._exit(ORPHANED)
