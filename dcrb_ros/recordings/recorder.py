"""Recording the bench: blocks and messages with a manifest, from which a run can be reproduced. `splitting` writes the rosbag2 folder."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Generic, Protocol, TypeVar

import yaml

from dcrb_ros.messages.cdr import typestore
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import DETECTED, NAMESPACE, SENSOR, SIMULATED, Message, Topic
from dcrb_ros.recordings.manifest import Outcome, opening
from dcrb_ros.recordings.mcap_writer import Channel
from dcrb_ros.recordings.splitting import Bag, RecordingFailed
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Recording as RecordingSettings
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.events import TimedCommand
from dcrb_ros.stream.states import BodyNames


def qos_profiles(topic: Topic) -> list[dict[str, Any]]:
    """Return the offered QoS profiles of a topic as rosbag2 writes them."""
    never = {"sec": 9223372036, "nsec": 854775807}
    return [
        {
            **topic.qos,
            "deadline": never,
            "lifespan": never,
            "liveliness": "automatic",
            "liveliness_lease_duration": never,
            "avoid_ros_namespace_conventions": False,
        }
    ]


def channel_of(topic: Topic, namespace: str) -> Channel:
    """Return the description of a topic in a file."""
    store = typestore(topic.type)
    definition, _ = store.generate_msgdef(topic.type, ros_version=2)
    profiles = str(yaml.safe_dump(qos_profiles(topic), sort_keys=False))
    return Channel(topic.resolved(namespace), topic.type, definition, profiles, store.hash_rihs01(topic.type))


def named_topics(text: str) -> list[str]:
    """Return the names in a text, which commas or spaces separate."""
    return [name for name in re.split(r"[,\s]+", text) if name]


def chosen_topics(text: str, key: str = "recording.topics") -> frozenset[Topic]:
    """Return the topics named in the parameter ``key`` and that of the sensor description; all topics if the text is empty.

    Raises:
        Refusal: a name is not a topic of the bench.
    """
    known = {topic.name: topic for topic in (*SIMULATED, *DETECTED)}
    names = named_topics(text)
    for name in names:
        if name not in known:
            raise Refusal(f"{key}: there is no topic '{name}'{nearest(name, known)} (known: {', '.join(known)})")
    return frozenset(known[name] for name in names or known) | {SENSOR}


def check_topics(*configurations: Configuration, detector: bool = False) -> None:
    """Refuse topics to record that a run never records: of a bearing, of the boxes of a vehicle, or with a ``detector`` beside it.

    Raises:
        Refusal: ``recording.topics`` names such a topic, or one that does not exist.
    """
    text = configurations[0].recording.topics
    chosen_topics(text)
    recorded = [topic.name for topic in SIMULATED if any(topic.enabled(configuration) for configuration in configurations)]
    recorded += [topic.name for topic in DETECTED if detector and topic.recorded]
    for name in named_topics(text):
        if name not in recorded:
            raise Refusal(f"recording.topics: this run does not record '{name}': leave it out (recorded: {', '.join(recorded)})")


class Counted(Protocol):
    """The outcome of a run so far, such as `Outcome`."""

    @property
    def samples(self) -> int:
        """Number of samples."""

    def add(self, message: Message) -> None:
        """Include a message."""

    def records(self) -> dict[str, dict[str, str]]:
        """Return the metadata records at the end of a file."""


Made = TypeVar("Made")
"""The blocks of a run: those of a bench or of a vehicle."""


class RunRecorder(Generic[Made]):
    """Writes the messages of a run to a recording, and removes one that ends before its first sample.

    Raises:
        Refusal: the path exists or cannot be created.
        RecordingFailed: a write failed later.
    """

    def __init__(
        self,
        path: str | Path,
        settings: RecordingSettings,
        namespace: str,
        topics: Collection[Topic],
        counted: Counted,
        opening: Mapping[str, Mapping[str, str]],
        first: Iterable[Message],
        encode: Callable[[Made], Iterable[Message]],
    ) -> None:
        """Begin a recording in a new folder ``path`` with the messages ``first``; ``encode`` returns those of a block.

        Every file begins with the metadata records ``opening``. ``counted`` takes every message, also on other topics than the recorded
        ``topics``, and states at the end of every file what came.
        """
        self._topics, self._namespace, self._counted, self._encode = topics, namespace, counted, encode
        self._channels: dict[Topic, Channel] = {}
        self._bag = Bag(Path(path), opening=opening, closing=counted.records, settings=settings)
        self.path = self._bag.path
        try:
            self.write_messages(first)
            self._bag.flush()
        except RecordingFailed as error:
            shutil.rmtree(self.path, ignore_errors=True)
            raise Refusal(str(error)) from None

    def __enter__(self: Run) -> Run:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        """Finish the recording; one that an error or a signal ends before its first sample is removed."""
        self.close()
        if kind is not None and not self._counted.samples:
            shutil.rmtree(self.path, ignore_errors=True)

    @property
    def file(self) -> Path:
        """The first MCAP file of the recording."""
        return self._bag.files[0]

    def write(self, block: Made) -> None:
        """Record a block."""
        self.write_messages(self._encode(block))

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages; those on topics that are not recorded count in the hash of the samples."""
        if self._bag.open:
            self._bag.write(self._kept(list(messages)))

    def _kept(self, messages: Iterable[Message]) -> Iterator[tuple[Channel, int, bytes]]:
        """Yield the messages on recorded topics; each counts after it is written, so that a split file states its own samples."""
        for message in messages:
            channel = self._channels.get(message.topic)
            if channel is None and message.topic in self._topics:
                channel = self._channels[message.topic] = channel_of(message.topic, self._namespace)
            if channel is not None:
                yield channel, message.time_ns, message.data
            self._counted.add(message)

    def close(self) -> None:
        """Finish the recording; a second call does nothing."""
        self._bag.close()


Run = TypeVar("Run", bound=RunRecorder[Any])


class Recorder(RunRecorder[Block]):
    """Writes a recording of a bench, block by block or message by message; see `RunRecorder`."""

    def __init__(
        self,
        path: str | Path,
        configuration: Configuration,
        bodies: BodyNames,
        *,
        namespace: str = NAMESPACE,
        scenario: Mapping[str, Any] | None = None,
        commands: Iterable[TimedCommand] = (),
        start_ns: int = 0,
    ) -> None:
        """Begin a recording in a new folder ``path``.

        The run has the ``scenario``, as parsed from YAML, if any. The recording begins at ``start_ns``, after the ``commands``.
        """
        settings = configuration.recording
        encoder = BlockEncoder(configuration, bodies)
        self.outcome = Outcome(configuration.sensor.sampling_rate, commands)
        about = opening(configuration, bodies, namespace, scenario=scenario)
        topics = chosen_topics(settings.topics)
        super().__init__(path, settings, namespace, topics, self.outcome, about, encoder.start(start_ns), encoder.encode)
