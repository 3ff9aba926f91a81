"""Tasks on the workers of a Dask cluster, with a bounded number of submitted tasks."""

from __future__ import annotations

import asyncio
import itertools
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from dcrb_ros.recordings.manifest import model_fingerprint
from dcrb_ros.runtime.optional import installed
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.execution import CommonSettings, run_task, software_versions
from dcrb_ros.sweep.plan import Task
from dcrb_ros.sweep.store import StoreFailed
from dcrb_ros.sweep.workers import Outcome
from dcrb_ros.text.counts import counted

if TYPE_CHECKING:
    from distributed import Client, Future

PATIENCE = 10.0
"""Longest wait for the scheduler's answer, and for its first worker [s]."""
TASKS_PER_WORKER = 3
"""Tasks submitted per worker at a time [-]: one runs, the others are queued so that the worker never idles."""


class ClusterWorkers:
    """The workers of a Dask cluster."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self.count = max(1, sum(client.nthreads().values()))
        """Tasks that are processed at the same time [-]."""

    def __str__(self) -> str:
        return f"{counted(self.count, 'worker')}, dashboard: {self._client.dashboard_link}"

    def dispatched(self, common: CommonSettings, tasks: Iterator[Task]) -> Iterator[tuple[Task, Outcome]]:
        """Yield each task with its outcome; see `Workers.dispatched`.

        Raises:
            RuntimeError: the connection to the scheduler was lost.
        """
        from distributed import as_completed

        scheduler = str(getattr(self._client.scheduler, "address", ""))
        known: dict[Future[Any], Task] = {}
        queue = as_completed(loop=self._client.loop)

        def submit(count: int) -> None:
            for task in itertools.islice(tasks, count):
                future = self._client.submit(run_task, common, task, pure=False)
                known[future] = task
                queue.add(future)

        try:
            submit(TASKS_PER_WORKER * self.count)
            for future in queue:
                task = known.pop(future)
                if future.cancelled():
                    raise RuntimeError(
                        f"the connection to the scheduler {scheduler} was lost: start it and its workers again, and run the same "
                        "command again to continue"
                    )
                outcome = _outcome(future)
                future.release()
                if isinstance(outcome, StoreFailed):
                    raise outcome
                submit(1)
                yield task, outcome
        finally:
            if known:
                self._client.cancel(list(known))


@contextmanager
def cluster_workers(scheduler: str) -> Iterator[ClusterWorkers]:
    """Use the workers of a scheduler, such as ``tls://10.0.0.1:8786``.

    Raises:
        Refusal: Dask is not installed, the scheduler cannot be reached, or its workers are missing or run another model.
    """
    installed("distributed", "--scheduler needs Dask: pip install dask distributed")
    from distributed import Client

    # The command states a failure in a sentence; Dask logs it with tracebacks.
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    try:
        client = Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        raise Refusal(f"the scheduler {scheduler} cannot be reached: {_reason_and_remedy(scheduler, error)}") from None
    with client:
        _compare(client, scheduler)
        yield ClusterWorkers(client)


def _reason_and_remedy(scheduler: str, error: Exception) -> str:
    """Return why a client could not connect to a scheduler, and what to do."""
    text = str(error)
    if "ssl_context" in text:
        return "Dask has no certificate on this machine; set DASK_DISTRIBUTED__COMM__TLS__CA_FILE, __CLIENT__CERT and __CLIENT__KEY"
    if "encryption required" in text:
        return "Dask requires encryption on this machine; give an address that begins with tls://"
    protocol = "tls" if scheduler.startswith("tls:") else "tcp"
    return (
        f"{text.splitlines()[0] if text else 'it does not answer'}; start one with 'dask scheduler --protocol {protocol}' and give its "
        f"address, such as {protocol}://10.0.0.1:8786"
    )


def _outcome(future: Future[Any]) -> Outcome:
    from distributed import KilledWorker

    error = future.exception()
    if error is None:
        statuses: list[tuple[str, str]] = future.result()
        return statuses
    if isinstance(error, KilledWorker):
        return RuntimeError("its worker was lost repeatedly, perhaps out of memory: give the workers more memory, or shorten the runs")
    return error if isinstance(error, Exception) else RuntimeError(str(error))


def _compare(client: Client, scheduler: str) -> None:
    """Refuse missing workers, and workers that would compute other samples."""
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except (TimeoutError, asyncio.TimeoutError):
        raise Refusal(f"the scheduler {scheduler} has no workers: start some with 'dask worker {scheduler} --nthreads 1'") from None
    try:
        installed = set(client.run(software_versions).values())
    except Exception as error:  # a machine without this package may raise any exception
        raise Refusal(f"the workers of {scheduler} cannot run dcrb_ros ({error}): install version {__version__} there") from None
    for version, model in sorted(installed - {software_versions()}):
        raise Refusal(
            f"the workers of {scheduler} run dcrb_ros {version} with model {model}, but this is {__version__} with model "
            f"{model_fingerprint()}: install the same version on all machines"
        )
