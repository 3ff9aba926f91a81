"""The recording of a vehicle: one rosbag2 folder with the topics of all boxes, a manifest of each box, and the vehicle's parameters."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any

from dcrb_ros.messages.points import packed
from dcrb_ros.messages.topics import DETECTED, GROUND_TRUTH, MANIFEST, NAMESPACE, SIMULATED, VIBRATION, Message, Topic
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DETECTED, VEHICLE_TRUTH
from dcrb_ros.messages.vehicle import GIVEN, box_path, decode_description, decode_vehicle_commands
from dcrb_ros.messages.vehicle_encoder import BESIDE, VehicleEncoder, box_topics
from dcrb_ros.recordings.digest import digest_mismatch
from dcrb_ros.recordings.foreign_files import refuse_foreign
from dcrb_ros.recordings.manifest import OUTCOME, Outcome, now, opening
from dcrb_ros.recordings.mcap_writer import Channel
from dcrb_ros.recordings.reader import DAMAGE, Recording
from dcrb_ros.recordings.recorder import channel_of, chosen_topics
from dcrb_ros.recordings.reproduction import ALIKE, NotReproduced, origin_difference, recorded_samples
from dcrb_ros.recordings.splitting import SECOND, Bag, RecordingFailed, Splitting
from dcrb_ros.recordings.storage import valid_files
from dcrb_ros.recordings.vehicle_folder import VEHICLE, VEHICLE_OUTCOME, boxes_in, record_name
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.simulation.ground_truth import commands_in as changes_in
from dcrb_ros.stream.events import CommandSchedule, TimedCommand
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.text.json import parsed_json
from dcrb_ros.vehicle.changes import RANGES, checked_command
from dcrb_ros.vehicle.simulation import VehicleBlock, VehicleSimulation

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

    def give(self, simulation: VehicleSimulation) -> None:
        """Give it to a simulation.

        Raises:
            Refusal: the vehicle of the simulation does not take it.
        """
        if self.name in RANGES:
            simulation.command(**{self.name: checked_command(self.name, self.value)})
        else:
            simulation.change({self.name: self.value})


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


class VehicleRecorder:
    """Writes the recording of a vehicle, block by block or message by message.

    Raises:
        Refusal: the path exists or cannot be created, or a topic is unknown.
        RecordingFailed: a write failed later.
    """

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
        """Begin a recording.

        Args:
            path: the folder to create.
            parameters: those of the vehicle by dotted keys.
            simulation: the run.
            namespace: namespace of the topics of the vehicle.
            commands: the commands that took effect before the recording begins.
            start_ns: simulated time at which it begins [ns].
        """
        vehicle, before = simulation.vehicle, list(commands)
        self._namespace = namespace
        bodies = {name: box.bodies for name, box in simulation.simulations.items()}
        settings = vehicle.boxes[0].configuration.recording
        self._chosen = chosen_topics(settings.topics)
        self._encoder = VehicleEncoder(vehicle, bodies)
        self._channels: dict[Topic, Channel] = {}
        self._end_ns, self._commands = start_ns, [command for command in before if isinstance(command, VehicleCommand)]
        changes = [command for command in before if isinstance(command, BoxCommand)]
        self.outcomes = {
            box.name: Outcome(box.configuration.sensor.sampling_rate, [change.command for change in changes if change.box == box.name])
            for box in vehicle.boxes
        }
        """What was recorded of each box."""
        self._counted = {
            topic: (self.outcomes[box.name], plain)
            for box in vehicle.boxes
            for plain, topic in box_topics(box.name).items()
            if plain in (VIBRATION, GROUND_TRUTH)
        }
        self._recorded = {topic for box in vehicle.boxes for plain, topic in box_topics(box.name).items() if plain in self._chosen}
        self._recorded |= {*BESIDE, *VEHICLE_DETECTED}
        self._bag = Bag(
            Path(path),
            opening=_opening(simulation, parameters, namespace),
            closing=self._closing,
            compression=settings.compression,
            splitting=Splitting(settings.split_size, round(settings.split_duration * SECOND)),
        )
        self.path = self._bag.path
        try:
            self.write_messages(self._encoder.start(start_ns))
            self._bag.flush()
        except RecordingFailed as error:
            shutil.rmtree(self.path, ignore_errors=True)
            raise Refusal(f"{error}; make room or give another folder") from None

    def __enter__(self) -> VehicleRecorder:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        """Finish the recording; one that an error or a signal ends before its first sample is removed."""
        self.close()
        if kind is not None and not any(outcome.samples for outcome in self.outcomes.values()):
            shutil.rmtree(self.path, ignore_errors=True)

    def write(self, block: VehicleBlock) -> None:
        """Record a block of every box."""
        self.write_messages(self._encoder.encode(block))

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages; those on topics that are not recorded count in the hashes of the samples."""
        if self._bag.open:
            self._bag.write(self._count(list(messages)))

    def _count(self, messages: Iterable[Message]) -> Iterator[tuple[Channel, int, bytes]]:
        for message in messages:
            if message.topic in self._recorded:
                if message.topic not in self._channels:
                    self._channels[message.topic] = channel_of(message.topic, self._namespace)
                yield self._channels[message.topic], message.time_ns, message.data
            self._end_ns = max(self._end_ns, message.time_ns)
            if message.topic == VEHICLE_TRUTH:
                self._commands += commands_in(message)
            elif message.topic in self._counted:
                outcome, plain = self._counted[message.topic]
                outcome.add(Message(plain, message.time_ns, message.data))

    def close(self) -> None:
        """Finish the recording; a second call does nothing."""
        self._bag.close()

    def _closing(self) -> dict[str, dict[str, str]]:
        commands = [[command.time_ns, command.name, command.value] for command in self._commands]
        records = {VEHICLE_OUTCOME: {"outcome": json.dumps({"end_ns": self._end_ns, "commands": commands, "ended": now()})}}
        for name, outcome in self.outcomes.items():
            records[record_name(OUTCOME, name)] = outcome.records()[OUTCOME]
        return records


