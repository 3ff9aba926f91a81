"""`dcrb sweep`: generate a labelled data set on the cores of this machine or on a Dask cluster."""

from __future__ import annotations

from collections import Counter
from contextlib import ExitStack
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dcrb_ros.cli import completion
from dcrb_ros.cli.first_start import announce_compilation, compilation_shown
from dcrb_ros.cli.options import JsonOutput, Quiet, refuse_given, size_text
from dcrb_ros.runtime.optional import installed
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted
from dcrb_ros.text.json import json_text

if TYPE_CHECKING:
    from dcrb_ros.sweep.data_set import DataSetWriter
    from dcrb_ros.sweep.plan import Plan
    from dcrb_ros.sweep.store import Store
    from dcrb_ros.sweep.table import Tally
    from dcrb_ros.sweep.workers import Workers

SHOWN_FLAWS = 5
"""Damaged runs that are named at most [-]."""
SHOWN_DELAY = 1.3
"""Delay by other programs and the disk from which an estimate states it [-]."""


def sweep(
    context: typer.Context,
    sweep: Annotated[
        str, typer.Argument(help="Sweep: a YAML file or a shipped name, such as two_hundred.", autocompletion=completion.sweeps)
    ],
    output: Annotated[
        str | None, typer.Option("-o", "--output", help="Folder of the data set, or an fsspec address such as s3://bucket/folder.")
    ] = None,
    machine: Annotated[
        str | None,
        typer.Option(
            help="Calibrated machine instead of the sweep's base and path: what dcrb calibrate wrote, with its intervals beside it."
        ),
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, such as tls://10.0.0.1:8786. Default: processes on this machine.")
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
    quiet: Quiet = False,
    as_json: JsonOutput = False,
) -> None:
    """Generate a labelled data set: runs, labels, train, validation and test splits, and a data card.

    If the data set exists and is incomplete, only the missing and damaged runs are simulated. A larger number of points or lives adds runs.

    Example: dcrb sweep two_hundred -o my_data_set --workers 4
    """
    if output is None and not dry_run:
        raise Refusal("Missing option '-o': give the folder of the data set, or --dry-run to estimate time and disk space")
    if scheduler is not None and (workers is not None or memory != "auto"):
        raise Refusal("--scheduler has its own workers: leave out --workers and --memory")
    if dry_run:
        reason = "does not apply to --dry-run, which writes nothing and estimates the time on this machine: leave it out"
        refuse_given(context, reason, "output", "scheduler", "memory")
    installed("fsspec", "dcrb sweep needs fsspec: pip install fsspec")
    from dcrb_ros.runtime.processes import cores
    from dcrb_ros.sweep.division import warnings_of
    from dcrb_ros.sweep.kinds import plan_of
    from dcrb_ros.sweep.loader import read_sweep

    plan = plan_of(read_sweep(sweep, machine))
    if plan.conditions < 3 and not quiet:
        missing = "validation split" if plan.conditions == 2 else "validation or test split"
        typer.echo(f"too few {plan.unit}s ({plan.conditions}) for a {missing}: {plan.remedy} to get more", err=True)
    if not quiet:
        for sentence in warnings_of(plan.shared).values():
            typer.echo(f"warning: {sentence}", err=True)
    announce_compilation(quiet=quiet)
    if dry_run:
        _estimate(plan, workers or cores(), as_json=as_json)
        return
    from dcrb_ros.sweep.store import Store

    store = Store(str(output))
    if store.address.startswith("memory:"):
        raise Refusal(f"{store.address} is deleted when this command ends: give a folder, or an address that all workers can write")
    if scheduler is None:
        from dcrb_ros.sweep.local_workers import local_workers

        with local_workers(workers, memory) as processes:
            tally = _make(plan, store, processes, compile_first=True, quiet=quiet)
    else:
        from dcrb_ros.sweep.cluster import cluster_workers

        with cluster_workers(scheduler) as cluster:
            tally = _make(plan, store, cluster, compile_first=False, quiet=quiet)
    _print_summary(tally, store, plan.sweep.count, quiet=quiet, as_json=as_json)


def _make(plan: Plan, store: Store, workers: Workers, *, compile_first: bool, quiet: bool) -> Tally:
    """Create or continue the data set of a plan; ``compile_first`` compiles the kernels once for all workers of this machine."""
    from dcrb_ros.runtime.terminal import console
    from dcrb_ros.sweep.data_set import open_data_set

    shown = console(stderr=True)
    shown.quiet = quiet
    with ExitStack() as stack:
        with shown.status("checking the finished runs ..."):
            data_set = stack.enter_context(open_data_set(plan, store))
        if not quiet:
            if data_set.extended:
                typer.echo(f"{store.address} is extended: its {len(data_set.done)} finished runs and their splits are kept", err=True)
            _report_flaws(data_set)
            typer.echo(str(workers), err=True)
        if compile_first:
            _compile(quiet=quiet)
        return _generate(data_set, workers, quiet=quiet)


def _compile(*, quiet: bool) -> None:
    """Compile the kernels, so that the workers do not each compile them."""
    from dcrb_ros.core import compiled
    from dcrb_ros.settings.configuration import Configuration
    from dcrb_ros.simulation.loop import Simulation

    if not compiled():
        with compilation_shown(quiet=quiet):
            next(Simulation(Configuration()).blocks(0.001))


def _report_flaws(data_set: DataSetWriter) -> None:
    """Name the files because of which runs are simulated again."""
    reasons = list(data_set.flaws.values())
    for reason in reasons[:SHOWN_FLAWS]:
        typer.echo(f"{reason}: the run is simulated again", err=True)
    if len(reasons) > SHOWN_FLAWS:
        typer.echo(f"damage in {counted(len(reasons) - SHOWN_FLAWS, 'further run')}: simulated again", err=True)


def _generate(data_set: DataSetWriter, workers: Workers, *, quiet: bool) -> Tally:
    from rich.progress import MofNCompleteColumn, TimeRemainingColumn

    from dcrb_ros.runtime.terminal import progress
    from dcrb_ros.sweep.verification import LABELS

    total, seen = data_set.plan.sweep.count, Counter[str]()
    with progress(MofNCompleteColumn(), TimeRemainingColumn(), quiet=quiet) as bar:
        task = bar.add_task("runs", total=total, completed=len(data_set.done))

        def advance(outcomes: Counter[str]) -> None:
            seen.update(outcomes)
            bad = ", ".join(f"{count} {status}" for status, count in sorted(seen.items()) if status != "done")
            bar.update(task, advance=sum(outcomes.values()), description=f"runs ({bad})" if bad else "runs")

        try:
            tally = data_set.make(workers, advance)
        except KeyboardInterrupt:
            if not quiet:
                reached = sum(1 for _ in data_set.store.names(LABELS))
                bar.console.print(f"stopped after {reached} of {counted(total, 'run')}; run the same command again to continue")
            raise
        bar.update(task, total=sum(tally.statuses.values()), completed=sum(tally.statuses.values()))
        return tally


def _print_summary(tally: Tally, store: Store, count: int, *, quiet: bool = False, as_json: bool = False) -> None:
    """Print the outcome of a sweep whose design has a ``count`` of runs, and the line that loads its folder, if it has one here.

    Raises:
        RuntimeError: no run succeeded.
    """
    from dcrb_ros.sweep.schema import SPLITS

    address, different = store.address, sum(tally.statuses.values())
    if different < count and not quiet:
        typer.echo(f"{counted(different, 'different run')} of {count} in the design: equal ones are made once", err=True)
    done, counts = tally.statuses["done"], ", ".join(f"{count} {status}" for status, count in sorted(tally.statuses.items()))
    splits = {split: sum(count for (run_split, _), count in tally.classes.items() if run_split == split) for split in SPLITS}
    if as_json:
        about = {"address": address, "runs": tally.statuses, "splits": splits, "seconds": tally.seconds, "reasons": tally.reasons}
        print(json_text(about))
    else:
        for reason, count in tally.reasons.most_common(3):
            typer.echo(f"{count} x {reason}", err=True)
    if not done:
        where = "are in 'reasons'" if as_json else "are given above"
        raise RuntimeError(f"no run of {address} succeeded ({counts}): the reasons {where} and in labels.parquet")
    if not as_json:
        filled = {split: count for split, count in splits.items() if count}
        shares = ", ".join(f"{count} {split}" for split, count in filled.items())
        print(f"{address}: {counts}; {shares}; {tally.seconds:.6g} s recorded")
        if store.folder is not None and not quiet:
            print(f"load it with: dcrb_ros.DataSet({str(store.folder)!r}).windows({next(iter(filled), SPLITS[0])!r})")


def _estimate(plan: Plan, workers: int, *, as_json: bool) -> None:
    """Print the estimated cost of a sweep."""
    from dcrb_ros.runtime.processes import cores
    from dcrb_ros.sweep.estimate import estimate
    from dcrb_ros.text.markdown import table

    cost, heads = estimate(plan), ("split", "case", "runs")
    cases = [(split, case, count) for (split, case), count in sorted(cost.counts.items())]
    if as_json:
        about: dict[str, Any] = {
            "runs": cost.runs,
            "duration": cost.duration,
            "conditions": plan.conditions,
            "cases": [dict(zip(heads, case, strict=True)) for case in cases],
            "workers": workers,
            "seconds": cost.seconds(workers),
            "seconds_now": cost.seconds(workers) * cost.delay,
            "bytes": cost.size,
            "refused": cost.refused,
        }
        print(json_text(about))
        return
    print(f"{counted(cost.runs, 'run')} of {cost.duration:g} s in {counted(plan.conditions, plan.unit)}")
    print(table(heads, cases))
    idle, cores_used = cost.seconds(workers), counted(min(workers, cores()), "idle core")
    print(
        f"about {_span(idle)} on {counted(workers, 'worker')} of this machine with {cores_used} ({cost.factor:.1f} x real time each, plus "
        f"{cost.worker_start:.1f} s per worker and {cost.start:.2f} s per run) and {size_text(cost.size)} of disk space"
    )
    if cost.delay > SHOWN_DELAY:
        print(
            f"about {_span(idle * cost.delay)} as long as the machine is as busy as now: other programs and the disk made the short runs "
            f"{cost.delay:.1f} times as long"
        )
    if cost.refused:
        print(f"{cost.refused} of the short runs were refused or failed")


def _span(seconds: float) -> str:
    """Return a time [s] as text in seconds, minutes or hours."""
    unit, size = next(((unit, size) for unit, size in (("h", 3600.0), ("min", 60.0)) if seconds >= 2.0 * size), ("s", 1.0))
    return f"{seconds / size:.1f} {unit}"
