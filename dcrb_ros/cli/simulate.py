"""`dcrb simulate`: simulate without ROS and write a recording."""

from __future__ import annotations

import itertools
import shlex
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar

import typer

from dcrb_ros.cli import completion
from dcrb_ros.cli.first_start import compilation_shown
from dcrb_ros.cli.options import (
    Duration,
    Force,
    JsonOutput,
    OptionalConfig,
    Quiet,
    Scenario,
    Settings,
    refuse_given,
    refuse_node_settings,
)
from dcrb_ros.cli.output_file import check_force, replacing
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.simulated_time import checked_duration
from dcrb_ros.text.counts import counted
from dcrb_ros.text.json import json_text

if TYPE_CHECKING:
    from dcrb_ros.recordings.digest import RecordedSamples
    from dcrb_ros.recordings.manifest import Outcome
    from dcrb_ros.recordings.reproduction import RunReproduction
    from dcrb_ros.settings.configuration import Configuration
    from dcrb_ros.stream.block import Block
    from dcrb_ros.vehicle.block import VehicleBlock

Made = TypeVar("Made", "Block", "VehicleBlock")


class Progress(NamedTuple):
    """How far a simulation came, and how fast it was."""

    simulated: float
    """Simulated time [s]."""
    factor: float | None
    """Real-time factor without the compilation of the kernels [-]; None if the run consists of a single block."""

    def __str__(self) -> str:
        return f"{self.simulated:.2f} s simulated" + ("" if self.factor is None else f", {self.factor:.2f} x real time")


def simulate(
    context: typer.Context,
    config: OptionalConfig = None,
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
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Simulate the axle boxes of a vehicle instead: a YAML file or a shipped name, such as bogie.",
            autocompletion=completion.vehicles,
        ),
    ] = None,
    force: Force = False,
    quiet: Quiet = False,
    as_json: JsonOutput = False,
) -> None:
    """Simulate a bearing, or the bearings of a vehicle, without ROS and write a recording, or simulate an existing recording again.

    Example: dcrb simulate inner_ring_defect -o my_recording --duration 5 --set operating.load=60000.0
    """
    if source is not None:
        if config or settings or scenario or vehicle:
            raise Refusal("--from reads configuration and scenario from the recording: leave out CONFIG, --vehicle, --set and --scenario")
        refuse_given(context, "does not apply to --from, which simulates all of the recording: leave it out", "duration")
        check_force("-o", output, force=force)
        reproduce(source, output, force=force, quiet=quiet, as_json=as_json)
        return
    refuse_node_settings(settings)
    if vehicle is not None:
        if config:
            raise Refusal("--vehicle names a file with all boxes: leave out CONFIG")
        seconds = checked_duration(duration)
        simulate_vehicle(vehicle, settings or (), output, seconds, scenario=scenario, force=force, quiet=quiet, as_json=as_json)
        return
    if config is None:
        raise Refusal("Missing argument 'CONFIG': give a YAML file or a shipped name, such as healthy, or --from BAG")
    seconds = checked_duration(duration)
    from dcrb_ros.settings.files import load_configuration
    from dcrb_ros.simulation.scenario import scenario_of_run, scheduled_changes, starting_configuration

    tree = scenario_of_run(scenario, seconds)
    configuration = starting_configuration(tree, load_configuration(config, settings or ()), str(scenario))
    _check(seconds, configuration)
    path = output or Path(Path(config).stem)
    with replacing("-o", path, force=force):
        from dcrb_ros.recordings.recorder import Recorder
        from dcrb_ros.simulation.loop import Simulation

        changes = scheduled_changes(tree, configuration, str(scenario)) if tree is not None else ()
        simulation = Simulation(configuration, changes)
        with Recorder(path, configuration, simulation.bodies, scenario=tree) as recorder:
            progress = _run(path.name, simulation.blocks(seconds), seconds, recorder.write, quiet=quiet, partial=True)
    _print_written(path, progress, {"": recorder.outcome}, quiet=quiet, as_json=as_json)


def _check(seconds: float, *configurations: Configuration) -> None:
    """Refuse a duration that has no sample, as the recording could not be opened, and topics that are not recorded."""
    from dcrb_ros.recordings.recorder import check_topics

    rate = configurations[0].sensor.sampling_rate
    if not round(seconds * rate):
        raise Refusal(f"--duration {seconds:g} s is shorter than a sample at {rate} Hz: give at least {1.0 / rate:.2g} s")
    check_topics(*configurations)


def reproduce(source: Path, output: Path | None, *, force: bool, quiet: bool, as_json: bool) -> None:
    """Simulate a recording again and compare the samples; write them to a new recording if ``output`` is given."""
    with ExitStack() as stack:
        if output is not None:
            stack.enter_context(replacing("-o", output, force=force, source=source))
        reproduction = _reproduction(source)
        if difference := reproduction.difference():
            typer.echo(f"dcrb: {source}: {difference}; the samples may differ", err=True)
        simulation = reproduction.simulation()
        write = None if output is None else stack.enter_context(reproduction.recorder(output, simulation)).write
        progress = _run(source.name, reproduction.blocks(simulation), reproduction.duration, write, quiet=quiet)
    reproduction.check()
    samples = {name: compared.recorded for name, compared in reproduction.compared.items()}
    if as_json:
        _print_object(output, progress, samples)
    elif "" in samples:
        print(f"{source}: {progress}; the same {samples[''].count} samples, sha256 {samples[''].sha256[:16]}")
    else:
        print(f"{source}: {progress}; the same samples in {counted(len(samples), 'box', 'boxes')}")