def _opening(simulation: VehicleSimulation, parameters: Mapping[str, Any], namespace: str) -> dict[str, dict[str, str]]:
    """Return the metadata records at the beginning of every file."""
    vehicle, bodies = simulation.vehicle, {name: box.bodies for name, box in simulation.simulations.items()}
    about = {"format": FORMAT, "dcrb_ros": __version__, "vehicle": dict(parameters), "namespace": namespace, "recorded": now()}
    if simulation.scenario.content is not None:
        about["scenario"] = simulation.scenario.content
    records = {VEHICLE: {"vehicle": json.dumps({**about, "sha256": _digest(about)})}}
    for box in vehicle.boxes:
        below = f"{namespace.rstrip('/')}/{box_path(box.name)}"
        records[record_name(MANIFEST, box.name)] = opening(box.configuration, bodies[box.name], below)[MANIFEST]
    return records


def commands_in(message: Message) -> list[VehicleCommand]:
    """Return the commands to the vehicle in a message of its ground truth."""
    if GIVEN.encode() not in message.data:  # few messages have one, and decoding takes time
        return []
    return [VehicleCommand(message.time_ns, name, value) for name, value in decode_vehicle_commands(message.data)]


class VehicleRecording:
    """The recording of a vehicle: its parameters, and a `Recording` of each box.

    Raises:
        Refusal: it cannot be read, is that of a bench, its parameters were changed, or its folder has a file of another recording.
    """

    def __init__(self, path: str | Path) -> None:
        if not isinstance(path, (str, os.PathLike)):
            raise Refusal(f"{path!r} is not the path of a recording: give a folder made by dcrb simulate or dcrb bench --vehicle")
        self.path = path = Path(path)
        self._files, self._flaws = valid_files(path)
        records = {record.name: record for file in self._files for record in file.metadata()}
        names = boxes_in(records)
        if not names or VEHICLE not in records:
            raise Refusal(f"{path} is not the recording of a vehicle: give a folder made by dcrb simulate or dcrb bench --vehicle")
        about = parsed_json(records[VEHICLE].metadata.get("vehicle", ""), f"{path}: the record {VEHICLE}")
        if not isinstance(about, dict) or about.get("format") != FORMAT or not isinstance(about.get("vehicle"), dict):
            raise Refusal(f"{path}: the record {VEHICLE} is damaged: it does not have the form that the bench writes")
        if about.pop("sha256", None) != _digest(about):
            raise Refusal(f"{path}: the parameters of the vehicle were changed: their digest does not match; simulate it again")
        refuse_foreign(path, self._files)
        self.parameters: Mapping[str, Any] = about["vehicle"]
        """Parameters of the vehicle by dotted keys."""
        self.scenario: Any = about.get("scenario")
        """The scenario as parsed from YAML; None without one."""
        self.namespace = str(about.get("namespace", NAMESPACE))
        self.boxes = {name: Recording(path / name) for name in names}
        """The recording of each box by name."""
        ending = records.get(VEHICLE_OUTCOME)
        self._outcome = parsed_json(ending.metadata.get("outcome", ""), f"{path}: the record {VEHICLE_OUTCOME}") if ending else None

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
        return list(dict.fromkeys([*map(printable, self._flaws), *(sentence for box in self.boxes.values() for sentence in box.damage)]))

    @property
    def sampling_rate(self) -> int:
        """Sampling rate of all boxes [Hz]."""
        return next(iter(self.boxes.values())).sampling_rate

    @cached_property
    def duration(self) -> float:
        """Simulated time from the start of the run to the end of the recording [s]."""
        return max(recorded_samples(box).end for box in self.boxes.values()) / self.sampling_rate

    def topics(self, chosen: Iterable[Topic] = (*SIMULATED, *DETECTED)) -> dict[str, Topic]:
        """Return topics of every box, and all of the vehicle, by their names in the file."""
        each = [topic.below(box_path(name)) for name in self.boxes for topic in chosen]
        return {topic.resolved(self.namespace): topic for topic in (*each, *BESIDE, *VEHICLE_DETECTED)}

    def messages(self, topics: Iterable[Topic]) -> Iterator[Message]:
        """Yield the messages on some of `topics`, in the order of the file."""
        wanted, flaws = {topic.resolved(self.namespace): topic for topic in topics}, list[str]()
        for file in self._files:
            for entry in file.messages(flaws, wanted):
                yield Message(wanted[entry.channel.topic], entry.message.log_time, entry.message.data)
        self._flaws += [flaw for flaw in flaws if flaw not in self._flaws]

    def commands(self) -> list[VehicleCommand]:
        """Return the commands to the vehicle, from the record at the end or from the ground truth."""
        try:
            return [VehicleCommand(int(time_ns), str(name), value) for time_ns, name, value in (self._outcome or {})["commands"]]
        except DAMAGE:
            return [command for message in self.messages((VEHICLE_TRUTH,)) for command in commands_in(message)]


