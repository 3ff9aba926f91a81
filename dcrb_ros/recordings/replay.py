"""A recording as a source: which messages come out together, and when."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass

from dcrb_ros.messages.description import sensor_text
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.topics import SENSOR, SIMULATED, VIBRATION, Message, Topic
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import chosen_topics
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.runtime.simulated_time import nanoseconds
from dcrb_ros.schema.fields import Group, choice, quantity


class ReplayParameters(Group):
    """What is replayed, and how."""

    bag: str = choice("", "Recording to replay: a folder or an .mcap file")
    rate: float = quantity(
        1.0, "-", "Recorded over wall time; 0 for as fast as possible", 0.0, 1000.0, remedy="1.0 is the recorded pace", run_time=True
    )
    loop: bool = choice(False, "Begin again at the end, for ever; the stamps begin again too")
    offset: float = quantity(0.0, "s", "Recorded time to skip at the beginning", 0.0, 1e6)
    clock: bool = choice(False, "Publish /clock, the recorded time")
    topics: str = choice("", "Topics to replay, such as 'outer_ring/vibration, diagnosis'; empty for what the simulator publishes")
    listeners: int = quantity(1, "-", "Subscribers to the waveform to wait for before the first block", 0, 1000)
    wait: float = quantity(3.0, "s", "Longest wall time to wait for them", 0.0, 1e4)


@dataclass(frozen=True)
class Bundle:
    """Messages that come out at the same time, in the recorded order."""

    begin_ns: int
    """Recorded time since which nothing came [ns]."""
    due_ns: int
    """Recorded time at which they are due [ns]."""
    messages: tuple[Message, ...]


class Replay:
    """The messages of a recording in bundles, as the live node sends them: a block, and what belongs to it, at the block's end.

    Raises:
        Refusal: there is no recording, or an unknown topic is asked for.
    """

    def __init__(self, parameters: ReplayParameters) -> None:
        if not parameters.bag:
            raise Refusal("there is nothing to replay: name a recording by the parameter bag")
        self.recording = Recording(parameters.bag)
        self._offset_ns = round(parameters.offset * 1e9)
        asked = sorted(chosen_topics(parameters.topics), key=lambda topic: topic.name) if parameters.topics else SIMULATED
        self.topics: tuple[Topic, ...] = tuple(asked)
        found = next(self.recording.messages((SENSOR,)), None)
        self._first = found or Message(SENSOR, 0, encode_text(_sensor(self.recording)))
        self._told = self._first

    def start(self) -> list[Message]:
        """Return what comes before the first block: the sensor's description, recorded or from the manifest."""
        return [self._first]

    def bundles(self) -> Iterator[Bundle]:
        """Yield the bundles in their order; the sensor's description is in one where it is another than the last.

        Raises:
            Refusal: no message is left behind the offset.
        """
        begin = due = start = None
        described, waiting = self._first, list[Message]()
        for message in self.recording.messages({SENSOR, *self.topics}):
            if message.topic == SENSOR:
                described = message
                continue
            start = message.time_ns if start is None else start
            if message.time_ns < start + self._offset_ns:
                continue
            if begin is None or due is None:
                begin = due = message.time_ns
            end = max(due, self._end_of(message))
            if end > due and waiting:
                yield Bundle(begin, due, tuple(waiting))
                begin, waiting = due, []
            due = end
            # A description goes out with what it describes, not with the block before.
            waiting += [*self._news(described), message]
        if begin is None or due is None:
            raise Refusal(
                f"{self.recording.path} has no message to replay {self._offset_ns * 1e-9:g} s after its beginning: lower the offset"
            )
        yield Bundle(begin, due, tuple(waiting))

    def _news(self, described: Message) -> list[Message]:
        """Return a description if it says something else than the last one."""
        if described.data == self._told.data:
            return []
        self._told = described
        return [described]

    def _end_of(self, message: Message) -> int:
        """Return when a message is due [ns]: a block of the waveform at its end, anything else at its time."""
        if message.topic != VIBRATION:
            return message.time_ns
        block, rate = decode_vibration(message.data), self.recording.sampling_rate
        return nanoseconds(block.first_index(rate) + len(block.shaft_angle), rate)


def _sensor(recording: Recording) -> str:
    about = recording.manifest.get("sensor")
    return sensor_text(recording.configuration) if about is None else json.dumps(about, sort_keys=True)
