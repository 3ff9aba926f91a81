"""`dcrb sweep`: generate a labelled data set with Dask."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from dcrb_ros.cli.options import announce_compilation
from dcrb_ros.schema.refusal import Refusal

if TYPE_CHECKING:
    from distributed import Client

    from dcrb_ros.sweep.data_set import DataSet
    from dcrb_ros.sweep.plan import Plan
    from dcrb_ros.sweep.table import Tally


def sweep(
    sweep: Annotated[str, typer.Argument(help="Sweep: a YAML file or a shipped name, such as two_hundred.")],
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Folder of the data set, or an fsspec address such as s3://bucket/folder.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, such as tcp://10.0.0.1:8786. Default: workers on this machine.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, max=1024, help="Number of worker processes on this machine. Default: one per core.")
    ] = None,
    memory: Annotated[
        str, typer.Option(help="Memory limit of each worker, such as 2GB; auto gives every worker an equal share of the machine's.")
    ] = "auto",
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Print run counts, time and disk space, estimated from a few short runs; write nothing.")
    ] = False,
) -> None:
    """Generate a labelled data set: runs, labels, train, validation and test splits, and a data card.

    If the data set exists and is incomplete, only the missing runs are simulated.

    Example: dcrb sweep two_hundred -o my_data_set --workers 4
    """
    if output is None and not dry_run:
        raise Refusal("Missing option '-o': give the folder of the data set, or --dry-run to estimate time and disk space")
    if scheduler is not None and (workers is not None or memory != "auto"):
        raise Refusal("--scheduler has its own workers: leave out --workers and --memory")
    _require_fsspec()
    from dcrb_ros.runtime.processes import cores
    from dcrb_ros.sweep.loader import read_sweep
    from dcrb_ros.sweep.plan import Plan

    plan = Plan(read_sweep(sweep))
    if plan.conditions < 3:
        missing = "validation split" if plan.conditions == 2 else "validation or test split"
        typer.echo(f"too few bearing conditions ({plan.conditions}) for a {missing}: vary speed or load to get more", err=True)
    if dry_run:
        _estimate(plan, workers or cores())
        return
    from dcrb_ros.sweep.data_set import DataSet
    from dcrb_ros.sweep.store import Store

    store = Store(str(output))
    if store.address.startswith("memory:"):
        raise Refusal(f"{store.address} is deleted when this command ends: give a folder, or an address that all workers can write")
    data_set = DataSet(plan, store)
    if scheduler is None:
        _compile()
    with _client(scheduler, workers, memory) as client:
        tally = _generate(data_set, client)
    _print_summary(tally, store.address)


def _require_fsspec() -> None:
    try:
        import fsspec  # noqa: F401
    except ImportError:
        raise Refusal("dcrb sweep needs Dask and fsspec: pip install dask distributed pandas") from None


def _compile() -> None:
    """Compile the kernels once, so that the workers do not each compile them."""
    from dcrb_ros.core import compiled
    from dcrb_ros.settings.configuration import Configuration
    from dcrb_ros.simulation.loop import Simulation

    announce_compilation()
    if not compiled():
        next(Simulation(Configuration()).blocks(0.001))


@contextmanager
def _client(scheduler: str | None, workers: int | None, memory: str) -> Iterator[Client]:
    from dcrb_ros.sweep.dispatch import cluster_workers, dashboard_available, local_workers

    with cluster_workers(scheduler) if scheduler else local_workers(workers, memory) as client:
        dashboard = client.dashboard_link if scheduler or dashboard_available() else "none (requires bokeh: pip install bokeh)"
        typer.echo(f"{len(client.nthreads())} workers, dashboard: {dashboard}", err=True)
        yield client


def _generate(data_set: DataSet, client: Client) -> Tally:
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
            bar.console.print(f"stopped after {reached} of {total} runs; run the same command again to continue")
            raise
        bar.update(task, total=sum(tally.statuses.values()), completed=sum(tally.statuses.values()))
        return tally


def _print_summary(tally: Tally, address: str) -> None:
    """Print the outcome of the sweep.

    Raises:
        RuntimeError: no run succeeded.
    """
    done, counts = tally.statuses["done"], ", ".join(f"{count} {status}" for status, count in sorted(tally.statuses.items()))
    for reason, count in tally.reasons.most_common(3):
        typer.echo(f"{count} x {reason}", err=True)
    if not done:
        raise RuntimeError(f"no run of {address} succeeded ({counts}): the reasons are given above and in labels.parquet")
    splits = {split: sum(count for (of, _), count in tally.classes.items() if of == split) for split in ("train", "validation", "test")}
    shares = ", ".join(f"{count} {split}" for split, count in splits.items() if count)
    print(f"{address}: {counts}; {shares}; {tally.seconds:.6g} s recorded")
    print(f"load it with: pandas.read_parquet('{address}/labels.parquet')")


def _estimate(plan: Plan, workers: int) -> None:
    from dcrb_ros.sweep.estimate import estimate

    cost = estimate(plan)
    print(f"{cost.runs} runs of {cost.duration:g} s in {plan.conditions} conditions")
    print("| split | case | runs |\n|---|---|---|")
    for (split, case), count in sorted(cost.counts.items()):
        print(f"| {split} | {case} | {count} |")
    print(
        f"about {_span(cost.seconds(workers))} on {workers} workers of this machine ({cost.factor:.1f} x real time each, plus "
        f"{cost.start:.2f} s per run) and {cost.size / 1e9:.3g} GB"
    )
    if cost.refused:
        print(f"{cost.refused} of the short runs were refused or failed")


def _span(seconds: float) -> str:
    """Return a time [s] as text in seconds, minutes or hours."""
    unit, size = next(((unit, size) for unit, size in (("h", 3600.0), ("min", 60.0)) if seconds >= 2.0 * size), ("s", 1.0))
    return f"{seconds / size:.1f} {unit}"
