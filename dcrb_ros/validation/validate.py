"""Everything in one go: the runs on all cores, the rows, the report."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from dcrb_ros.runtime.processes import in_processes
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.validation.comparison import Comparison, Runs
from dcrb_ros.validation.faults import fault_comparisons
from dcrb_ros.validation.figures import write_figures
from dcrb_ros.validation.formulation import Agreement, agreement
from dcrb_ros.validation.healthy import healthy_comparisons
from dcrb_ros.validation.report import markdown
from dcrb_ros.validation.runs import BENCH, Run, run_specs, simulate
from dcrb_ros.validation.statics import WINDOWS, formulation_comparisons, freedom_comparisons, frequency_comparison, static_comparisons

REPORT = "report.md"

Progress = Callable[[int, int, str], None]
"""Told how many runs are done, of how many, and which was the last."""


def compare(name: str) -> Agreement:
    """Hold the two solvers against each other on one of `WINDOWS`."""
    setting, window, _ = WINDOWS[name]
    return agreement(load_configuration(BENCH["revolute"], [setting] if setting else []), window)


def run_all(workers: int, progress: Progress) -> tuple[Runs, dict[str, Agreement]]:
    """Run every case and comparison in processes of their own."""
    calls: dict[tuple[str, str], Callable[[], Any]] = {(name, ""): partial(compare, name) for name in WINDOWS}
    calls |= {case.key: partial(simulate, case) for case in run_specs()}
    runs: dict[tuple[str, str], Run] = {}
    agreements: dict[str, Agreement] = {}
    for done, ((name, joint), result) in enumerate(in_processes(calls, workers), start=1):
        if joint:
            runs[name, joint] = result
        else:
            agreements[name] = result
        progress(done, len(calls), f"{name} {joint}".strip())
    return runs, agreements


def table(runs: Runs, agreements: dict[str, Agreement]) -> list[Comparison]:
    """Return every row."""
    rest = [*static_comparisons(), *frequency_comparison(), *freedom_comparisons(), *formulation_comparisons(agreements)]
    return [*rest, *healthy_comparisons(runs), *fault_comparisons(runs)]


def made_folder(folder: Path) -> Path:
    """Make the folder for the report or refuse it: an earlier report may be replaced, nothing else."""
    if folder.exists() and not folder.is_dir():
        raise Refusal(f"{folder} is a file: give the report another folder with -o")
    if folder.exists() and any(folder.iterdir()) and not (folder / REPORT).exists():
        raise Refusal(f"{folder} holds something that is not a report: give another folder with -o")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Refusal(f"{folder} cannot be made: {error.strerror}; give another folder with -o") from None
    return folder


def write_report(folder: Path, rows: Sequence[Comparison], runs: Runs) -> Path:
    """Write the figures and the report into ``folder``; return the report's path."""
    try:
        with tempfile.TemporaryDirectory(dir=folder, prefix=".unfinished-") as unfinished:
            made = Path(unfinished)
            names = write_figures(runs, made)
            (made / REPORT).write_text(markdown(rows, run_specs(), names), encoding="utf-8")
            for name in (*names, REPORT):
                os.replace(made / name, folder / name)
    except OSError as error:
        raise Refusal(f"{folder} cannot be written: {error.strerror}; give another folder with -o") from None
    return folder / REPORT
