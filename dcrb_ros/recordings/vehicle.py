"""The recording of a vehicle as it is read and reproduced; `vehicle_recorder` writes it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from dcrb_ros.messages.topic import chosen_topics
from dcrb_ros.messages.topics import DETECTED, NAMESPACE, SIMULATED, Message, Topic
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DETECTED, VEHICLE_TRUTH
from dcrb_ros.messages.vehicle import box_path, decode_description
from dcrb_ros.messages.vehicle_encoder import BESIDE
from dcrb_ros.recordings.foreign_files import refuse_foreign
from dcrb_ros.recordings.manifest import DAMAGE, vehicle_fingerprint
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorded_files import RecordedFiles
from dcrb_ros.recordings.reproduction import RunReproduction, recorded_samples
from dcrb_ros.recordings.vehicle_folder import VEHICLE, VEHICLE_OUTCOME, boxes_in, boxes_of
from dcrb_ros.recordings.vehicle_recorder import FORMAT, VehicleCommand, VehicleRecorder, commands_in, give
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.events import CommandSchedule
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.text.json import digest_of, parsed_json
from dcrb_ros.vehicle.block import VehicleBlock
from dcrb_ros.vehicle.simulation import VehicleSimulation, simulation_of


class VehicleRecording:
    """The recording of a vehicle: its parameters, and a `Recording` of each box.

    Raises:
        Refusal: it cannot be read, is that of a bench, its parameters were changed, or its folder has a file of another recording.
    """

    def __init__(self, path: str | Path) -> None:
        if not isinstance(path, (str, os.PathLike)):
            raise Refusal(f"{path!r} is not the path of a recording: give a folder made by dcrb simulate or dcrb bench --vehicle")
        self.path = path = Path(path)
        self._files = RecordedFiles(path)
        self.stored = self._files.stored
        """The files in order."""
        records = {record.name: record for file in self.stored for record in file.metadata()}
        names = boxes_in(records)
        if not names or VEHICLE not in records:
            raise Refusal(f"{path} is not the recording of a vehicle: give a folder made by dcrb simulate or dcrb bench --vehicle")
        about = parsed_json(records[VEHICLE].metadata.get("vehicle", ""), f"{path}: the record {VEHICLE}")
        if not isinstance(about, dict) or about.get("format") != FORMAT or not isinstance(about.get("vehicle"), dict):
            raise Refusal(f"{path}: the record {VEHICLE} is damaged: it does not have the form that the bench writes")
        if about.get("sha256") != digest_of(about, "sha256"):
            raise Refusal(f"{path}: the parameters of the vehicle were changed: their digest does not match; simulate it again")
        refuse_foreign(path, self.stored)
        self.parameters: Mapping[str, Any] = about["vehicle"]
        """Parameters of the vehicle by dotted keys."""
        lost = [name for name in boxes_of(self.parameters) if name not in names]
        if lost:
            raise Refusal(f"{path} is damaged: it does not describe the box {lost[0]} of its vehicle; simulate it again")
        other = [name for name in names if name not in boxes_of(self.parameters)]
        if other:
            raise Refusal(
                f"{path} was changed: it describes the box {printable(other[0])}, which its vehicle does not have; simulate it again"
            )
        self.model = str(about.get("model", ""))
        """Fingerprint of the model of the vehicle."""
        self.scenario: Any = about.get("scenario")
        """The scenario as parsed from YAML; None without one."""
        self.namespace = str(about.get("namespace", NAMESPACE))
        self.boxes = {name: Recording(path / name) for name in names}
        """The recording of each box by name."""
        endings = [record for record in self.stored[-1].metadata() if record.name == VEHICLE_OUTCOME]
        self._outcome = self._files.content(endings[-1], "outcome", str(path)) if endings else None

    @cached_property
    def description(self) -> VehicleDescription:
        """What a detector may know about the vehicle.

        Raises:
            Refusal: the recording has none, or a damaged one.
        """
        message = next(self.messages((VEHICLE_DESCRIPTION,)), None)
        if message is None:
            raise Refusal(f"{self.path} has no message on {VEHICLE_DESCRIPTION.name}: record this topic, too")
        return decode_description(message.data)

    @property
    def damage(self) -> list[str]:
        """A sentence for each part that could not be read so far."""
        own = map(printable, self._files.damage)
        return list(dict.fromkeys([*own, *(sentence for box in self.boxes.values() for sentence in box.damage)]))

    @property
    def sampling_rate(self) -> int:
        """Sampling rate of all boxes [Hz]."""
        return next(iter(self.boxes.values())).sampling_rate

    @cached_property
    def duration(self) -> float:
        """Simulated time from the start of the run to the end of the recording [s]."""
        return max(recorded_samples(box).end for box in self.boxes.values()) / self.sampling_rate

    def topics(self, chosen: Iterable[Topic] = (*SIMULATED, *DETECTED)) -> dict[str, Topic]:
        """Return topics of every box, and all of the vehicle, by their names in the file.

        Raises:
            Refusal: ``chosen`` are not topics, such as names.
        """
        each = [topic.below(box_path(name)) for name in self.boxes for topic in chosen_topics(chosen)]
        return {topic.resolved(self.namespace): topic for topic in (*each, *BESIDE, *VEHICLE_DETECTED)}

    def messages(self, topics: Iterable[Topic]) -> Iterator[Message]:
        """Yield the messages on some of `topics`, in the order of the file.

        Raises:
            Refusal: ``topics`` are not topics, such as names.
        """
        wanted = {topic.resolved(self.namespace): topic for topic in chosen_topics(topics)}
        for entry in self._files.messages(wanted):
            yield Message(wanted[entry.channel.topic], entry.message.log_time, entry.message.data)

    def commands(self) -> list[VehicleCommand]:
        """Return the commands to the vehicle, from the record at the end or from the ground truth."""
        try:
            return [VehicleCommand(int(time_ns), str(name), value) for time_ns, name, value in (self._outcome or {})["commands"]]
        except DAMAGE:
            return [command for message in self.messages((VEHICLE_TRUTH,)) for command in commands_in(message)]


class VehicleReproduction(RunReproduction[VehicleSimulation, VehicleBlock]):
    """Reproduces the run in the recording of a vehicle."""

    def __init__(self, recording: VehicleRecording) -> None:
        super().__init__(recording.path, recording.boxes)
        self._recording = recording

    def simulation(self) -> VehicleSimulation:
        """Return the vehicle at the start of the run."""
        recorded = {name: box.configuration for name, box in self._recording.boxes.items()}
        return simulation_of(
            self._recording.parameters, str(self.path), self._recording.scenario, f"{self.path}: scenario", recorded=recorded
        )

    def recorder(self, path: Path, simulation: VehicleSimulation) -> VehicleRecorder:
        """Return the recorder of the vehicle."""
        return VehicleRecorder(path, self._recording.parameters, simulation)

    def blocks(self, simulation: VehicleSimulation) -> Iterator[VehicleBlock]:
        """Yield the blocks of the run, with the commands given at their times."""
        commands = sorted(self._recording.commands(), key=lambda command: command.time_ns)
        schedules = {name: CommandSchedule(box.commands()) for name, box in self._recording.boxes.items()}
        blocks = simulation.blocks(self.duration)
        while True:
            due = [command for command in commands if command.time_ns <= simulation.time_ns]
            give(due, simulation)
            del commands[: len(due)]
            for name, schedule in schedules.items():
                schedule.apply_due(simulation.simulations[name])
            block = next(blocks, None)
            if block is None:
                return
            for name, box in block.boxes.items():
                self.compared[name].add(box)
            yield block

    def difference(self) -> str:
        """Return how model, software or processor differ from those that made the recording; the empty string if they do not."""
        made, present = self._recording.model, vehicle_fingerprint()
        vehicles = f"the model of the vehicle was {made} and is {present}" if made != present else ""
        return "; ".join(filter(None, (vehicles, super().difference())))
