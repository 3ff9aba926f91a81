"""`dcrb simulate`: simulate without ROS and write a recording."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dcrb_ros.cli.options import Duration, Scenario, Settings, announce_compilation
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.simulated_time import checked_duration

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration
    from dcrb_ros.simulation.loop import Simulation
    from dcrb_ros.stream.block import Block


def simulate(
    config: Annotated[str | None, typer.Argument(help="Configuration: a YAML file or a shipped name, such as healthy.")] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="New folder of the recording. Default: the name of the configuration.")
    ] = None,
    duration: Duration = 10.0,
    scenario: Scenario = None,
    settings: Settings = None,
    source: Annotated[
        Path | None,
        typer.Option("--from", help="Simulate this recording again with its configuration, seed and commands, and compare the samples."),
    ] = None,
) -> None:
    """Simulate a bearing without ROS and write a recording, or simulate an existing recording again.

    Example: dcrb simulate inner_ring_defect -o my_recording --duration 5 --set operating.load=60000.0
    """
    if source is not None:
        if config or settings or scenario:
            raise Refusal("--from reads configuration and scenario from the recording: leave out CONFIG, --set and --scenario")
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
    """Simulate a recording again and compare the samples; write them to a new recording if ``output`` is given."""
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
    scenario = recording.manifest.get("scenario")
    simulation = _started(reproduction.configuration, scenario, f"{source}: scenario")
    with ExitStack() as stack:
        write: Callable[[Block], None] | None = None
        if output is not None:
            write = stack.enter_context(Recorder(output, reproduction.configuration, simulation.bodies, scenario=scenario)).write
        done, factor = _run(source.name, reproduction.blocks(simulation), reproduction.duration, write)
    reproduction.check()
    samples = reproduction.samples
    print(f"{source}: {done:.2f} s simulated, {factor:.2f} x real time; the same {samples.count} samples, sha256 {samples.sha256[:16]}")


def _refuse_existing(path: Path) -> None:
    if path.exists():
        raise Refusal(f"{path} exists: give another name with -o or remove it; recordings are never overwritten")


def _started(configuration: Configuration, story: Mapping[str, Any] | None, source: str) -> Simulation:
    from dcrb_ros.simulation.loop import Simulation
    from dcrb_ros.simulation.scenario import scheduled_changes

    events = scheduled_changes(story, configuration, source) if story else []
    announce_compilation()
    return Simulation(configuration, events)


def _run(name: str, blocks: Iterable[Block], seconds: float, write: Callable[[Block], None] | None) -> tuple[float, float]:
    """Write blocks and show the progress; return the simulated time [s] and the real-time factor [-]."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from dcrb_ros.runtime.prefetch import WRITING_DEPTH, prefetch

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
            for block in prefetch(iter(blocks), depth=WRITING_DEPTH):
                if write is not None:
                    write(block)
                done = block.end_ns * 1e-9
                progress.update(task, completed=done)
        except KeyboardInterrupt:
            if write is None:
                raise
            console.print(f"stopped at {done:.2f} s; the recording ends there")
    return done, done / (time.perf_counter() - started)
