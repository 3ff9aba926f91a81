"""`dcrb replay`: a recording on the topics of the bench."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.runtime.refusal import Refusal


def replay(
    bag: Annotated[Path, typer.Argument(help="Folder of a recording or an .mcap file.")],
    rate: Annotated[float, typer.Option(help="Recorded over wall time; 0 for as fast as possible.")] = 1.0,
    loop: Annotated[bool, typer.Option("--loop", help="Begin again at the end, for ever.")] = False,
    offset: Annotated[float, typer.Option(help="Recorded time to skip at the beginning [s].")] = 0.0,
    clock: Annotated[bool, typer.Option("--clock", help="Publish /clock, the recorded time.")] = False,
    topics: Annotated[str, typer.Option(help="Topics to replay; by default what the simulator publishes.")] = "",
) -> None:
    """Publish a recording on the topics of the bench, at the recorded pace."""
    for name, value in (("--rate", rate), ("--offset", offset)):
        if not math.isfinite(value):
            raise Refusal(f"{name} {value} is refused: give a number")
    from dcrb_ros.recordings.replay import Replay, ReplayParameters
    from dcrb_ros.settings.files import validated

    given = {"bag": str(bag), "rate": rate, "loop": loop, "offset": offset, "clock": clock, "topics": topics}
    parameters = validated(given, ReplayParameters, "replay")
    Replay(parameters)  # refused before ROS is started
    from dcrb_ros.nodes.programs import run

    raise typer.Exit(run("replayer", [], parameters=parameters))
