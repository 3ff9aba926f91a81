"""``dcrb view``: a recording in Rerun."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated, Optional

import typer

from dcrb_ros.refusal import Refusal


def view(
    bag: Annotated[Path, typer.Argument(help="Recording: a folder with metadata.yaml, or one .mcap file.")],
    save: Annotated[Optional[Path], typer.Option(help="Write a Rerun file (.rrd) instead of opening the viewer.")] = None,
    screenshot: Annotated[Optional[Path], typer.Option(help="Write a picture (.png) of the viewer instead of opening it.")] = None,
    web: Annotated[bool, typer.Option("--web", help="Open the viewer in the browser.")] = False,
) -> None:
    """Show a recording in Rerun: waveform, envelope spectrum and the moving bearing."""
    _check_output(save, ".rrd", "--save")
    _check_output(screenshot, ".png", "--screenshot")
    from dcrb_ros.viewer.show import picture_time, show, written
    from dcrb_ros.viewer.window import ViewerFailure

    ...
