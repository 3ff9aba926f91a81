"""`dcrb bench`: the simulator and the fault detector as ROS 2 nodes, with a live status line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli import completion
from dcrb_ros.cli.options import DetectorFile, Duration, Force, OptionalConfig, Scenario, Settings, detector_parameters
from dcrb_ros.cli.output_file import check_force, replacing
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import expanded_path


def bench(
    config: OptionalConfig = None,
    duration: Duration = 10.0,
    time_scale: Annotated[
        float | None,
        typer.Option(help="Simulated over wall time, 0 to 1000; 0 runs as fast as possible. Default: the configuration's time_scale."),
    ] = None,
    record: Annotated[Path | None, typer.Option(help="Record the run to this new folder. Default: the configuration's.")] = None,
    rerun: Annotated[bool, typer.Option("--rerun", help="Open the Rerun viewer and show the bench while it runs.")] = False,
    scenario: Scenario = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Run the axle boxes of a vehicle instead: a YAML file or a shipped name, such as bogie.",
            autocompletion=completion.vehicles,
        ),
    ] = None,
    detector: DetectorFile = None,
    settings: Settings = None,
    force: Force = False,
) -> None:
    """Run the simulator of a bearing, or of the axle boxes of a vehicle, and its detector as ROS 2 nodes.

    Example: dcrb bench outer_ring_defect --duration 10 --record my_recording
    """
    from dcrb_ros.diagnosis.detector import check_parameters
    from dcrb_ros.schema.simulated_time import checked_duration
    from dcrb_ros.settings.files import load_configuration
    from dcrb_ros.simulation.scenario import scenario_of_run, scheduled_changes, starting_configuration

    seconds = checked_duration(duration)
    _check_settings(settings or (), {"time_scale": ("--time-scale", time_scale), "recording.path": ("--record", record)})
    extra = [f"time_scale={time_scale!r}"] if time_scale is not None else []
    extra += [f"recording.path={str(record)!r}"] if record else []
    tree = scenario_of_run(scenario, seconds)
    if vehicle is not None:
        if config:
            raise Refusal("--vehicle names a file with all boxes: leave out CONFIG")
        from dcrb_ros.vehicle.file import read_parameters, vehicle_of
        from dcrb_ros.vehicle.scenario import starting_parameters, vehicle_scenario

        boxes = starting_parameters(tree, read_parameters(vehicle, [*(settings or ()), *extra]), str(scenario))
        described = vehicle_of(boxes, vehicle)
        if tree is not None:
            vehicle_scenario(tree, described, str(scenario))
        name, configuration = Path(vehicle).stem, described.boxes[0].configuration
    elif config is not None:
        name, configuration = config, load_configuration(config, [*(settings or ()), *extra])
        if tree is not None:
            scheduled_changes(tree, starting_configuration(tree, configuration, str(scenario)), str(scenario))
    else:
        raise Refusal("Missing argument 'CONFIG': give a YAML file or a shipped name, such as healthy, or --vehicle NAME")
    parameters = detector_parameters(detector)
    check_parameters(parameters)
    recorded = configuration.recording.path
    check_force("--record", recorded, force=force)
    with replacing("--record" if record else "recording.path =", expanded_path(recorded), force=force) if recorded else nullcontext():
        from dcrb_ros.nodes.bench import bearing_bench, run

        if vehicle is not None:
            from dcrb_ros.nodes.vehicle_bench import vehicle_bench

            nodes = vehicle_bench(name, boxes, described, parameters, shown=rerun)
        else:
            nodes = bearing_bench(name, configuration, parameters, shown=rerun)
        status = run(nodes, configuration, seconds, scenario)
    raise typer.Exit(status)


def _check_settings(settings: Sequence[str], options: Mapping[str, tuple[str, object]]) -> None:
    """Refuse a setting of a parameter that an option sets, too; ``options`` has name and value of the option by the key."""
    for key in options.keys() & {setting.partition("=")[0].strip() for setting in settings}:
        option, value = options[key]
        if value is not None:
            raise Refusal(f"{option} and --set {key} set the same parameter: leave out one of them")
