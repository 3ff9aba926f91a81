"""A recording as a source of messages: which are sent together, and when."""

from __future__ import annotations

import json
from collections.abc import Generator, Sequence
from contextlib import closing
from functools import cached_property
from itertools import islice
from pathlib import Path

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.description import decode_frame, sensor_text
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.topics import DETECTED, DIAGNOSIS, SENSOR, SIMULATED, TRANSFORMS, VIBRATION, Message, Topic
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DETECTED
from dcrb_ros.messages.vehicle import box_path
from dcrb_ros.messages.vehicle_encoder import BESIDE
from dcrb_ros.recordings.manifest import Outcome
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import chosen_topics, named_topics
from dcrb_ros.recordings.vehicle import VehicleRecording
from dcrb_ros.recordings.vehicle_folder import vehicle_boxes
from dcrb_ros.schema.fields import Group, choice, quantity
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.simulated_time import nanoseconds


class ReplayParameters(Group):
    """Recording to replay, its topics and its rate."""

    bag: str = choice("", "Recording to replay: a folder, or an .mcap or .db3 file")
    rate: float = quantity(
        1.0, "-", "Recorded over wall time; 0 for as fast as possible", 0.0, 1000.0, remedy="1.0 is the recorded pace", run_time=True
    )
    loop: bool = choice(False, "Start again at the end, endlessly; the stamps start again too")
    offset: float = quantity(0.0, "s", "Recorded time to skip at the beginning", 0.0, 1e6)
    clock: bool = choice(False, "Publish /clock, the recorded time")
    topics: str = choice("", "Topics to replay, such as 'outer_ring/vibration, diagnosis'; empty for what the simulator publishes")
    listeners: int = quantity(1, "-", "Subscribers to wait for before the first block, to the waveform or else to the first topic", 0, 1000)
    wait: float = quantity(3.0, "s", "Longest wall time to wait for them", 0.0, 1e4)


