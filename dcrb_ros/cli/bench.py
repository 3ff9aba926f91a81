"""`dcrb bench`: simulator and fault detector as ROS nodes, with a live status line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.runtime.refusal import Refusal


def bench(
    config: Annotated[str, typer.Argument(help="A YAML file or a shipped name, such as outer_ring_defect.")],
    duration: Annotated[float, typer.Option(help="Simulated time [s].")] = 10.0,
    time_scale: Annotated[
        float | None, typer.Option(help="Simulated over wall time, 0 for as fast as possible; by default the configuration's.")
    ] = None,
    record: Annotated[Path | None, typer.Option(help="Folder of a recording.")] = None,
    rerun: Annotated[bool, typer.Option("--rerun", help="Open Rerun and show the bench while it runs.")] = False,
    scenario: Annotated[Path | None, typer.Option(help="A timeline of speed, load, faults and sensor in simulated time (YAML).")] = None,
    detector: Annotated[
        Path | None, typer.Option(help="Parameters of the detector (YAML), such as a copy of config/detector.yaml.")
    ] = None,
    settings: Annotated[list[str] | None, typer.Option("--set", help="KEY=VALUE, such as operating.speed=100.0.")] = None,
) -> None:
    """Run the bench: simulator and fault detector as ROS 2 nodes."""
    from dcrb_ros.cli.detect import detector_parameters
    from dcrb_ros.runtime.simulated_time import checked_duration
    from dcrb_ros.settings.files import load_configuration
    from dcrb_ros.simulation.scenario import read_scenario

    seconds = checked_duration(duration)
    extra = [f"time_scale={time_scale!r}"] if time_scale is not None else []
    extra += [f"recording.path={str(record)!r}"] if record else []
    configuration = load_configuration(config, [*(settings or ()), *extra])
    if record and record.exists():
        raise Refusal(f"{record} exists: give another name or remove it, a recording is never overwritten")
    if scenario:
        read_scenario(scenario, configuration)
    judging = detector_parameters(detector)
    from dcrb_ros.nodes.bench import run

    raise typer.Exit(run(config, configuration, judging, seconds, scenario, shown=rerun))
