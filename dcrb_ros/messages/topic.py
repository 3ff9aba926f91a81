"""A topic of the bench: name, type, quality of service (QoS), and how its messages are encoded and decoded."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

from dcrb_ros.messages.cdr import decoded, stamp_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.diagnosis import Diagnosis

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration

NAMESPACE = "/dcrb"
MANIFEST = "dcrb_ros"
"""Name of the metadata record in which a recording describes itself."""

Kind = TypeVar("Kind", bound="Topic")


@dataclass(frozen=True)
class Topic:
    """A topic relative to the namespace, or absolute."""

    name: str
    type: str
    """ROS message type, ``package/msg/Type``."""
    content: str
    """Content of its messages, for the documentation."""
    depth: int = 200
    """Messages kept for a slow subscriber."""
    latched: bool = False
    """Whether a late subscriber receives the last message."""
    decode: Callable[[bytes], Any] | None = None
    """Decodes a message; without it the message is decoded to the class of its type."""

    def __hash__(self) -> int:
        """Return the hash of the name: every message looks its topic up several times."""
        return hash(self.name)

    @property
    def qos(self) -> dict[str, Any]:
        """Quality of service with which it is published and recorded: the policies as ROS names them."""
        durability = "transient_local" if self.latched else "volatile"
        return {"history": "keep_last", "depth": self.depth, "reliability": "reliable", "durability": durability}

    def resolved(self, namespace: str) -> str:
        """Return the absolute name."""
        return self.name if self.name.startswith("/") else f"{namespace.rstrip('/')}/{self.name}"

    def below(self: Kind, prefix: str) -> Kind:
        """Return the same topic below a relative namespace, such as that of an axle box."""
        return replace(self, name=self.resolved(prefix))

    def decoded(self, data: bytes) -> Any:
        """Return what a message carries.

        Raises:
            Refusal: the bytes are not such a message.
        """
        return self.decode(data) if self.decode else decoded(data, self.type)

    def stamp(self, data: bytes) -> int:
        """Return the stamp of a message with a header [ns].

        Raises:
            Refusal: the bytes are not such a message.
        """
        return stamp_of(decoded(data, self.type).header)


@dataclass(frozen=True)
class Message:
    """An encoded message: the same bytes are published and recorded."""

    topic: Topic
    time_ns: int
    """Simulated time of the header [ns]."""
    data: bytes
    """The message in CDR."""

    @property
    def content(self) -> Any:
        """Content of the message, as its topic decodes it."""
        return self.topic.decoded(self.data)


def chosen_topics(topics: Iterable[Topic]) -> tuple[Topic, ...]:
    """Return the topics that a reader is asked for.

    Raises:
        Refusal: they are not topics, such as names.
    """
    chosen = tuple(topics) if isinstance(topics, Iterable) else (topics,)
    for topic in chosen:
        if not isinstance(topic, Topic):
            raise Refusal(f"topics: {topic!r} is not a topic: give those of dcrb_ros.messages.topics, such as [DIAGNOSIS]")
    return chosen


@dataclass(frozen=True)
class EncodedBench:
    """The bench whose blocks are encoded."""

    configuration: Configuration
    bodies: Sequence[str]
    """Names of the bodies in the order of the states."""

    @property
    def frame(self) -> str:
        """Frame of the sensor's messages."""
        return self.configuration.publishing.frame

    def after(self, block: Block) -> EncodedBench:
        """Return the source with the sensor's range at the end of a block."""
        sensor = self.configuration.sensor
        if block.range in (0.0, sensor.range):
            return self
        changed = sensor.model_copy(update={"range": block.range})
        return replace(self, configuration=self.configuration.model_copy(update={"sensor": changed}))


Encoded = Iterable[tuple[int, bytes]]
"""Encoded messages, each with its simulated time [ns]."""


def per_block(encode: Callable[[Block, str], bytes]) -> Callable[[Block, EncodedBench], Encoded]:
    """Return the encoder of a topic with a message per block that is not lost, from one of a block and a frame id."""
    return lambda block, source: () if block.lost else ((block.stamp_ns, encode(block, source.frame)),)


@dataclass(frozen=True)
class SimulatedTopic(Topic):
    """A topic of the simulator, encoded from the blocks of a simulation."""

    __hash__ = Topic.__hash__

    encode: Callable[[Block, EncodedBench], Encoded] = lambda block, source: ()
    """Returns the messages of a block."""
    begin: Callable[[EncodedBench], Callable[[Block, EncodedBench], Encoded]] | None = None
    """Returns what takes the place of ``encode`` in one run, for a topic whose messages depend on earlier blocks."""
    start: Callable[[EncodedBench], bytes] | None = None
    """Returns the message that precedes the first block."""
    enabled: Callable[[Configuration], bool] = lambda configuration: True
    """Tells whether the topic is published with a configuration."""


@dataclass(frozen=True)
class DetectedTopic(Topic):
    """A topic of the fault detector, encoded from its diagnoses."""

    __hash__ = Topic.__hash__

    encode: Callable[[Diagnosis, str], bytes | None] = lambda diagnosis, frame: None
    """Returns the message of a diagnosis with a frame id, or none."""
    recorded: bool = True
    """Whether a running simulator records it beside its own topics."""
