"""`dcrb collect`: a data set of measured recordings with the schema of a sweep's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated
from warnings import catch_warnings, simplefilter

import typer

from dcrb_ros.runtime.terminal import stages
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted
from dcrb_ros.text.files import checked_path

READING = "recordings"
"""Stage of the progress."""


def collect(
    table: Annotated[Path, typer.Argument(metavar="LIST.csv", help="CSV file with the columns file and fault, and others if known.")],
    address: Annotated[str, typer.Option("-o", "--output", help="New folder of the data set.")],
    about: Annotated[str, typer.Option(help="Description of files without their own: a YAML file or the name of a public data set.")] = "",
    window: Annotated[int, typer.Option(min=16, max=10_000_000, help="Samples in a window.")] = 4096,
    overlap: Annotated[float, typer.Option(min=0.0, max=0.99, help="Overlap of windows as a share of their length.")] = 0.0,
    rate: Annotated[int, typer.Option(min=0, help="Decimate all recordings to this sampling rate in Hz; 0 leaves them.")] = 0,
    title: Annotated[str, typer.Option(help="Name of the data set.")] = "Measured vibration of bearings",
    licence: Annotated[str, typer.Option(help="Licence under which the publisher gives the data.")] = "unknown",
) -> None:
    """Make a data set of measured recordings, such as a downloaded public collection, which loads like that of a sweep.

    Example: dcrb collect files.csv --about cwru-12k -o measured
    """
    from dcrb_ros.exchange.description import LOWEST_RATE
    from dcrb_ros.exchange.run_list import listed_runs, read_list
    from dcrb_ros.sweep.measured_set import MeasuredRun, RunNames, write_measured_set
    from dcrb_ros.sweep.reader import DataSet
    from dcrb_ros.sweep.store import local_folder
    from dcrb_ros.sweep.sweep_file import Windows
    from dcrb_ros.sweep.table import LABELS

    if not checked_path(table).is_file():
        raise Refusal(f"there is no list {table}: give a CSV file with the columns file and fault")
    if 0 < rate < LOWEST_RATE:
        raise Refusal(f"--rate {rate} is below {LOWEST_RATE} Hz, the lowest sampling rate: give a higher one, or 0 to leave the rates")
    output = local_folder(address)
    if output.is_file():
        raise Refusal(f"-o {output} is a file: give an empty or a new folder")

    entries, names = read_list(table, about), RunNames()
    for entry in entries:
        try:
            names.add(entry.name, **{name: entry.fields[name] for name in ("fault", "split", "bearing_id") if name in entry.fields})
        except Refusal as refusal:
            raise Refusal(f"{entry.line}: {refusal}") from None

    def runs(show: Callable[[str, int, int], None]) -> Iterator[MeasuredRun]:
        show(READING, 0, len(entries))
        for done, run in enumerate(listed_runs(entries, rate), 1):
            for sentence in run.warnings:
                typer.echo(f"warning: {sentence}", err=True)
            show(READING, done, len(entries))
            yield MeasuredRun(run.name, run.waveform, source=run.source, **run.fields)

    shape = Windows(length=window, overlap=overlap, kind="parquet")
    with stages() as show:
        counts = write_measured_set(runs(show), output, title=title, licence=licence, windows=shape)
    with catch_warnings(record=True) as warned:
        simplefilter("always")
        DataSet(output)  # reads what was written, and compares it with its hashes
    from pyarrow import parquet

    numbers = parquet.read_table(output / LABELS, columns=["windows"])["windows"].to_pylist()
    if without := numbers.count(0):
        typer.echo(f"warning: {without} of {len(numbers)} recordings have no {window} samples without a gap, and thus no window", err=True)
    for warning in warned:
        typer.echo(f"warning: {warning.message}", err=True)
    shares = ", ".join(f"{count} {fault} in {split}" for (split, fault), count in sorted(counts.items()))
    print(f"{output}: {counted(sum(counts.values()), 'recording')}, {shares}")
