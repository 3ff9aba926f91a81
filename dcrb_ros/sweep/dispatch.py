"""Tasks on Dask: workers of this machine or of a cluster, a bounded number of tasks under way."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from dcrb_ros import __version__
from dcrb_ros.recordings.manifest import model_fingerprint
from dcrb_ros.runtime.processes import cores
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.sweep.execution import CommonSettings, run_task
from dcrb_ros.sweep.plan import Task
from dcrb_ros.sweep.store import StoreFailed

if TYPE_CHECKING:
    from distributed import Client, Future

PATIENCE = 10.0
"""How long a scheduler may take to answer, and to find its first worker [s]."""
WAITING = 3
"""Tasks per worker that are handed over at once: one runs, the others keep it from waiting."""

SELDOM = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "500ms",
    "distributed.admin.system-monitor.interval": "2s",
    "distributed.worker.memory.monitor-interval": "500ms",
}
"""How often workers look after themselves: as Dask has it, that takes each of them 2 % of a core."""

Outcome = list[tuple[str, str]] | Exception
"""Name and outcome of each run of a task, or why there is none."""


@contextmanager
def workers_here(count: int | None, memory: str) -> Iterator[Client]:
    """Start workers on this machine, a process per core without a ``count``, each held to its ``memory``.

    Raises:
        Refusal: Dask is not installed, or the memory is no size.
    """
    _require_dask()
    import dask
    from dask.utils import parse_bytes
    from distributed import Client, LocalCluster

    try:
        limit = None if memory == "auto" else parse_bytes(memory)
    except ValueError:
        raise Refusal(f"--memory {memory}: it is no size; write such as 2GB, or auto for an equal share of the machine's") from None
    # There is a web server even without bokeh, and so without a dashboard.
    place = "127.0.0.1:8787" if dashboard_there() else "127.0.0.1:0"
    with (
        dask.config.set(SELDOM),
        LocalCluster(
            n_workers=count or cores(),
            threads_per_worker=1,
            processes=True,
            memory_limit=limit or "auto",
            host="127.0.0.1",
            dashboard_address=place,
            silence_logs=50,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


@contextmanager
def workers_of(scheduler: str) -> Iterator[Client]:
    """Use the workers of a scheduler, such as ``tcp://10.0.0.1:8786``.

    Raises:
        Refusal: Dask is not installed, or the scheduler or its workers cannot be reached or run another model.
    """
    _require_dask()
    from distributed import Client

    try:
        client = Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError, TypeError) as error:
        why = str(error).splitlines()[0] if str(error) else "it does not answer"
        raise Refusal(
            f"the scheduler {scheduler} cannot be reached: {why}; start one with 'dask scheduler' and give its address, such as "
            "tcp://10.0.0.1:8786"
        ) from None
    with client:
        _compare(client, scheduler)
        yield client


def dashboard_there() -> bool:
    """Return whether Dask's dashboard can be shown."""
    from importlib.util import find_spec

    return find_spec("bokeh") is not None


def dispatched(client: Client, common: CommonSettings, tasks: Iterator[Task]) -> Iterator[tuple[Task, Outcome]]:
    """Yield each task with what became of its runs, as they end.

    A task whose worker is lost goes to another one. No more tasks are asked for than keep the workers busy.

    Raises:
        StoreFailed: the place of the data set cannot be written; nothing is started any more.
    """
    from distributed import as_completed

    known: dict[Future[Any], Task] = {}
    queue = as_completed()

    def hand_over(count: int) -> None:
        for task in itertools.islice(tasks, count):
            future = client.submit(run_task, common, task, key=f"sweep-{task[0].name}", pure=False)
            known[future] = task
            queue.add(future)

    try:
        hand_over(WAITING * max(1, sum(client.nthreads().values())))
        for future in queue:
            task = known.pop(future)
            outcome = _outcome(future)
            future.release()
            if isinstance(outcome, StoreFailed):
                raise outcome
            hand_over(1)
            yield task, outcome
    finally:
        if known:
            client.cancel(list(known))


def _outcome(future: Future[Any]) -> Outcome:
    from distributed import KilledWorker

    error = future.exception()
    if error is None:
        found: list[tuple[str, str]] = future.result()
        return found
    if isinstance(error, KilledWorker):
        return RuntimeError("its worker was lost again and again, for want of memory perhaps: give --memory, or shorter runs")
    return error if isinstance(error, Exception) else RuntimeError(str(error))


def _compare(client: Client, scheduler: str) -> None:
    """Refuse workers that are not there or that would make other samples."""
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        raise Refusal(f"the scheduler {scheduler} has no workers: start some with 'dask worker {scheduler} --nthreads 1'") from None
    try:
        found = set(client.run(what_runs_here).values())
    except Exception as error:  # whatever comes back from a machine without this package
        raise Refusal(f"the workers of {scheduler} cannot run dcrb_ros ({error}): install version {__version__} there") from None
    for version, model in sorted(found - {what_runs_here()}):
        raise Refusal(
            f"the workers of {scheduler} run dcrb_ros {version} with model {model}, this is {__version__} with {model_fingerprint()}: "
            "install the same on all machines"
        )


def what_runs_here() -> tuple[str, str]:
    """Return version and model of this process."""
    return __version__, model_fingerprint()


def _require_dask() -> None:
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise Refusal("dcrb sweep needs Dask: pip install dask distributed pandas") from None
