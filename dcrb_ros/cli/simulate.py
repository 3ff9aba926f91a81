"""`dcrb simulate`: the model without ROS, into a recording."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.refusal import Refusal

LONGEST = 1e6
"""Longest run that is accepted [s]."""


def checked_duration(duration: float) -> float:
    """Return a duration [s] or refuse it."""
    if not (math.isfinite(duration) and 0.0 < duration <= LONGEST):
        raise Refusal(f"--duration {duration} s is outside 0 .. {LONGEST:g} s: give the simulated seconds to run")
    return duration


def simulate(
    config: Annotated[str, typer.Argument(help="A YAML file or a shipped name, such as healthy.")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder of the recording; by default named after CONFIG.")] = None,
    duration: Annotated[float, typer.Option(help="Simulated time [s].")] = 10.0,
    scenario: Annotated[Path | None, typer.Option(help="A timeline of speed, load, faults and sensor in simulated time (YAML).")] = None,
    settings: Annotated[list[str] | None, typer.Option("--set", help="KEY=VALUE, such as operating.speed=100.0.")] = None,
) -> None:
    """Simulate a bearing and write a recording."""
    seconds = checked_duration(duration)
    from dcrb_ros.configuration_file import load_configuration
    from dcrb_ros.scenario import read_scenario

    configuration = load_configuration(config, settings or ())
    events = read_scenario(scenario, configuration) if scenario else []
    path = output or Path(Path(config).stem)
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from dcrb_ros.core import compiled
    from dcrb_ros.simulation import Simulation
    from dcrb_ros.sinks.recorder import Recorder

    console = Console(stderr=True)
    if path.exists():
        raise Refusal(f"{path} exists: give another name with -o or remove it, a recording is never overwritten")
    if not compiled():
        console.print("compiling the kernels (once, about half a minute) ...")
    simulation = Simulation(configuration, events)
    started = time.perf_counter()
    done = 0.0
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.1f} of {task.total:.1f} s simulated"),
        TimeRemainingColumn(),
    )
    with Recorder(path, configuration, simulation.layout) as recorder, Progress(*columns, console=console) as progress:
        task = progress.add_task(path.name, total=seconds)
        try:
            for block in simulation.blocks(seconds):
                recorder.write(block)
                done = block.end_ns * 1e-9
                progress.update(task, completed=done)
        except KeyboardInterrupt:
            console.print(f"stopped at {done:.2f} s; the recording holds what was simulated until then")
    factor = done / (time.perf_counter() - started)
    print(f"{path}: {done:.2f} s simulated, {factor:.2f} x real time")
    print(f"open it with: rerun {recorder.file}   or: dcrb view {path}")
