"""`dcrb replay`: publish a recording on the topics of the bench."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from dcrb_ros.cli.options import Bag, warn_of_digests
from dcrb_ros.schema.refusal import Refusal


def replay(
    bag: Bag,
    rate: Annotated[float, typer.Option(help="Recorded over wall time, 0 to 1000; 1 is the recorded speed, 0 as fast as possible.")] = 1.0,
    loop: Annotated[bool, typer.Option("--loop", help="Start again at the end until stopped.")] = False,
    offset: Annotated[float, typer.Option(help="Recorded time in seconds to skip at the beginning, 0 to 1e6.")] = 0.0,
    clock: Annotated[bool, typer.Option("--clock", help="Also publish the recorded time on /clock.")] = False,
    topics: Annotated[
        str,
        typer.Option(help="Topics to publish, such as 'outer_ring/vibration, diagnosis'. Default: all topics of the simulator."),
    ] = "",
    listeners: Annotated[
        int, typer.Option(help="Subscribers to wait for before the first block, to the waveform or else to the first topic, 0 to 1000.")
    ] = 1,
    wait: Annotated[float, typer.Option(help="Longest time in seconds to wait for them, 0 to 1e4.")] = 3.0,
) -> None:
    """Publish a recording on the topics of the bench, as the simulator did.

    Example: dcrb replay bags/outer_ring_defect --rate 1 --loop
    """
    for name, value in (("--rate", rate), ("--offset", offset), ("--wait", wait)):
        if not math.isfinite(value):
            raise Refusal(f"{name} {value} is not a finite number: give one")
    from dcrb_ros.recordings.replay import Replay, ReplayParameters
    from dcrb_ros.settings.files import validated

    given = {"bag": str(bag), "rate": rate, "loop": loop, "offset": offset, "clock": clock, "topics": topics}
    given |= {"listeners": listeners, "wait": wait}
    parameters = validated(given, ReplayParameters, "replay")
    Replay(parameters).check()  # before ROS is started
    from dcrb_ros.nodes.programs import run

    warn_of_digests(bag, samples=False)  # the node compares them while it reads them
    raise typer.Exit(run("replayer", [], parameters=parameters))
