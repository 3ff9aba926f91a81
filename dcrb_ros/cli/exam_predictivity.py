"""`dcrb exam replica` and `dcrb exam predictivity`: does the order of detectors in an exam carry over to measured recordings?"""

from __future__ import annotations

import shlex
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli import completion
from dcrb_ros.cli.options import Force, JsonOutput, Quiet, Workers, check_speed, refuse_given, worker_count
from dcrb_ros.cli.output_file import PICTURES, check_file, check_outputs
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted
from dcrb_ros.text.json import json_text
from dcrb_ros.text.writing import write_whole

Table = Annotated[Path, typer.Argument(help="Table of measured recordings (recordings.csv); the files are in recordings/ beside it.")]


def replica(
    table: Table,
    output: Annotated[Path, typer.Option("--output", "-o", help="Exam file to write.")],
    seed: Annotated[int, typer.Option(help="Seed of everything that is drawn.")] = 1,
    machines: Annotated[int, typer.Option(help="Simulated machines for each measured one, 1 to 64.")] = 6,
    counterparts: Annotated[int, typer.Option(help="Counterparts of each faulty recording, at most one on each machine.")] = 3,
    longest: Annotated[float, typer.Option(help="Longest part of a recording that is compared [s], 1 to 60.")] = 2.5,
    bench: Annotated[
        str, typer.Option(help="Configuration on which the bearings are scaled.", autocompletion=completion.configurations)
    ] = "ball_bearing_6205",
    without: Annotated[list[str] | None, typer.Option(help="Part to leave out: path, impacts or background; may be repeated.")] = None,
    speed: Annotated[str, typer.Option(help="Column of speeds: lines or documented.")] = "lines",
    force: Force = False,
) -> None:
    """Write an exam of simulated counterparts of measured recordings; no recording is opened.

    Example: dcrb exam replica measured/recordings.csv -o replica.yaml
    """
    from dcrb_ros.cli.first_start import announce_compilation
    from dcrb_ros.exam.replica import ReplicaPlan, replica_tree
    from dcrb_ros.text.yaml import yaml_text

    check_file("--output", output, (".yaml", ".yml"), force=force)
    check_speed(speed)
    announce_compilation()
    plan = ReplicaPlan(seed, machines, counterparts, longest, bench, tuple(without or ()))
    tree = replica_tree(_checked(table), plan, speed)
    write_whole(output, yaml_text(tree))
    command = shlex.join(("dcrb", "exam", "predictivity", str(table), "--replica", str(output), "--detectors", "FOLDER"))
    print(f"{output}: {counted(len(tree['scenarios']), 'scenario')}; compare detectors on it with {command}")


def predictivity(
    context: typer.Context,
    table: Table,
    replica: Annotated[Path | None, typer.Option(help="Exam of dcrb exam replica. Default: one with the default options.")] = None,
    detectors: Annotated[
        Path | None, typer.Option(help="Folder of detectors, one family in each file, beside the shipped detector.", file_okay=False)
    ] = None,
    entries: Annotated[
        Path | None, typer.Option(help="Folder with entries of the replica, to compare them instead of running detectors.", file_okay=False)
    ] = None,
    measured: Annotated[
        Path | None, typer.Option(help="Folder with entries of the same detectors on the measured recordings.", file_okay=False)
    ] = None,
    recordings: Annotated[
        Path | None, typer.Option(help="Folder that keeps simulated recordings and answers. Default: a folder in the user's cache.")
    ] = None,
    workers: Workers = 0,
    as_json: JsonOutput = False,
    figure: Annotated[Path | None, typer.Option(help="Also draw exam over field to this file (.png, .svg or .pdf).")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Also write the tables as Markdown to this file.")] = None,
    quiet: Quiet = False,
    force: Force = False,
) -> None:
    """Compare the marks of detectors on simulated counterparts with those on measured recordings.

    Exit status 0, 1 if a detector failed and was left out, 2 if the input is invalid.

    Example: dcrb exam predictivity measured/recordings.csv --detectors examples/detectors
    """
    from dcrb_ros.cli.evaluation import progress_of
    from dcrb_ros.cli.first_start import announce_compilation
    from dcrb_ros.exam.detector_families import families_of, shipped_members
    from dcrb_ros.exam.exam_file import Exam, exam_of, read_exam
    from dcrb_ros.exam.leaderboard import read_entries
    from dcrb_ros.exam.limits import Limits
    from dcrb_ros.exam.predictivity_report import as_json as comparison_tree
    from dcrb_ros.exam.predictivity_report import compare_entries, compare_with_field, markdown
    from dcrb_ros.exam.recording_cache import checked_folder, default_folder
    from dcrb_ros.exam.replica import ReplicaPlan, replica_tree

    check_outputs(("--output", output, ()), ("--figure", figure, PICTURES), force=force)
    count, given = worker_count(workers), _checked(table)

    def chosen_exam() -> Exam:
        announce_compilation(quiet=quiet)
        if replica is not None:
            return read_exam(replica)
        return exam_of(replica_tree(given, ReplicaPlan()), f"the replica of {table}")

    if entries is not None and measured is not None:
        refuse_given(context, "runs detectors, but entries are compared: leave it out", "detectors", "recordings", "workers", "quiet")
        comparison = compare_entries(given, chosen_exam(), read_entries(entries), read_entries(measured))
    elif entries is not None or measured is not None:
        raise Refusal("--entries and --measured belong together: give the folders with the entries of both sides")
    else:
        with checked_folder(recordings or default_folder()) as folder:
            members, broken = families_of(detectors, folder) if detectors is not None else ([], [])
            comparison = compare_with_field(
                given,
                chosen_exam,
                [*shipped_members(), *members],
                broken,
                folder,
                Limits(options=False),
                count,
                partial(progress_of, quiet=quiet),
            )
    # First, so that no result is lost if a file cannot be written.
    print(json_text(comparison_tree(comparison)) if as_json else markdown(comparison))
    if output is not None:
        write_whole(output, markdown(comparison))
    if figure is not None:
        from dcrb_ros.exam.predictivity_figure import write_predictivity_figure

        write_predictivity_figure(comparison, figure)
    for one in comparison.broken:
        typer.echo(f"dcrb: {one.name} is left out: {one.reason}", err=True)
    if comparison.broken:
        raise typer.Exit(1)


def _checked(table: Path) -> Path:
    """Return a table that can be read, also of the folder that contains it."""
    from dcrb_ros.exam.measured import TABLE
    from dcrb_ros.exam.replica import table_digest

    path = table / TABLE if table.is_dir() else table
    table_digest(path)
    return path
