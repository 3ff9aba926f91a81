"""The MCAP recorder: a rosbag2 folder that plays in ROS, opens in Rerun and explains itself."""

from __future__ import annotations

import json
import os
import shutil
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

import yaml
from mcap.writer import CompressionType, Writer
from rosbags.typesys.store import Typestore

from dcrb_ros import __version__
from dcrb_ros.block import Block, Layout
from dcrb_ros.configuration import Configuration
from dcrb_ros.messages import BlockEncoder, typestore
from dcrb_ros.refusal import Refusal
from dcrb_ros.topics import MANIFEST, NAMESPACE, Message, Topic

CHUNK = 256 * 1024
"""Chunk size [bytes]: what a crash can lose at most beside the last second."""
FLUSH_EVERY = 1_000_000_000
"""Simulated time after which what is buffered goes to the file [ns]."""
SECOND = 1_000_000_000


class RecordingFailed(RuntimeError):
    """Writing failed (a full disk, say); what was flushed before is readable."""


def new_folder(path: Path) -> Path:
    """Create the folder of a recording.

    Raises:
        Refusal: it exists or cannot be created.
    """
    if path.exists():
        raise Refusal(f"{path} exists: give another name or remove it, a recording is never overwritten")
    try:
        path.mkdir(parents=True)
    except OSError as error:
        raise Refusal(f"{path} cannot be created: {error.strerror}; give a folder that can be written") from None
    return path


def quality(topic: Topic) -> list[dict[str, Any]]:
    """Return the offered QoS of a topic as rosbag2 writes it."""
    never = {"sec": 9223372036, "nsec": 854775807}
    return [
        {
            "history": "keep_last",
            "depth": topic.depth,
            "reliability": "reliable",
            "durability": "transient_local" if topic.latched else "volatile",
            "deadline": never,
            "lifespan": never,
            "liveliness": "automatic",
            "liveliness_lease_duration": never,
            "avoid_ros_namespace_conventions": False,
        }
    ]


def manifest(configuration: Configuration, layout: Layout) -> dict[str, Any]:
    """Return what makes a recording explain and reproduce itself."""
    return {
        "dcrb_ros": __version__,
        "configuration": configuration.model_dump(),
        "seed": configuration.simulation.seed,
        "bodies": layout.names,
        "sampling_rate": configuration.sensor.sampling_rate,
        "units": {"acceleration": "m/s^2", "angle": "rad", "speed": "rad/s", "force": "N", "time": "simulated, from zero"},
        "recorded": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
    }


