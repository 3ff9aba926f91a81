"""Bags as `ros2 bag record -a` leaves them beside a bench: no manifest, log times of the wall clock, any storage and compression."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from made_up_blocks import BODIES, encoded
from ros_types import typestore
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import NAMESPACE, Message, Topic
from dcrb_ros.settings.configuration import Configuration

FORMS = {
    "mcap": (StoragePlugin.MCAP, None),
    "mcap_zstd_file": (StoragePlugin.MCAP, CompressionMode.FILE),
    "mcap_zstd_messages": (StoragePlugin.MCAP, CompressionMode.MESSAGE),
    "mcap_zstd_chunks": (StoragePlugin.MCAP, CompressionMode.STORAGE),
    "sqlite3": (StoragePlugin.SQLITE3, None),
    "sqlite3_zstd_file": (StoragePlugin.SQLITE3, CompressionMode.FILE),
    "sqlite3_zstd_messages": (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
}
"""Storage and compression by name."""
WALL_NS = 1_795_337_994_178_865_448
"""Wall-clock time of the first message [ns]."""


def messages_of(count: int) -> list[Message]:
    """Return the messages of a bench that publishes blocks of noise."""
    return [*BlockEncoder(Configuration(), BODIES).start(), *encoded(count)]


def bag_of(path: Path, messages: Iterable[Message], form: str = "mcap", *, namespace: str = NAMESPACE) -> Path:
    """Write messages to a bag, received at intervals of a millisecond of wall time."""
    storage, compression = FORMS[form]
    writer = Writer(path, version=9, storage_plugin=storage)
    if compression is not None:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    connections: dict[Topic, object] = {}
    with writer:
        for number, message in enumerate(messages):
            topic = message.topic
            if topic not in connections:
                connections[topic] = writer.add_connection(topic.resolved(namespace), topic.type, typestore=typestore())
            writer.write(connections[topic], WALL_NS + number * 1_000_000, message.data)  # type: ignore[arg-type]
    return path
