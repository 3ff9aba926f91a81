"""Recording of a vehicle: one rosbag2 folder with the topics of all boxes, a manifest of each box, and the vehicle's parameters."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from dcrb_ros.messages.topics import GROUND_TRUTH, MANIFEST, NAMESPACE, VIBRATION, Message
from dcrb_ros.messages.topics.vehicle import VEHICLE_DETECTED, VEHICLE_TRUTH
from dcrb_ros.messages.vehicle import GIVEN, box_path, decode_vehicle_commands
from dcrb_ros.messages.vehicle_encoder import BESIDE, VehicleEncoder, box_topics
from dcrb_ros.recordings.manifest import OUTCOME, Outcome, now, opening, record_text, vehicle_fingerprint
from dcrb_ros.recordings.recorder import RunRecorder, chosen_topics
from dcrb_ros.recordings.vehicle_folder import VEHICLE, VEHICLE_OUTCOME, record_name
from dcrb_ros.runtime.version import __version__
from dcrb_ros.simulation.ground_truth import commands_in as changes_in
from dcrb_ros.stream.events import TimedCommand
from dcrb_ros.text.json import digest_of
from dcrb_ros.vehicle.block import VehicleBlock
from dcrb_ros.vehicle.changes import RANGES, checked_command
from dcrb_ros.vehicle.description import Vehicle
from dcrb_ros.vehicle.simulation import VehicleSimulation

FORMAT = 2
"""Format of the record `VEHICLE`."""


@dataclass(frozen=True)
class VehicleCommand:
    """A command to the vehicle and the simulated time at which it was given to the model."""

    time_ns: int
    """[ns]"""
    name: str
    """Such as ``speed_kmh``, or the key of a wheel or a slide."""
    value: float | str


def give(commands: Iterable[VehicleCommand], simulation: VehicleSimulation) -> None:
    """Give commands to a simulation, in their order and those of one time together: some are possible together only.

    Raises:
        Refusal: the vehicle of the simulation does not take them.
    """
    for (_, of_vehicle), group in groupby(commands, lambda command: (command.time_ns, command.name in RANGES)):
        values = {command.name: command.value for command in group}
        if of_vehicle:
            simulation.command(**{name: checked_command(name, value) for name, value in values.items()})
        else:
            simulation.change(values)


@dataclass(frozen=True)
class BoxCommand:
    """A change of the parameters of a box."""

    box: str
    command: TimedCommand


def commands_of(block: VehicleBlock) -> tuple[VehicleCommand | BoxCommand, ...]:
    """Return the commands and changes that took effect in a block."""
    given = [VehicleCommand(block.truth.time_ns, name, value) for name, value in block.truth.commands]
    changes = [BoxCommand(name, command) for name, box in block.boxes.items() for command in changes_in(box.truths)]
    return (*given, *changes)


class VehicleOutcome:
    """The outcome of the run of a vehicle so far: its end and its commands, and the outcome of each box."""

    def __init__(self, vehicle: Vehicle, commands: Iterable[VehicleCommand | BoxCommand], start_ns: int) -> None:
        """Start without samples at a simulated time [ns], with the ``commands`` that took effect before."""
        before = list(commands)
        self._end_ns, self._commands = start_ns, [command for command in before if isinstance(command, VehicleCommand)]
        changes = [command for command in before if isinstance(command, BoxCommand)]
        self.boxes = {
            box.name: Outcome(box.configuration.sensor.sampling_rate, [change.command for change in changes if change.box == box.name])
            for box in vehicle.boxes
        }
        """The outcome of each box by name."""
        below = [(box.name, plain, topic) for box in vehicle.boxes for plain, topic in box_topics(box.name).items()]
        self._of_boxes = {topic: (self.boxes[name], plain) for name, plain, topic in below if plain in (VIBRATION, GROUND_TRUTH)}

    @property
    def samples(self) -> int:
        """Number of samples of all boxes."""
        return sum(outcome.samples for outcome in self.boxes.values())

    def add(self, message: Message) -> None:
        """Include a message."""
        self._end_ns = max(self._end_ns, message.time_ns)
        if message.topic in self._of_boxes:
            outcome, plain = self._of_boxes[message.topic]
            outcome.add(Message(plain, message.time_ns, message.data))
        elif message.topic == VEHICLE_TRUTH:
            self._commands += commands_in(message)

    def records(self) -> dict[str, dict[str, str]]:
        """Return the metadata records at the end of a file."""
        commands = [[command.time_ns, command.name, command.value] for command in self._commands]
        records = {VEHICLE_OUTCOME: {"outcome": record_text({"end_ns": self._end_ns, "commands": commands, "ended": now()})}}
        for name, outcome in self.boxes.items():
            records[record_name(OUTCOME, name)] = outcome.records()[OUTCOME]
        return records


class VehicleRecorder(RunRecorder[VehicleBlock]):
    """Writes the recording of a vehicle, block by block or message by message; see `RunRecorder`."""

    def __init__(
        self,
        path: Path,
        parameters: Mapping[str, Any],
        simulation: VehicleSimulation,
        *,
        namespace: str = NAMESPACE,
        commands: Iterable[VehicleCommand | BoxCommand] = (),
        start_ns: int = 0,
    ) -> None:
        """Begin a recording in a new folder ``path``.

        The vehicle has the ``parameters`` by dotted keys. The recording begins at ``start_ns``, after the ``commands``.
        """
        vehicle = simulation.vehicle
        settings = vehicle.boxes[0].configuration.recording
        encoder = VehicleEncoder(vehicle, {name: box.bodies for name, box in simulation.simulations.items()})
        self.outcome = VehicleOutcome(vehicle, commands, start_ns)
        """What was recorded of the vehicle and of each box."""
        below = [pair for box in vehicle.boxes for pair in box_topics(box.name).items()]
        chosen = chosen_topics(settings.topics)
        topics = {*(topic for plain, topic in below if plain in chosen), *BESIDE, *VEHICLE_DETECTED}
        about = _opening(simulation, parameters, namespace)
        super().__init__(path, settings, namespace, topics, self.outcome, about, encoder.start(start_ns), encoder.encode)


def _opening(simulation: VehicleSimulation, parameters: Mapping[str, Any], namespace: str) -> dict[str, dict[str, str]]:
    """Return the metadata records at the beginning of every file."""
    vehicle, bodies = simulation.vehicle, {name: box.bodies for name, box in simulation.simulations.items()}
    about = {"format": FORMAT, "dcrb_ros": __version__, "model": vehicle_fingerprint(), "vehicle": dict(parameters)}
    about |= {"namespace": namespace, "recorded": now()}
    if simulation.scenario.content is not None:
        about["scenario"] = simulation.scenario.content
    records = {VEHICLE: {"vehicle": json.dumps({**about, "sha256": digest_of(about, "sha256")})}}
    for box in vehicle.boxes:
        below = f"{namespace.rstrip('/')}/{box_path(box.name)}"
        records[record_name(MANIFEST, box.name)] = opening(box.configuration, bodies[box.name], below)[MANIFEST]
    return records


def commands_in(message: Message) -> list[VehicleCommand]:
    """Return the commands to the vehicle in a message of its ground truth."""
    if GIVEN.encode() not in message.data:  # few messages have one, and decoding takes time
        return []
    return [VehicleCommand(message.time_ns, name, value) for name, value in decode_vehicle_commands(message.data)]