class Recorder:
    """A sink of blocks or messages that writes a recording.

    Raises:
        Refusal: the path exists or cannot be created.
        RecordingFailed: a write failed later.
    """

    def __init__(
        self, path: str | Path, configuration: Configuration, layout: Layout, *, namespace: str = NAMESPACE, start_ns: int = 0
    ) -> None:
        self.path = new_folder(Path(path))
        self._namespace = namespace
        self._encoder = BlockEncoder(configuration, layout)
        self._channels: dict[Topic, int] = {}
        self._counts: Counter[Topic] = Counter()
        self._first_ns: int | None = None
        self._last_ns = self._flushed_ns = 0
        self._open = True
        self._compression = configuration.recording.compression
        self._file_name = f"{self.path.name}_0.mcap"
        try:
            self._begin(configuration, layout, start_ns)
        except OSError as error:
            shutil.rmtree(self.path, ignore_errors=True)
            raise Refusal(f"{self.path} cannot be written: {error.strerror}; make room or give another folder") from None

    def _begin(self, configuration: Configuration, layout: Layout, start_ns: int) -> None:
        """Open the file and write what comes before the first block."""
        self._stream: BinaryIO = open(self.path / self._file_name, "wb")  # noqa: SIM115 - closed in close()
        compression = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}[self._compression]
        self._writer = Writer(self._stream, chunk_size=CHUNK, compression=compression)
        self._writer.start(profile="ros2", library=f"dcrb_ros {__version__}")
        self._writer.add_metadata(MANIFEST, {"manifest": json.dumps(manifest(configuration, layout))})
        self._write_metadata()
        for message in self._encoder.start(start_ns):
            self._write(message)
        self._writer.flush()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    @property
    def file(self) -> Path:
        """The MCAP file of the recording."""
        return self.path / self._file_name

    def write(self, block: Block) -> None:
        """Record a block."""
        self.write_messages(self._encoder.encode(block))

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages; their simulated time is log time and publish time."""
        if not self._open:
            return
        try:
            for message in messages:
                self._write(message)
            if self._last_ns - self._flushed_ns >= FLUSH_EVERY:
                self._writer.flush()
                self._flushed_ns = self._last_ns
        except OSError as error:
            self._abandon()
            raise RecordingFailed(f"the recording {self.path} ended at {self._last_ns / SECOND:.1f} s: {error.strerror}") from None

    def _write(self, message: Message) -> None:
        channel = self._channels.get(message.topic)
        if channel is None:
            channel = self._channels[message.topic] = self._register(message.topic)
        self._writer.add_message(channel, message.time_ns, message.data, message.time_ns, self._counts[message.topic])
        self._counts[message.topic] += 1
        self._first_ns = message.time_ns if self._first_ns is None else min(self._first_ns, message.time_ns)
        self._last_ns = max(self._last_ns, message.time_ns)

    def _register(self, topic: Topic) -> int:
        store: Typestore = typestore()
        text, _ = store.generate_msgdef(topic.type, ros_version=2)
        schema = self._writer.register_schema(topic.type, "ros2msg", text.encode())
        about = {
            "offered_qos_profiles": yaml.safe_dump(quality(topic), sort_keys=False),
            "topic_type_hash": store.hash_rihs01(topic.type),
        }
        return self._writer.register_channel(topic.resolved(self._namespace), "cdr", schema, about)

    def close(self) -> None:
        """Finish the recording; a second call does nothing."""
        if not self._open:
            return
        try:
            self._writer.add_metadata("rosbag2", {"serialized_metadata": yaml.safe_dump(self._metadata(), sort_keys=False)})
            self._writer.finish()
            self._stream.close()
            self._write_metadata()
        except OSError as error:
            self._abandon()
            raise RecordingFailed(f"the recording {self.path} could not be finished: {error.strerror}") from None
        self._open = False

    def _abandon(self) -> None:
        """Give up writing; what is in the file stays."""
        self._open = False
        try:
            self._stream.close()
        except OSError:
            # Closing tries to write the rest once more; the descriptor is closed all the same.
            return

    def _metadata(self) -> dict[str, Any]:
        first = self._first_ns or 0
        store = typestore()
        span = {"nanoseconds": self._last_ns - first}
        start = {"nanoseconds_since_epoch": first}
        total = sum(self._counts.values())
        topics = [
            {
                "topic_metadata": {
                    "name": topic.resolved(self._namespace),
                    "type": topic.type,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": quality(topic),
                    "type_description_hash": store.hash_rihs01(topic.type),
                },
                "message_count": count,
            }
            for topic, count in self._counts.items()
        ]
        return {
            "version": 9,
            "storage_identifier": "mcap",
            "duration": span,
            "starting_time": start,
            "message_count": total,
            "topics_with_message_count": topics,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self._file_name],
            "files": [{"path": self._file_name, "starting_time": start, "duration": span, "message_count": total}],
            "custom_data": {"dcrb_ros": __version__},
            "ros_distro": "jazzy",
        }

    def _write_metadata(self) -> None:
        """Write metadata.yaml so that it is there whole or not at all."""
        temporary = self.path / ".metadata.yaml"
        temporary.write_text(yaml.safe_dump({"rosbag2_bagfile_information": self._metadata()}, sort_keys=False), encoding="utf-8")
        os.replace(temporary, self.path / "metadata.yaml")
