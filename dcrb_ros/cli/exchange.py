"""`dcrb export` and `dcrb import`: convert between recordings and files of other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli.options import Bag, Force
from dcrb_ros.cli.output_file import replacing


def export(
    bag: Bag,
    output: Annotated[Path, typer.Option("-o", "--output", help="New file to write: .npz, .csv, .mat, .wav or .parquet.")],
    force: Force = False,
) -> None:
    """Write a recording's waveform to a file for other tools, and its description beside it, such as healthy.csv.yaml.

    Example: dcrb export bags/healthy -o healthy.csv
    """
    from dcrb_ros.exchange.export import description_of
    from dcrb_ros.exchange.export import export as exported
    from dcrb_ros.recordings.reader import Recording

    recording = Recording(bag)
    with replacing("-o", output, force=force, source=bag), replacing("-o", description_of(output), force=force):
        beside = exported(recording, output)
    for damage in recording.damage:
        typer.echo(f"dcrb: {damage}", err=True)
    print(f"{output}, described by {beside}")


def import_(
    file: Annotated[Path, typer.Argument(help="File with the waveform: .csv, .wav, .mat, .npz or .parquet.")],
    about: Annotated[
        Path,
        typer.Option("--about", help="YAML description of the file: channels, unit, sampling_rate, speed, and bearing or orders."),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="New folder of the recording.")],
    force: Force = False,
) -> None:
    """Convert a waveform measured elsewhere to a recording that can be used like a simulated recording.

    Example: dcrb import 97.mat --about 97.yaml -o cwru_97
    """
    from dcrb_ros.exchange.importing import WaveformImport

    waveform = WaveformImport(file, about)
    with replacing("-o", output, force=force):
        samples = waveform.write(output)
    print(f"{output}: {samples} samples, {samples / waveform.rate:.3f} s at {waveform.rate} Hz")
