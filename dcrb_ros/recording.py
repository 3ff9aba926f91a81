"""Reading recordings back: whole ones and what is left of cut-off ones."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from mcap.records import Channel, Metadata
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader

from dcrb_ros.configuration import Configuration
from dcrb_ros.messages import Vibration, decode_vibration
from dcrb_ros.refusal import Refusal
from dcrb_ros.topics import DETECTED, MANIFEST, NAMESPACE, SIMULATED, VIBRATION, Message, Topic

MAGIC = b"\x89MCAP0\r\n"
LARGEST_RECORD = 64 * 1024 * 1024
"""Largest record or unpacked chunk that is read [bytes]; ours have a quarter of a megabyte."""


class Recording:
    """A recording of the bench: a rosbag2 folder or a single MCAP file.

    Raises:
        Refusal: there is no recording, or it is not one of the bench.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.files = _files(self.path)
        self.complete = True
        """Whether everything was read to its end; false after reading a cut-off file."""
        self.configuration, self.manifest = self._manifest()

    def messages(self, topics: Iterable[Topic] | None = None, *, namespace: str = NAMESPACE) -> Iterator[Message]:
        """Yield the messages of some topics, or of all that the bench knows, as they lie in the file."""
        wanted = {topic.resolved(namespace): topic for topic in (topics or (*SIMULATED, *DETECTED))}
        for channel, message in self._records():
            if channel.topic in wanted:
                yield Message(wanted[channel.topic], message.log_time, message.data)

    def vibrations(self) -> Iterator[Vibration]:
        """Yield the blocks of the waveform.

        Raises:
            Refusal: the recording has no waveform.
        """
        found = False
        for message in self.messages((VIBRATION,)):
            found = True
            yield decode_vibration(message.data)
        if not found:
            raise Refusal(f"{self.path} holds no messages on {VIBRATION.resolved(NAMESPACE)}: give a recording of the bench")

    def counts(self) -> dict[str, int]:
        """Return the messages per topic."""
        return dict(sorted(Counter(channel.topic for channel, _ in self._records()).items()))

    def _manifest(self) -> tuple[Configuration, dict[str, Any]]:
        for record in self._stream():
            if isinstance(record, Metadata) and record.name == MANIFEST:
                try:
                    found: dict[str, Any] = json.loads(record.metadata["manifest"])
                    return Configuration.model_validate(found["configuration"]), found
                except (ValueError, KeyError, TypeError):
                    break
            if isinstance(record, McapMessage):
                break
        raise Refusal(f"{self.path} carries no manifest of the bench: give a recording made by dcrb simulate or dcrb bench")

    def _records(self) -> Iterator[tuple[Channel, McapMessage]]:
        channels: dict[int, Channel] = {}
        for record in self._stream():
            if isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, McapMessage) and record.channel_id in channels:
                yield channels[record.channel_id], record

    def _stream(self) -> Iterator[Any]:
        """Yield the records of all files; stop where a file is cut off or damaged and remember it."""
        for file in self.files:
            with file.open("rb") as stream:
                try:
                    yield from StreamReader(stream, record_size_limit=LARGEST_RECORD, validate_crcs=True).records
                except Exception:  # a damaged record breaks reader or decompressor anywhere, each in its own way
                    self.complete = False


def _files(path: Path) -> list[Path]:
    """Return the MCAP files of a folder or a single one, checked by their first bytes."""
    if not path.exists():
        raise Refusal(f"there is no recording {path}: give a folder made by dcrb simulate or dcrb bench, or an .mcap file")
    files = sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    if not files:
        raise Refusal(f"{path} holds no .mcap file: give the folder of a recording")
    for file in files:
        try:
            with file.open("rb") as stream:
                magic = stream.read(len(MAGIC))
        except OSError as error:
            raise Refusal(f"{file} cannot be read: {error.strerror}") from None
        if magic != MAGIC:
            raise Refusal(f"{file} is no MCAP file: it must begin with {MAGIC!r}")
    return files
