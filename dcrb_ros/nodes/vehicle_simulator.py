"""The vehicle simulator node: the axle boxes of a vehicle on one clock, each behind the topics of a bench."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.parameter import Parameter

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import LOAD_COMMAND, SPEED_COMMAND, VIBRATION, Message, Topic
from dcrb_ros.messages.topics.vehicle import VEHICLE_COMMANDS, VEHICLE_DESCRIPTION, VEHICLE_DETECTED, VEHICLE_DIAGNOSIS
from dcrb_ros.messages.vehicle import box_path
from dcrb_ros.messages.vehicle_encoder import VehicleEncoder, simulated_topics
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.parameters import changed_by_topic, is_of_ros, not_while_running
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.ros import own_arguments, run_node
from dcrb_ros.nodes.simulating import SimulatingNode, decoded_by
from dcrb_ros.recordings.recorder import check_topics
from dcrb_ros.recordings.vehicle_recorder import VehicleRecorder, commands_of
from dcrb_ros.runtime.prefetch import prefetch
from dcrb_ros.schema.parameter_field import ParameterField, wrong_type
from dcrb_ros.schema.refusal import Refusal, nearest_key
from dcrb_ros.schema.simulated_time import checked_duration
from dcrb_ros.settings.files import fields_by_key, flatten, parameter_fields
from dcrb_ros.simulation.scenario import scenario_of_run
from dcrb_ros.vehicle.description import Wheel
from dcrb_ros.vehicle.file import (
    COMMON,
    DRIVE,
    GROUPS,
    MOST_SLIDING,
    PLACES,
    SWAPPED,
    layered,
    made_by_vehicle,
    read_parameters,
    vehicle_of,
)
from dcrb_ros.vehicle.scenario import starting_parameters, vehicle_scenario
from dcrb_ros.vehicle.simulation import VehicleSimulation, simulation_of

OF_BOX = tuple(field for field in parameter_fields() if field.run_time and field.key != "time_scale" and not made_by_vehicle(field.key))
"""Parameters of a box that can be set while the node runs."""
OF_WHEEL = tuple(parameter_fields(Wheel, "wheel."))
"""Parameters of the wheel under a box, all of which can be set while the node runs."""
SLIDE = ParameterField(
    "slide", float, 0.0, 0.0, MOST_SLIDING, "-", "", "Share by which the wheelset turns slower than it rolls", "0 lets it roll", True
)
TIME_SCALE = next(field for field in parameter_fields() if field.key == "time_scale")


class VehicleSource:
    """The simulation of a vehicle as a source of bundles: the blocks of all its boxes in one bundle."""

    def __init__(self, begin: Callable[[], VehicleSimulation], duration: float | None, gate: Gate) -> None:
        self._begin, self._duration, self._gate = begin, duration, gate

    def start(self) -> list[Message]:
        """Set up the vehicle at simulated time 0."""
        self.simulation = self._begin()
        bodies = {name: box.bodies for name, box in self.simulation.simulations.items()}
        self._encoder = VehicleEncoder(self.simulation.vehicle, bodies)
        return self._encoder.start()

    def bundles(self) -> Generator[Bundle, None, None]:
        """Yield a bundle for each block of the vehicle."""
        # The boxes step the next block while this one is encoded and sent; commands therefore take effect a block later.
        with closing(prefetch(self.simulation.blocks(self._duration), lambda: not self._gate.paused)) as blocks:
            for block in blocks:
                messages = tuple(self._encoder.encode(block))
                yield Bundle(block.truth.time_ns, block.end_ns, messages, commands=commands_of(block))


class VehicleSimulatorNode(SimulatingNode):
    """Publishes and records the boxes of a vehicle; accepts commands to the vehicle, parameters of its boxes and service calls."""

    _source: VehicleSource
    detected = VEHICLE_DETECTED
    behind = "behind real time: lower time_scale to the real_time_factor"

    def __init__(
        self, duration: float | None, source: str | None, scenario: Path | None = None, parameters: Mapping[str, Any] | None = None
    ) -> None:
        """Prepare ``duration`` of simulated time [s], endless without one, of the vehicle ``source``, a file or a shipped name.

        The ``parameters`` by dotted keys are by default those of ``source`` with those given to the node by ROS, and at the start of the
        ``scenario``, on top.

        Raises:
            Refusal: there is no such vehicle or scenario, or a parameter is invalid.
        """
        super().__init__("vehicle_simulator")
        overrides: Mapping[str, Any] = self.get_parameters_by_prefix("")
        given = {key: parameter.value for key, parameter in overrides.items() if not is_of_ros(key)}
        if parameters is None and source is None and not given:
            raise Refusal("there is no vehicle: give --vehicle with a YAML file or a shipped name, such as bogie")
        base = read_parameters(source) if source is not None else {}
        name, changes = source or "parameters", scenario_of_run(scenario, duration)
        tree = starting_parameters(changes, parameters if parameters is not None else layered(base, given), str(scenario))

        def simulation() -> VehicleSimulation:
            return simulation_of(tree, name, changes, str(scenario))

        self._vehicle = vehicle_of(tree, name)
        check_topics(*(box.configuration for box in self._vehicle.boxes))
        if changes is not None:
            vehicle_scenario(changes, self._vehicle, str(scenario))
        self._refused = [topic.below(box_path(box.name)) for box in self._vehicle.boxes for topic in (SPEED_COMMAND, LOAD_COMMAND)]
        """The topics on which a bench of its own would take commands, which belong to the vehicle here."""
        self.commands = [*VEHICLE_COMMANDS.values(), *self._refused]
        self._silent: set[str] = set()
        self._declare_run_time()
        self._fix(key for key in given if key not in self._fields)
        self.assemble(
            self._vehicle.boxes[0].configuration,
            partial(VehicleSource, simulation, duration),
            simulated_topics(self._vehicle),
            lambda path, **options: VehicleRecorder(path, tree, self._source.simulation, **options),
            waveform=VIBRATION.below(box_path(self._vehicle.boxes[0].name)),
            description=VEHICLE_DESCRIPTION,
            answers=self.follow_detector(VEHICLE_DIAGNOSIS),
        )

    def _declare_run_time(self) -> None:
        """Declare the parameters that can be set while the node runs."""
        values: dict[str, Any] = {"time_scale": self._vehicle.boxes[0].configuration.time_scale}
        self._fields = {"time_scale": TIME_SCALE}
        for box in self._vehicle.boxes:
            present = flatten(box.configuration.model_dump())
            present |= {f"wheel.{key}": value for key, value in box.wheel.model_dump().items()}
            for field in (*OF_BOX, *OF_WHEEL):
                key = f"{box.name}.{field.key}"
                self._fields[key], values[key] = replace(field, key=key), present[field.key]
        for axle in self._vehicle.axles:
            key = f"{axle.name}.slide"
            self._fields[key], values[key] = replace(SLIDE, key=key), axle.slide
        for key, field in self._fields.items():
            self.declare_field(key, field, values[key])

    def _fix(self, keys: Iterable[str]) -> None:
        """Declare the other given parameters as read-only, so that `ros2 param load` may set them to the values that they have."""
        for key in keys:
            value = self.get_parameter(key).value
            self.undeclare_parameter(key)
            self.declare_parameter(key, value, ParameterDescriptor(name=key, read_only=True), ignore_override=True)

    def about(self) -> tuple[str, Mapping[str, str]]:
        """Return a warning about silent boxes, and values for the status."""
        silent = self._source.simulation.silent
        for name in silent:
            if name not in self._silent:
                self.get_logger().error(f"{silent[name]}; this box is silent, the others go on (vehicle.on_failure = continue)")
        self._silent = set(silent)
        warning = f"silent: {', '.join(silent)}" if silent else ""
        return warning, {"boxes": str(len(self._vehicle.boxes)), "silent": ", ".join(silent)}

    def receive(self) -> None:
        """Subscribe to the commands of the vehicle, to those of boxes to refuse them, and to the detector."""
        for name, topic in VEHICLE_COMMANDS.items():
            self._take_command(name, topic)
        for topic in self._refused:
            self._refuse_command(topic)
        for topic in VEHICLE_DETECTED:
            self.record_detected(topic)

    def _take_command(self, name: str, topic: Topic) -> None:
        def give(data: bytes) -> None:
            self._source.simulation.command(**{name: topic.decoded(data)})

        def take(data: bytes) -> None:
            with self.refusals.suppressed(topic.name):
                self.refuse_untimely(topic.name)
                decoded_by(topic.name, give, data)

        self.subscribe(topic, take)

    def _refuse_command(self, topic: Topic) -> None:
        what, commands = ("speed", ["speed_kmh"]) if topic.name.endswith(SPEED_COMMAND.name) else ("load", ["curvature", "brake", "wind"])
        remedy = ", ".join(VEHICLE_COMMANDS[name].name for name in commands)

        def refuse(data: bytes) -> None:
            self.refusals.note(topic.name, f"{topic.name} is refused, as the {what} of a box follows from the vehicle: publish on {remedy}")

        self.subscribe(topic, refuse)

    def change(self, changes: Mapping[str, Any]) -> None:
        """Change parameters of boxes, wheels and slides."""
        self._source.simulation.change(changes)

    def check_parameter(self, key: str, value: Any) -> None:
        """Refuse a parameter that cannot be set while the node runs, or a value of another type."""
        field: ParameterField | None = self._fields.get(key)
        if field is not None:
            wrong = wrong_type(field, value)
            if wrong:
                raise Refusal(f"parameters: {wrong}")
            return
        group, _, name = key.partition(".")
        if group == "vehicle" and name in VEHICLE_COMMANDS:
            raise changed_by_topic(key, VEHICLE_COMMANDS[name].name)
        box = next((box.name for box in self._vehicle.boxes if key.startswith(f"{box.name}.")), None)
        known = self._of_vehicle() if box is None else {f"{box}.{name}" for name in (*fields_by_key(), "bench", SWAPPED)}
        if key not in known:
            raise Refusal(f"parameters: unknown parameter '{key}'{nearest_key(key, self._fields.keys() | known)}")
        if box is not None and (owner := made_by_vehicle(key.removeprefix(f"{box}."))):
            topics = ", ".join(topic.name for topic in VEHICLE_COMMANDS.values())
            moving = key.startswith(f"{box}.operating.")
            remedy = f"publish on {topics}" if moving else f"set {box}.wheel, or give track and gear at the start"
            raise Refusal(f"parameters: {key} follows from {owner}: {remedy}")
        raise not_while_running(key, "give it at the start")

    def _of_vehicle(self) -> set[str]:
        """Return the parameters of the vehicle and its wheelsets, which belong to no box."""
        groups = dict(GROUPS) | {f"{axle.name}.{part}": model for axle in self._vehicle.axles for part, model in DRIVE.items()}
        places = {f"{axle.name}.{place}" for axle in self._vehicle.axles for place in PLACES}
        common = {key for key in fields_by_key() if key.partition(".")[0] in COMMON}
        return places | common | {f"{group}.{name}" for group, model in groups.items() for name in model.model_fields}

    def update_parameters(self) -> None:
        """Set the node's parameters to those of the running boxes, which a reset may have changed."""
        running = self._source.simulation
        changed = [Parameter(key, value=value) for key, value in running.worn().items() if self.get_parameter(key).value != value]
        for name, simulation in running.simulations.items():
            if simulation.has_pending:
                continue
            present = flatten(simulation.configuration.model_dump())
            for field in OF_BOX:
                key = f"{name}.{field.key}"
                if self.get_parameter(key).value != present[field.key]:
                    changed.append(Parameter(key, value=present[field.key]))
        if changed:
            self.set_parameters(changed)


def run(arguments: list[str], parameters: Mapping[str, Any] | None = None) -> int:
    """Run the node until its duration is over or a termination signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog="vehicle_simulator", description="The axle boxes of a simulated vehicle as a ROS 2 node.")
    parser.add_argument("--vehicle", default=None, help="the vehicle: a YAML file or a shipped name, such as bogie")
    parser.add_argument("--duration", type=float, default=None, help="simulated time after which the node ends [s]")
    parser.add_argument("--scenario", type=Path, default=None, help="timeline of the vehicle and its boxes in simulated time (YAML)")
    options = own_arguments(parser, arguments)
    duration = None if options.duration is None else checked_duration(options.duration)
    return run_node(lambda: VehicleSimulatorNode(duration, options.vehicle, options.scenario, parameters), arguments)


if __name__ == "__main__":
    main("vehicle_simulator", sys.argv[1:])
