"""`dcrb sweep`: a labelled data set, on Dask."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from dcrb_ros.runtime.refusal import Refusal

if TYPE_CHECKING:
    from distributed import Client

    from dcrb_ros.sweep.data_set import DataSet
    from dcrb_ros.sweep.plan import Plan
    from dcrb_ros.sweep.table import Tally


def sweep(
    sweep: Annotated[str, typer.Argument(help="A YAML file or a shipped name, such as two_hundred.")],
    output: Annotated[str | None, typer.Option("-o", "--output", help="Folder of the data set, or an address that fsspec knows.")] = None,
    scheduler: Annotated[str | None, typer.Option(help="Address of a Dask scheduler, tcp://...; this machine's cores without.")] = None,
    workers: Annotated[int | None, typer.Option(min=1, max=1024, help="Worker processes on this machine; one per core without.")] = None,
    memory: Annotated[str, typer.Option(help="Memory of each worker, such as 2GB.")] = "auto",
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Counts, time and room from a short calibration; nothing is written.")] = False,
) -> None:
    """Make a labelled data set: many runs, their labels, splits and a data card; a second call does what is missing."""
    if output is None and not dry_run:
        raise Refusal("Missing option '-o': give the folder of the data set, or --dry-run to see what it would take")
    if scheduler is not None and (workers is not None or memory != "auto"):
        raise Refusal("--scheduler brings its own workers: leave out --workers and --memory")
    _require_fsspec()
    from dcrb_ros.runtime.processes import cores
    from dcrb_ros.sweep.loader import read_sweep
    from dcrb_ros.sweep.plan import Plan

    plan = Plan(read_sweep(sweep))
    if plan.conditions < 3:
        missing = "validation split" if plan.conditions == 2 else "validation and no test split"
        typer.echo(f"{plan.conditions} condition of the bearing gives no {missing}: vary speed or load for more", err=True)
    if dry_run:
        _estimate(plan, workers or cores())
        return
    from dcrb_ros.sweep.data_set import DataSet
    from dcrb_ros.sweep.store import Store

    store = Store(str(output))
    if store.address.startswith("memory:"):
        raise Refusal(f"{store.address} would be gone with this command: give a folder, or an address that all workers share")
    data_set = DataSet(plan, store)
    if scheduler is None:
        _compile()
    with _client(scheduler, workers, memory) as client:
        tally = _made(data_set, client)
    _tell(tally, store.address)


def _require_fsspec() -> None:
    try:
        import fsspec  # noqa: F401
    except ImportError:
        raise Refusal("dcrb sweep needs Dask and fsspec: pip install dask distributed pandas") from None


def _compile() -> None:
    """Compile once, before every worker would."""
    from dcrb_ros.core import compiled
    from dcrb_ros.settings.configuration import Configuration
    from dcrb_ros.simulation.loop import Simulation

    if not compiled():
        typer.echo("compiling the kernels (once, about half a minute) ...", err=True)
        next(Simulation(Configuration()).blocks(0.001))


@contextmanager
def _client(scheduler: str | None, workers: int | None, memory: str) -> Iterator[Client]:
    from dcrb_ros.sweep.dispatch import dashboard_there, workers_here, workers_of

    with workers_of(scheduler) if scheduler else workers_here(workers, memory) as client:
        here = client.dashboard_link if scheduler or dashboard_there() else "none (pip install bokeh gives one)"
        typer.echo(f"{len(client.nthreads())} workers, dashboard: {here}", err=True)
        yield client


def _made(data_set: DataSet, client: Client) -> Tally:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    total, seen = data_set.plan.sweep.count, Counter[str]()
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("runs", total=total, completed=len(data_set.done))

        def progress(outcomes: Counter[str]) -> None:
            seen.update(outcomes)
            bad = ", ".join(f"{count} {status}" for status, count in sorted(seen.items()) if status != "done")
            bar.update(task, advance=sum(outcomes.values()), description=f"runs ({bad})" if bad else "runs")

        try:
            tally = data_set.make(client, progress)
        except KeyboardInterrupt:
            reached = sum(1 for _ in data_set.store.names("labels"))
            bar.console.print(f"stopped after {reached} of {total} runs; the same command goes on from there")
            raise
        bar.update(task, total=sum(tally.statuses.values()), completed=sum(tally.statuses.values()))
        return tally


def _tell(tally: Tally, address: str) -> None:
    """Print what became of the sweep; end with status 1 if nothing did."""
    done, counts = tally.statuses["done"], ", ".join(f"{count} {status}" for status, count in sorted(tally.statuses.items()))
    for reason, count in tally.reasons.most_common(3):
        typer.echo(f"{count} x {reason}", err=True)
    if not done:
        raise RuntimeError(f"no run of {address} was done ({counts}): the reasons stand above and in labels.parquet")
    splits = {split: sum(count for (of, _), count in tally.classes.items() if of == split) for split in ("train", "validation", "test")}
    shares = ", ".join(f"{count} {split}" for split, count in splits.items() if count)
    print(f"{address}: {counts}; {shares}; {tally.seconds:.6g} s recorded")
    print(f"load it with: pandas.read_parquet('{address}/labels.parquet')")


def _estimate(plan: Plan, workers: int) -> None:
    from dcrb_ros.sweep.estimate import estimate

    found = estimate(plan)
    print(f"{found.runs} runs of {found.duration:g} s in {plan.conditions} conditions")
    print("| split | case | runs |\n|---|---|---|")
    for (split, case), count in sorted(found.counts.items()):
        print(f"| {split} | {case} | {count} |")
    seconds, room = found.seconds(workers), found.room
    print(
        f"about {_span(seconds)} on {workers} workers like this machine's ({found.factor:.1f} x real time each, and {found.start:.2f} s "
        f"before a run) and {room / 1e9:.3g} GB"
    )
    if found.refused:
        print(f"{found.refused} runs of the calibration were refused or failed")


def _span(seconds: float) -> str:
    """Return a time [s] in the unit that suits it."""
    unit, size = next(((unit, size) for unit, size in (("h", 3600.0), ("min", 60.0)) if seconds >= 2.0 * size), ("s", 1.0))
    return f"{seconds / size:.1f} {unit}"
