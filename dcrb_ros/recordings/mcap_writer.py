"""Writing an MCAP file: small chunks that reach the disk early, a valid end even after a failure."""

from __future__ import annotations

import contextlib
import os
import re
import struct
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO

import yaml
from mcap import records
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from dcrb_ros.runtime.version import __version__
from dcrb_ros.text.yaml import parsed

CHUNK = 256 * 1024
"""Chunk size [bytes]: a crash loses at most one chunk, and at most `FLUSH_PERIOD_NS` of signal."""
FLUSH_PERIOD_NS = 500_000_000
"""Simulated time after which buffered messages are written [ns]: half of the second that a crash may lose."""
COMPRESSIONS = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}
POLICIES = {
    "history": ("system_default", "keep_last", "keep_all", "unknown"),
    "reliability": ("system_default", "reliable", "best_effort", "unknown", "best_available"),
    "durability": ("system_default", "transient_local", "volatile", "unknown", "best_available"),
    "liveliness": ("system_default", "automatic", "manual_by_node", "manual_by_topic", "unknown", "best_available"),
}
"""Names of the policies in a QoS profile by their numbers, which rosbag2 wrote before version 9 of its metadata (`rmw/types.h`)."""
NUMBERED_POLICY = re.compile(rf"\b({'|'.join(POLICIES)}): ([0-5])\b")
"""A policy given by its number."""
MINIMAL_END = struct.pack("<BQI", Opcode.DATA_END, 4, 0) + struct.pack("<BQQQI", Opcode.FOOTER, 20, 0, 0, 0) + MCAP0_MAGIC
"""The end of an MCAP file without a summary."""


@dataclass(frozen=True)
class Channel:
    """Description of a topic in an MCAP file."""

    name: str
    """Absolute name of the topic."""
    type: str
    definition: str
    """Text of the message definition, including those of nested messages."""
    qos: str
    """Offered QoS profiles, a YAML sequence."""
    type_hash: str

    def __hash__(self) -> int:
        """Return the hash of the name: every message looks its channel up several times."""
        return hash(self.name)

    @cached_property
    def latched(self) -> bool:
        """Whether a late subscriber receives the last message."""
        return any(isinstance(profile, dict) and profile.get("durability") == "transient_local" for profile in self.profiles())

    def profiles(self) -> list[Any]:
        """Return the offered QoS profiles; an empty list if the text is not a YAML sequence."""
        try:
            profiles = parsed(self.qos)
        except yaml.YAMLError:
            return []
        return profiles if isinstance(profiles, list) else []


def described_channel(channel: records.Channel, schema: records.Schema) -> Channel:
    """Return the description of a topic that its records in a file give."""
    about, definition = channel.metadata, schema.data.decode("utf-8", errors="replace")
    qos = NUMBERED_POLICY.sub(_named_policy, about.get("offered_qos_profiles", "[]"))
    return Channel(channel.topic, schema.name, definition, qos, about.get("topic_type_hash", ""))


def _named_policy(numbered: re.Match[str]) -> str:
    """Return a policy by its name, or by its number if it has none."""
    key, number = numbered[1], int(numbered[2])
    return f"{key}: {POLICIES[key][number] if number < len(POLICIES[key]) else number}"


@dataclass(frozen=True)
class Span:
    """Simulated time of the first and the last of some messages [ns]."""

    first_ns: int | None = None
    last_ns: int = 0

    @property
    def duration_ns(self) -> int:
        """Time from the first to the last [ns]."""
        return self.last_ns - (self.first_ns or 0) if self.first_ns is not None else 0

    def union(self, other: Span) -> Span:
        """Return the span of the messages of both."""
        if self.first_ns is None or other.first_ns is None:
            return other if self.first_ns is None else self
        return Span(min(self.first_ns, other.first_ns), max(self.last_ns, other.last_ns))


class McapFile:
    """An MCAP file being written."""

    def __init__(self, path: Path, opening: Mapping[str, Mapping[str, str]], compression: str) -> None:
        """Create the file with the metadata records ``opening``.

        Raises:
            OSError: it cannot be written; nothing is left behind.
        """
        self.path = path
        self.span = Span()
        self.counts: Counter[Channel] = Counter()
        self._ids: dict[Channel, int] = {}
        self._schemas: dict[tuple[str, str], int] = {}
        self._flushed_ns = self._valid_size = 0
        self._complete = False
        self._stream: BinaryIO = open(path, "wb")  # noqa: SIM115 - closed in close() or _release()
        try:
            self._writer = Writer(self._stream, chunk_size=CHUNK, compression=COMPRESSIONS[compression])
            self._writer.start(profile="ros2", library=f"dcrb_ros {__version__}")
            for name, record in opening.items():
                self._writer.add_metadata(name, dict(record))
            self.flush()
        except OSError:
            self._release()
            with contextlib.suppress(OSError):
                self.path.unlink()
            raise

    @property
    def size(self) -> int:
        """Size of the file without the unfinished chunk [bytes]."""
        return self._stream.tell()

    def write(self, channel: Channel, time_ns: int, data: bytes, sequence: int) -> None:
        """Write a message; its simulated time [ns] is both log time and publish time."""
        self._writer.add_message(self._id(channel), time_ns, data, time_ns, sequence & 0xFFFFFFFF)
        self.counts[channel] += 1
        if self.span.first_ns is None or not self.span.first_ns <= time_ns <= self.span.last_ns:
            self.span = self.span.union(Span(time_ns, time_ns))

    def flush_due(self) -> None:
        """Write finished chunks to the file, and the unfinished one every `FLUSH_PERIOD_NS`."""
        if self.span.last_ns - self._flushed_ns >= FLUSH_PERIOD_NS:
            self.flush()
        elif self._stream.tell() != self._valid_size:
            self._stream.flush()
            self._valid_size = self._stream.tell()

    def flush(self) -> None:
        """Write everything to the file."""
        self._writer.flush()
        self._valid_size, self._flushed_ns = self._stream.tell(), self.span.last_ns

    def close(self, closing: Mapping[str, Mapping[str, str]]) -> None:
        """Write the last metadata records and the summary, and wait until the file is on the disk."""
        self.flush()
        for name, record in closing.items():
            self._writer.add_metadata(name, dict(record))
        self._writer.finish()
        self._stream.flush()
        os.fsync(self._stream.fileno())
        self._stream.close()
        self._complete = True

    def abandon(self) -> None:
        """Truncate the file after the last valid record and append a minimal end, which takes 50 bytes, so that any reader accepts it."""
        if self._complete:
            return
        self._release()
        try:
            os.truncate(self.path, self._valid_size)
            with self.path.open("ab") as stream:
                stream.write(MINIMAL_END)
        except OSError:
            # The file ends within a record, which our reader and `dcrb recover` accept.
            return

    def _release(self) -> None:
        # Closing attempts to write the rest once more; the descriptor is closed in any case.
        with contextlib.suppress(OSError):
            self._stream.close()

    def _id(self, channel: Channel) -> int:
        number = self._ids.get(channel)
        if number is None:
            about = {"offered_qos_profiles": channel.qos, "topic_type_hash": channel.type_hash}
            number = self._ids[channel] = self._writer.register_channel(channel.name, "cdr", self._schema(channel), about)
        return number

    def _schema(self, channel: Channel) -> int:
        key = channel.type, channel.definition
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(channel.type, "ros2msg", channel.definition.encode())
        return self._schemas[key]
