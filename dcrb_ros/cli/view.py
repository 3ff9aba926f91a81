"""`dcrb view`: a recording in Rerun."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def view(
    bag: Annotated[Path, typer.Argument(help="Recording: the folder, or one .mcap file.")],
    save: Annotated[Path | None, typer.Option(help="Write a Rerun file (.rrd) instead of opening the viewer.")] = None,
    screenshot: Annotated[Path | None, typer.Option(help="Write a picture of the viewer (.png) instead of opening it.")] = None,
    web: Annotated[bool, typer.Option("--web", help="Open the viewer in the browser.")] = False,
) -> None:
    """Show a recording in Rerun: waveform, envelope spectrum and the moving bearing."""
    from dcrb_ros.viewer.show import view_recording

    content, complete, status = view_recording(bag, save=save, screenshot=screenshot, web=web)
    if not complete:
        seconds = (content.end_ns - content.start_ns) / 1e9
        typer.echo(f"dcrb: {bag} is cut off; the {seconds:.2f} s that can be read were shown", err=True)
    for path in (save, screenshot):
        if path is not None:
            typer.echo(str(path))
    if status:
        raise typer.Exit(1)
