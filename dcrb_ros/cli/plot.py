"""`dcrb plot`: the waveform and the squared envelope spectrum of a recording as a picture."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli.options import Bag
from dcrb_ros.cli.output_file import PICTURES, check_output
from dcrb_ros.schema.numbers import duration_within
from dcrb_ros.schema.refusal import Refusal

LONGEST = 60.0
"""Longest stretch that is plotted [s]."""


def plot(
    bag: Bag,
    output: Annotated[Path, typer.Option("-o", "--output", help="Picture to write (.png, .svg, .pdf); it replaces one of that name.")],
    start: Annotated[float | None, typer.Option(help="Simulated time of the first sample in seconds; by default the beginning.")] = None,
    duration: Annotated[float, typer.Option(help="Length of the stretch in seconds, at most 60.")] = 10.0,
    order: Annotated[bool, typer.Option("--order/--frequency", help="Spectrum over orders of the shaft, or over frequency in Hz.")] = True,
) -> None:
    """Plot the waveform and the squared envelope spectrum of a recording with the fault lines.

    Example: dcrb plot bags/outer_ring_defect -o picture.png --duration 2
    """
    check_output("--output", output, PICTURES)
    duration_within("--duration", duration, LONGEST, "give the length of the stretch to plot")
    if start is not None and not (math.isfinite(start) and start >= 0.0):
        raise Refusal(f"--start {start} s is not a simulated time from 0 s up")
    from dcrb_ros.plots.overview import write_overview
    from dcrb_ros.recordings.reader import Recording

    recording = Recording(bag)
    begin = next(recording.pieces()).first_index / recording.sampling_rate if start is None else start
    waveform = recording.waveform(begin, begin + duration)
    write_overview(waveform, output, title=recording.path.resolve().stem, order=order)
    print(f"{output}: {waveform.duration:.2f} s of {bag} from {waveform.time[0]:.2f} s on")