def _reproduction(source: Path) -> RunReproduction[Any, Any]:
    """Return the reproduction of a recording, or refuse that of a single box."""
    from dcrb_ros.recordings.vehicle_folder import box_of, vehicle_boxes

    if vehicle_boxes(source):
        from dcrb_ros.recordings.vehicle import VehicleRecording, VehicleReproduction

        return VehicleReproduction(VehicleRecording(source))
    whole, box = box_of(source)
    if box:
        raise Refusal(f"{source} is a box of the vehicle in {whole}, on which its samples depend: give --from {whole}")
    from dcrb_ros.recordings.reader import Recording
    from dcrb_ros.recordings.reproduction import Reproduction

    return Reproduction(Recording(source))


def simulate_vehicle(
    source: str,
    settings: Sequence[str],
    output: Path | None,
    seconds: float,
    *,
    scenario: Path | None = None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Simulate a vehicle and write a recording with the topics of all its boxes."""
    from dcrb_ros.recordings.vehicle_recorder import VehicleRecorder
    from dcrb_ros.simulation.scenario import scenario_of_run
    from dcrb_ros.vehicle.file import read_parameters
    from dcrb_ros.vehicle.scenario import starting_parameters
    from dcrb_ros.vehicle.simulation import simulation_of

    tree, path = scenario_of_run(scenario, seconds), output or Path(Path(source).stem)
    parameters = starting_parameters(tree, read_parameters(source, settings), str(scenario))
    simulation = simulation_of(parameters, source, tree, str(scenario))
    _check(seconds, *(box.configuration for box in simulation.vehicle.boxes))
    with replacing("-o", path, force=force), VehicleRecorder(path, parameters, simulation) as recorder:
        progress = _run(path.name, simulation.blocks(seconds), seconds, recorder.write, quiet=quiet, partial=True)
    for failure in simulation.silent.values():
        typer.echo(f"dcrb: {failure}; this box is silent from then on, the others go on (vehicle.on_failure = continue)", err=True)
    _print_written(path, progress, recorder.outcome.boxes, quiet=quiet, as_json=as_json)


def _print_written(path: Path, progress: Progress, outcomes: Mapping[str, Outcome], *, quiet: bool, as_json: bool) -> None:
    """Print what was recorded of each box; a bench is the box named ""."""
    if as_json:
        from dcrb_ros.recordings.digest import samples_in

        _print_object(path, progress, {name: samples_in(outcome) for name, outcome in outcomes.items()})
        return
    print(f"{path}: {progress}" + ("" if "" in outcomes else f", {counted(len(outcomes), 'box', 'boxes')}"))
    if not quiet:
        print(f"open it with: dcrb view {shlex.quote(str(path))}")


def _print_object(path: Path | None, progress: Progress, samples: Mapping[str, RecordedSamples]) -> None:
    """Print what was simulated as JSON, with number and digest of the samples of each box; a bench is the box named ""."""
    about = {"recording": None if path is None else str(path), "simulated": progress.simulated, "real_time_factor": progress.factor}
    boxes = {name: {"samples": recorded.count, "sha256": recorded.sha256} for name, recorded in samples.items()}
    print(json_text({**about, **boxes.get("", {"boxes": boxes})}))


def _run(
    name: str, blocks: Iterable[Made], seconds: float, write: Callable[[Made], None] | None, *, quiet: bool, partial: bool = False
) -> Progress:
    """Write blocks and show the progress; with ``partial``, Ctrl-C after the first block ends the recording early."""
    from rich.progress import TextColumn, TimeRemainingColumn

    from dcrb_ros.runtime.prefetch import WRITING_DEPTH, prefetch
    from dcrb_ros.runtime.signals import Uninterrupted
    from dcrb_ros.runtime.terminal import progress

    columns = (TextColumn("{task.completed:.1f} of {task.total:.1f} s simulated"), TimeRemainingColumn())
    started = begin = done = 0.0
    ready = prefetch(iter(blocks), depth=WRITING_DEPTH)
    try:
        # The kernels are compiled for the first block.
        with compilation_shown(quiet=quiet):
            first = list(itertools.islice(ready, 1))
        with progress(*columns, quiet=quiet) as bar:
            task = bar.add_task(name, total=seconds)
            for block in itertools.chain(first, ready):
                with Uninterrupted():
                    if write is not None:
                        write(block)
                    done = block.end_ns * 1e-9
                if not started:
                    started, begin = time.perf_counter(), done
                bar.update(task, completed=done)
    except KeyboardInterrupt:
        if not (partial and done):
            raise
        typer.echo(f"stopped at {done:.2f} s; the recording ends there", err=True)
    return Progress(done, (done - begin) / (time.perf_counter() - started) if done > begin else None)
