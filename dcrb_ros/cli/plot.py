"""`dcrb plot`: the waveform and the squared envelope spectrum of a recording as a picture."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dcrb_ros.cli.options import Bag, Force, warn_of_digests
from dcrb_ros.cli.output_file import PICTURES, check_file
from dcrb_ros.schema.numbers import duration_within
from dcrb_ros.schema.refusal import Refusal

if TYPE_CHECKING:
    from dcrb_ros.bearing.waveform import Waveform

LONGEST = 60.0
"""Longest stretch that is plotted [s]."""


def check_gaps(waveform: Waveform) -> None:
    """Refuse a waveform that lacks samples, which has no spectrum; the longest stretch without a gap is proposed."""
    from itertools import pairwise

    import numpy as np

    jumps = np.flatnonzero(np.diff(waveform.index) != 1) + 1
    if not len(jumps):
        return
    borders = [0, *jumps.tolist(), len(waveform)]
    first, after = max(pairwise(borders), key=lambda piece: piece[1] - piece[0])
    rate = waveform.sampling_rate
    raise Refusal(
        f"samples are missing after {waveform.time[jumps[0] - 1]:.4f} s, so there is no spectrum: plot a stretch without gaps, such as "
        f"--start {waveform.index[first] / rate:.6f} --duration {(after - first) / rate:.6f}"
    )


def plot(
    bag: Bag,
    output: Annotated[Path, typer.Option("-o", "--output", help="New picture to write (.png, .svg or .pdf).")],
    start: Annotated[float | None, typer.Option(help="Simulated time of the first sample [s]. Default: the beginning.")] = None,
    duration: Annotated[float, typer.Option(help="Length of the stretch [s], above 0 and up to 60.")] = 10.0,
    order: Annotated[bool, typer.Option("--order/--frequency", help="Spectrum over orders of the shaft, or over frequency [Hz].")] = True,
    force: Force = False,
) -> None:
    """Plot the waveform and the squared envelope spectrum of a recording with the fault lines, and its temperatures if it has any.

    Example: dcrb plot bags/outer_ring_defect -o picture.png --duration 2
    """
    check_file("-o", output, PICTURES, force=force)
    duration_within("--duration", duration, LONGEST, "give the length of the stretch to plot")
    if start is not None and not (math.isfinite(start) and start >= 0.0):
        raise Refusal(f"--start {start:g} s is out of range: give a simulated time of 0 s or later")
    from dcrb_ros.plots.overview import write_overview
    from dcrb_ros.recordings.reader import Recording
    from dcrb_ros.recordings.vehicle_folder import title_of

    recording = Recording(bag)
    begin = next(recording.pieces()).first_index / recording.sampling_rate if start is None else start
    waveform = recording.waveform(begin, begin + duration)
    check_gaps(waveform)
    readings = recording.temperatures().between(begin, begin + duration)
    over_orders = write_overview(waveform, output, title=title_of(recording.path), order=order, readings=readings)
    warn_of_digests(bag, recording)
    if not recording.complete:
        typer.echo(f"dcrb: {bag} is truncated or damaged; its readable part was drawn", err=True)
    if order and not over_orders:
        reason = "the shaft does not turn far enough in one direction for orders" if waveform.tracked else "the recording has no speed"
        typer.echo(f"the spectrum is over frequency, because {reason}", err=True)
    print(f"{output}: {waveform.duration:.2f} s of {bag} from {waveform.time[0]:.2f} s on")
