"""`dcrb view`: show a recording in Rerun."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli.options import Bag, Force, warn_of_digests
from dcrb_ros.cli.output_file import check_outputs
from dcrb_ros.schema.refusal import Refusal


def view(
    bag: Bag,
    save: Annotated[Path | None, typer.Option(help="Write a new Rerun file (.rrd) instead of opening the viewer.")] = None,
    screenshot: Annotated[Path | None, typer.Option(help="Write a new picture of the viewer (.png) instead of opening it.")] = None,
    web: Annotated[bool, typer.Option("--web", help="Open the viewer in the web browser instead of a window of its own.")] = False,
    force: Force = False,
) -> None:
    """Show a recording in Rerun: waveform, squared envelope spectrum and the moving bearing.

    Example: dcrb view bags/outer_ring_defect --save outer_ring_defect.rrd
    """
    if web and (save is not None or screenshot is not None):
        raise Refusal("--web opens a viewer, and --save and --screenshot write files instead: give one or the other")
    check_outputs(("--save", save, (".rrd",)), ("--screenshot", screenshot, (".png",)), force=force)
    from dcrb_ros.viewer.show import view_recording

    content, complete, status = view_recording(bag, save=save, screenshot=screenshot, web=web)
    warn_of_digests(bag)  # it reads all samples
    if not complete:
        seconds = (content.end_ns - content.start_ns) / 1e9
        typer.echo(f"dcrb: {bag} is truncated or damaged; its readable part of {seconds:.2f} s was shown", err=True)
    for path in (save, screenshot):
        if path is not None:
            typer.echo(str(path))
    if status:
        raise typer.Exit(1)
