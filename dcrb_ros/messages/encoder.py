"""Blocks and diagnoses to messages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from dcrb_ros.messages.cdr import FRAME
from dcrb_ros.messages.topic import EncodedBench, Message, Topic
from dcrb_ros.messages.topics import DETECTED, SIMULATED
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.stream.states import BodyNames

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration


class BlockEncoder:
    """Encodes the blocks of a simulation for all topics of the simulator."""

    def __init__(self, configuration: Configuration, bodies: BodyNames, topics: Mapping[Topic, Topic] | None = None) -> None:
        """Prepare for a bench whose bodies have the names ``bodies``; ``topics`` take the place of those of `SIMULATED`."""
        self._source = EncodedBench(configuration, tuple(bodies.names))
        self._plain = [topic for topic in SIMULATED if topic.enabled(configuration)]
        self._topics = [topics[topic] for topic in self._plain] if topics is not None else self._plain
        self._encoders = [topic.begin(self._source) if topic.begin else topic.encode for topic in self._plain]

    def start(self, time_ns: int = 0) -> list[Message]:
        """Return the messages that precede the first block, which begins at ``time_ns``."""
        each = zip(self._topics, self._plain, strict=True)
        return [Message(topic, time_ns, plain.start(self._source)) for topic, plain in each if plain.start]

    def encode(self, block: Block) -> list[Message]:
        """Return the messages of a block, sorted by time."""
        each = zip(self._topics, self._encoders, strict=True)
        messages = [Message(topic, time_ns, data) for topic, encode in each for time_ns, data in encode(block, self._source)]
        self._source = self._source.after(block)
        return sorted(messages, key=lambda message: message.time_ns)


def diagnosis_messages(diagnosis: Diagnosis, frame: str = FRAME) -> list[Message]:
    """Return the messages of a diagnosis on all topics of the detector, with the frame id of the sensor."""
    messages = ((topic, topic.encode(diagnosis, frame)) for topic in DETECTED)
    return [Message(topic, diagnosis.time_ns, data) for topic, data in messages if data is not None]
