"""`dcrb export` and `dcrb import`: convert between recordings and files of other tools."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli.options import Bag, Force, each_once, warn_of_digests
from dcrb_ros.cli.output_file import check_file, check_free, replacing
from dcrb_ros.runtime.terminal import stages
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted
from dcrb_ros.text.writing import check_new_folder


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
    from dcrb_ros.exchange.files import WRITERS
    from dcrb_ros.recordings.reader import Recording

    check_file("-o", output, tuple(WRITERS), force=force)
    check_file("-o", description_of(output), force=force)
    recording, notes = Recording(bag), list[str]()
    with stages() as show:
        described = exported(recording, output, notes=notes, show=show)
    warn_of_digests(bag, recording)
    for sentence in [*recording.damage, *notes]:
        typer.echo(f"dcrb: {sentence}", err=True)
    print(f"{output}, described by {described}")


def import_(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="FILE...", help="Files with the waveform, in order of time: .csv, .wav, .mat, .npz or .parquet."),
    ] = None,
    about: Annotated[
        str,
        typer.Option(help="YAML description of the files, or the name of a public data set: channels, unit, sampling_rate, bearing."),
    ] = "",
    output: Annotated[Path | None, typer.Option("-o", "--output", help="New folder of the recording.")] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            callback=each_once,
            help="Change the description, KEY=VALUE, such as speed_rpm=1797; null removes a key; may be repeated.",
        ),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the public data sets whose descriptions are shipped, and end.")] = False,
    show: Annotated[str, typer.Option(help="Print the description of a public data set, to be copied and changed, and end.")] = "",
    force: Force = False,
) -> None:
    """Convert a waveform measured elsewhere to a recording that can be used like a simulated recording.

    Example: dcrb import 97.mat --about cwru-48k -o cwru_97
    """
    from dcrb_ros.exchange.importing import WaveformImport
    from dcrb_ros.exchange.plausibility import implausible, summary
    from dcrb_ros.settings.shipped import find_shipped

    if list_ or show:
        if (list_ and show) or files or about or output or settings or force:
            raise Refusal("--list and --show print descriptions and import nothing: leave out everything else")
        print("\n".join(_listed()) if list_ else find_shipped("description", show).read_text(encoding="utf-8"), end="\n" if list_ else "")
        return
    if not files or not about or output is None:
        missing = "FILE" if not files else "--about" if not about else "-o"
        raise Refusal(f"{missing} is missing: dcrb import FILE --about ABOUT.yaml -o RECORDING, or dcrb import --list")
    check_free("-o", output, force=force)
    check_new_folder(output)
    with stages() as progress:
        progress(f"reading {counted(len(files), 'file')}", 0, 0)
        waveform = WaveformImport(files, find_shipped("description", about), settings or ())
        with replacing("-o", output, force=force):
            samples = waveform.write(output, progress)
    print(f"{output}: {samples} samples, {samples / waveform.measured_rate:.3f} s at {waveform.measured_rate:g} Hz")
    print(summary(waveform))
    for sentence in implausible(waveform):
        typer.echo(f"dcrb: warning: {sentence}", err=True)
    for remark in waveform.remarks():
        print(remark)


def _listed() -> Iterator[str]:
    """Yield a line for each public data set: its name, its title and its address."""
    from dcrb_ros.settings.shipped import shipped
    from dcrb_ros.text.yaml import read_yaml

    sets = shipped("description")
    width = max(map(len, sets), default=0)
    for name, path in sets.items():
        source = read_yaml(path)["source"]
        yield f"{name:{width}}  {source['title']}; {source['where']}"