class Replay:
    """The messages of a recording in bundles as the simulator sends them: a block and its other messages at the end of the block.

    The blocks of the boxes of a vehicle are in one bundle, with equal stamps.

    Raises:
        Refusal: there is no recording, or a topic is unknown.
    """

    def __init__(self, parameters: ReplayParameters) -> None:
        if not parameters.bag:
            raise Refusal("there is nothing to replay: give a recording with the parameter bag")
        path = Path(parameters.bag)
        self._offset_ns = round(parameters.offset * 1e9)
        boxes = vehicle_boxes(path)
        self.recording: Recording | VehicleRecording = VehicleRecording(path) if boxes else Recording(path)
        chosen: list[Topic] = list(SIMULATED)
        names = named_topics(parameters.topics)
        if names:
            if isinstance(self.recording, VehicleRecording):
                _refuse_beside_boxes(names, self.recording)
            known = {topic.name: topic for topic in chosen_topics(parameters.topics, "topics")}
            chosen = [known[name] for name in dict.fromkeys((SENSOR.name, *names))]
            if chosen == [SENSOR]:
                raise Refusal(f"topics: {SENSOR.name} is replayed beside every other topic: name another one, such as {VIBRATION.name}")
        if isinstance(self.recording, VehicleRecording):
            below = [(topic, topic.below(box_path(name)), box) for name, box in self.recording.boxes.items() for topic in chosen]
            detected = VEHICLE_DETECTED if set(chosen) & set(DETECTED) else ()
            self.topics: tuple[Topic, ...] = (*(topic for _, topic, _ in below), *BESIDE, *detected)
        else:
            below = [(topic, topic, self.recording) for topic in chosen]
            detected = ()
            self.topics = tuple(chosen)
        self._named: dict[str, set[Topic]] = {}
        """The topics of the recording that are replayed for each one that is named, but that of the description."""
        for topic in set(chosen) - {SENSOR} if names else ():
            beside = detected if topic in DETECTED else ()
            self._named[topic.name] = {*(full for plain, full, _ in below if plain == topic), *beside}
        self._boxes = {topic: box for plain, topic, box in below if plain == VIBRATION}
        self.waveforms = tuple(self._boxes)
        """The topics of the waveforms, which say when a bundle is due."""
        self.mismatch = ""
        """After all bundles, a sentence if the samples do not match the digest that the recording states."""
        self._descriptions = {topic: _described(box, topic) for plain, topic, box in below if plain == SENSOR}
        """The description of the sensor that was sent last, by topic."""
        self.frame = decode_frame(next(iter(self._descriptions.values())).data)
        """Frame id of the sensor, the first one of a vehicle."""
        self.latched = VEHICLE_DESCRIPTION if boxes else SENSOR
        """The latched topic that is published last."""

    @cached_property
    def awaited(self) -> Topic:
        """The topic whose subscribers are waited for: the waveform of the first box, or else the first topic that has messages.

        Raises:
            Refusal: the recording has no message on the topics.
        """
        for topic in sorted(self.topics, key=lambda topic: topic not in self._boxes):
            if not topic.latched and next(self.recording.messages([topic]), None) is not None:
                return topic
        raise Refusal(f"{self.recording.path} has no message on the topics to replay: dcrb info lists the topics that it has")

    def check(self) -> None:
        """Read the first bundle, which `bundles` yields again.

        Raises:
            Refusal: the recording has no message on one of the topics that are named, or on any, or the offset skips all of them.
        """
        absent = sorted(name for name, topics in self._named.items() if next(self.recording.messages(topics), None) is None)
        if absent:
            raise Refusal(f"topics: {self.recording.path} has no message on {', '.join(absent)}: dcrb info lists the topics that it has")
        _ = self.awaited
        descriptions = dict(self._descriptions)
        with closing(self.bundles()) as bundles:
            next(bundles)
        self._descriptions = descriptions

    def close(self) -> None:
        """Remove the unpacked copies of compressed files."""
        boxes = self.recording.boxes.values() if isinstance(self.recording, VehicleRecording) else ()
        for file in (file for recording in (self.recording, *boxes) for file in recording.stored):
            file.close()

    def start(self) -> list[Message]:
        """Return the messages that precede the first block: the descriptions, as recorded or from the manifest."""
        first = list(self._descriptions.values())
        if isinstance(self.recording, VehicleRecording):
            first += [message for topic in (TRANSFORMS, VEHICLE_DESCRIPTION) for message in islice(self.recording.messages([topic]), 1)]
        return first

    def bundles(self) -> Generator[Bundle, None, None]:
        """Yield the bundles in the order of time, with the sensor description where it is recorded again, or differs.

        Raises:
            Refusal: the offset skips all messages.
        """
        begin = end = start = None
        rate = self.recording.sampling_rate
        waiting: dict[Topic, tuple[Message, bool]] = {}
        collected = list[Message]()
        outcomes = {topic: Outcome(rate) for topic in self._boxes}
        for message in self.recording.messages({*self._descriptions, *self.topics}):
            block = decode_vibration(message.data) if message.topic in outcomes else None
            if block is not None:
                outcomes[message.topic].add_block(block)
            if message.topic in self._descriptions:
                waiting[message.topic] = message, begin is not None
                continue
            start = message.time_ns if start is None else start
            if message.time_ns < start + self._offset_ns:
                continue
            if begin is None or end is None:
                begin = end = message.time_ns
            # A block is sent at its end.
            sent = message.time_ns if block is None else nanoseconds(block.first_index(rate) + len(block.shaft_angle), rate)
            due = max(end, sent)
            if due > end and collected:
                yield Bundle(begin, end, tuple(collected))
                begin, collected = end, []
            end = due
            # A description is sent with the block that it describes, not with the previous one.
            for topic in list(waiting):
                collected += self._unsent(*waiting.pop(topic))
            collected.append(message)
        if begin is None or end is None:
            raise Refusal(f"{self.recording.path} has no message later than {self._offset_ns * 1e-9:g} s after its start: lower the offset")
        yield Bundle(begin, end, tuple(collected))
        compared = [(self._boxes[topic], self._boxes[topic].compared(outcome).mismatch) for topic, outcome in outcomes.items()]
        self.mismatch = "; ".join(f"{box.path}: {mismatch}" for box, mismatch in compared if mismatch)

    def _unsent(self, description: Message, repeated: bool) -> list[Message]:
        """Return a description if it was recorded again or differs from the last one sent."""
        if description.data == self._descriptions[description.topic].data and not repeated:
            return []
        self._descriptions[description.topic] = description
        return [description]


def _refuse_beside_boxes(names: Sequence[str], recording: VehicleRecording) -> None:
    """Refuse names of topics of one box, and of the vehicle, among the topics to replay."""
    for name in names:
        for box in recording.boxes:
            if name.startswith(f"{box_path(box)}/"):
                plain = name.removeprefix(f"{box_path(box)}/")
                raise Refusal(f"topics: {name} belongs to one box: name {plain} for all boxes, or replay {recording.path / box} alone")
        if name in (topic.name for topic in VEHICLE_DETECTED):
            raise Refusal(f"topics: {name} is replayed with {DIAGNOSIS.name}: name that")
        if name in (topic.name for topic in BESIDE):
            raise Refusal(f"topics: {name} of a vehicle is replayed in any case: leave it out")


def _described(recording: Recording, topic: Topic) -> Message:
    """Return the description of the sensor that precedes the first block, as recorded or from the manifest."""
    # Without a manifest, the description that takes its place is the first one.
    recorded = None if recording.described else next(recording.messages((SENSOR,)), None)
    if recorded:
        return Message(topic, recorded.time_ns, recorded.data)
    sensor = recording.manifest.get("sensor")
    return Message(topic, 0, encode_text(sensor_text(recording.configuration) if sensor is None else json.dumps(sensor, sort_keys=True)))