class VehicleReproduction:
    """Simulates a vehicle's recording again, with its commands, and compares the samples of every box."""

    def __init__(self, recording: VehicleRecording) -> None:
        """Prepare the run of a recording.

        Raises:
            Refusal: it has no samples, or they do not match its own digest.
        """
        self._recording = recording
        self.samples = {name: recorded_samples(box) for name, box in recording.boxes.items()}
        """Number and digest of the recorded samples of each box."""
        if not any(samples.count for samples in self.samples.values()):
            raise Refusal(f"{recording.path} contains no samples to reproduce")
        for name, box in recording.boxes.items():
            if mismatch := digest_mismatch(box):
                raise Refusal(f"{recording.path / name}: {mismatch}")
        self._digests = {name: hashlib.sha256() for name in recording.boxes}

    def blocks(self, simulation: VehicleSimulation) -> Iterator[VehicleBlock]:
        """Yield the blocks of the run, with the commands given at their times."""
        commands = sorted(self._recording.commands(), key=lambda command: command.time_ns, reverse=True)
        schedules = {name: CommandSchedule(box.commands()) for name, box in self._recording.boxes.items()}
        blocks = simulation.blocks(self._recording.duration)
        while True:
            while commands and commands[-1].time_ns <= simulation.time_ns:
                commands.pop().give(simulation)
            for name, schedule in schedules.items():
                schedule.apply_due(simulation.simulations[name])
            block = next(blocks, None)
            if block is None:
                return
            self._compare(block)
            yield block

    def _compare(self, block: VehicleBlock) -> None:
        for name, box in block.boxes.items():
            skipped = max(0, self.samples[name].first_index - box.index)
            if skipped < len(box.shaft_angle) and not box.lost:
                self._digests[name].update(packed(box.acceleration[skipped:], box.shaft_angle[skipped:]))

    def check(self) -> None:
        """Compare the samples with the recorded ones.

        Raises:
            NotReproduced: those of a box differ.
        """
        different = [name for name, digest in self._digests.items() if digest.hexdigest() != self.samples[name].sha256]
        if different:
            reason = self.difference() or ALIKE
            raise NotReproduced(f"{self._recording.path}: the samples of {', '.join(different)} differ from the recorded ones: {reason}")

    def difference(self) -> str:
        """Return how model, software or processor differ from those that made the recording; the empty string if they do not."""
        return origin_difference(next(iter(self._recording.boxes.values())))


def _digest(about: Mapping[str, Any]) -> str:
    """Return the digest of the entries of a record."""
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()
