"""The whole validation: the runs on all cores, the comparisons, the report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from dcrb_ros.runtime.processes import in_processes
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.temporary import remove_abandoned
from dcrb_ros.text.writing import whole_folder
from dcrb_ros.validation.balls import ball_rows
from dcrb_ros.validation.dry_bench import dry_bench_rows
from dcrb_ros.validation.faults import fault_rows
from dcrb_ros.validation.figures import write_figures
from dcrb_ros.validation.formulation import WINDOWS, Agreement, compare_solvers, formulation_rows
from dcrb_ros.validation.healthy import healthy_rows
from dcrb_ros.validation.kinematics import freedom_rows, frequency_row
from dcrb_ros.validation.oiled_bench import oiled_bench_rows
from dcrb_ros.validation.oiled_runs import OiledRuns, oiled_specs, simulate_oiled
from dcrb_ros.validation.realism_rows import realism_rows
from dcrb_ros.validation.report import markdown
from dcrb_ros.validation.report_row import ReportRow
from dcrb_ros.validation.runs import PaperRuns, run_specs, simulate
from dcrb_ros.validation.shorter_steps import shorter_step_rows
from dcrb_ros.validation.surface_rows import surface_rows
from dcrb_ros.validation.time_integration import energy_rows, order_row

REPORT = "report.md"

Progress = Callable[[int, int, str], None]
"""Called with the number of finished runs, the number of all runs, and the name of the last one."""


class Results(NamedTuple):
    """Everything that the comparisons need."""

    runs: PaperRuns
    agreements: dict[str, Agreement]
    """Deviations between the solvers by window name."""
    oiled: OiledRuns


def run_all(workers: int, progress: Progress) -> Results:
    """Return all runs, and the deviations between the solvers; each is computed in a process of its own."""
    calls: dict[tuple[str, str], Callable[[], Any]] = {(name, ""): partial(compare_solvers, name) for name in WINDOWS}
    calls |= {spec.key: partial(simulate, spec) for spec in run_specs()}
    calls |= {spec.key: partial(simulate_oiled, spec) for spec in oiled_specs()}
    done: dict[tuple[str, str], Any] = {}
    for key, result in in_processes(calls, workers):
        done[key] = result
        progress(len(done), len(calls), " ".join(key).strip())
    return Results(
        {spec.key: done[spec.key] for spec in run_specs()},
        {name: done[name, ""] for name in WINDOWS},
        {spec.name: done[spec.key] for spec in oiled_specs()},
    )


def all_rows(results: Results) -> list[ReportRow]:
    """Return all comparisons in the order of the report."""
    runs, agreements, oiled = results
    return [
        frequency_row(),
        *freedom_rows(),
        *formulation_rows(agreements),
        *healthy_rows(runs),
        *dry_bench_rows(runs["healthy", "pocket"]),
        *fault_rows(runs),
        *energy_rows(),
        order_row(),
        *shorter_step_rows(runs),
        *ball_rows(),
        *oiled_bench_rows(oiled),
        *surface_rows(oiled),
        *realism_rows(oiled),
    ]


def report_folder(folder: Path) -> Path:
    """Create the folder of the report if necessary and return it.

    Raises:
        Refusal: it contains anything but an earlier report, or it cannot be created.
    """
    if folder.exists() and not folder.is_dir():
        raise Refusal(f"{folder} is a file: give the report another folder with -o")
    remove_abandoned(folder)
    if folder.exists() and any(folder.iterdir()) and not (folder / REPORT).exists():
        raise Refusal(f"{folder} contains files that are not a report: give another folder with -o")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Refusal(f"{folder} cannot be created: {error.strerror}; give another folder with -o") from None
    return folder


def write_report(folder: Path, comparisons: Sequence[ReportRow], runs: PaperRuns) -> Path:
    """Write the figures and the report to ``folder``; return the path of the report.

    Raises:
        Refusal: the folder cannot be written.
    """
    with whole_folder(folder, REPORT) as written:
        names = write_figures(runs, written)
        (written / REPORT).write_text(markdown(comparisons, [*run_specs(), *oiled_specs()], names), encoding="utf-8")
    return folder / REPORT
