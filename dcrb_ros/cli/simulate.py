"""`dcrb simulate`: the model without ROS, into a recording."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.runtime.simulated_time import checked_duration

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration
    from dcrb_ros.simulation.block import Block
    from dcrb_ros.simulation.loop import Simulation

PREFETCH_DEPTH = 4
"""Blocks simulated while one is written."""


def simulate(
    config: Annotated[str | None, typer.Argument(help="A YAML file or a shipped name, such as healthy.")] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder of the recording; by default named after CONFIG.")] = None,
    duration: Annotated[float, typer.Option(help="Simulated time [s].")] = 10.0,
    scenario: Annotated[Path | None, typer.Option(help="A timeline of speed, load, faults and sensor in simulated time (YAML).")] = None,
    settings: Annotated[list[str] | None, typer.Option("--set", help="KEY=VALUE, such as operating.speed=100.0.")] = None,
    source: Annotated[
        Path | None,
        typer.Option("--from", help="Repeat this recording: its configuration, seed and commands; compare the samples."),
    ] = None,
) -> None:
    """Simulate a bearing and write a recording, or repeat one."""
    if source is not None:
        if config or settings or scenario:
            raise Refusal("--from takes configuration, settings and scenario from the recording: leave out CONFIG, --set and --scenario")
        reproduce(source, output)
        return
    if config is None:
        raise Refusal("Missing argument 'CONFIG': give a YAML file or a shipped name, such as healthy, or --from BAG")
    seconds = checked_duration(duration)
    from dcrb_ros.settings.files import load_configuration
    from dcrb_ros.simulation.scenario import read_scenario_file, starting_configuration

    story = read_scenario_file(scenario) if scenario else None
    configuration = starting_configuration(story, load_configuration(config, settings or ()), str(scenario))
    path = output or Path(Path(config).stem)
    _refuse_existing(path)
    from dcrb_ros.recordings.recorder import Recorder

    simulation = _started(configuration, story, str(scenario))
    with Recorder(path, configuration, simulation.bodies, scenario=story) as recorder:
        done, factor = _run(path.name, simulation.blocks(seconds), seconds, recorder.write)
    print(f"{path}: {done:.2f} s simulated, {factor:.2f} x real time")
    print(f"open it with: rerun {recorder.file}   or: dcrb view {path}")


def reproduce(source: Path, output: Path | None) -> None:
    """Simulate a recording again and compare the samples; write them to a recording where one is asked for."""
    from dcrb_ros.recordings.reader import Recording
    from dcrb_ros.recordings.recorder import Recorder
    from dcrb_ros.recordings.reproduction import Reproduction

    if output is not None:
        _refuse_existing(output)
    recording = Recording(source)
    reproduction = Reproduction(recording)
    difference = reproduction.difference()
    if difference:
        typer.echo(f"dcrb: {source}: {difference}; the samples may differ", err=True)
    story = recording.manifest.get("scenario")
    simulation = _started(reproduction.configuration, story, f"{source}: scenario")
    with ExitStack() as stack:
        write: Callable[[Block], None] | None = None
        if output is not None:
            write = stack.enter_context(Recorder(output, reproduction.configuration, simulation.bodies, scenario=story)).write
        done, factor = _run(source.name, reproduction.blocks(simulation), reproduction.duration, write)
    reproduction.check()
    samples = reproduction.samples
    print(f"{source}: {done:.2f} s simulated, {factor:.2f} x real time; the same {samples.count} samples, sha256 {samples.sha256[:16]}")


def _refuse_existing(path: Path) -> None:
    if path.exists():
        raise Refusal(f"{path} exists: give another name with -o or remove it, a recording is never overwritten")


def _started(configuration: Configuration, story: Mapping[str, Any] | None, source: str) -> Simulation:
    from dcrb_ros.core import compiled
    from dcrb_ros.simulation.loop import Simulation
    from dcrb_ros.simulation.scenario import scheduled_changes

    events = scheduled_changes(story, configuration, source) if story else []
    if not compiled():
        typer.echo("compiling the kernels (once, about half a minute) ...", err=True)
    return Simulation(configuration, events)


def _run(name: str, blocks: Iterable[Block], seconds: float, write: Callable[[Block], None] | None) -> tuple[float, float]:
    """Write blocks and show how far they are; return the simulated time [s] and how much faster than real time it went."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from dcrb_ros.runtime.prefetch import prefetch

    console = Console(stderr=True)
    started, done = time.perf_counter(), 0.0
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.1f} of {task.total:.1f} s simulated"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as progress:
        task = progress.add_task(name, total=seconds)
        try:
            for block in prefetch(iter(blocks), depth=PREFETCH_DEPTH):
                if write is not None:
                    write(block)
                done = block.end_ns * 1e-9
                progress.update(task, completed=done)
        except KeyboardInterrupt:
            if write is None:
                raise
            console.print(f"stopped at {done:.2f} s; the recording holds what was simulated until then")
    return done, done / (time.perf_counter() - started)
