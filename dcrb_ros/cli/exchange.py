"""`dcrb export` and `dcrb import`: waveforms out of recordings and into them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def export(
    bag: Annotated[Path, typer.Argument(help="Folder of a recording or an .mcap file.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="File to write: .npz, .csv, .mat, .wav or .parquet.")],
) -> None:
    """Write a recording's waveform for other tools, with a description beside it."""
    from dcrb_ros.exchange.export import export as exported
    from dcrb_ros.recordings.reader import Recording

    recording = Recording(bag)
    beside = exported(recording, output)
    for words in recording.damage:
        typer.echo(f"dcrb: {words}", err=True)
    print(f"{output}, described by {beside}")


def import_(
    file: Annotated[Path, typer.Argument(help="Waveform: .csv, .wav, .mat, .npz or .parquet.")],
    about: Annotated[Path, typer.Option("--about", help="YAML file: channels, unit, sampling_rate, speed, bearing or orders.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the recording.")],
) -> None:
    """Make a recording of a foreign waveform, which the detector takes like one of the bench."""
    from dcrb_ros.exchange.importing import Import

    found = Import(file, about)
    samples = found.write(output)
    print(f"{output}: {samples} samples, {samples / found.rate:.3f} s at {found.rate} Hz")
