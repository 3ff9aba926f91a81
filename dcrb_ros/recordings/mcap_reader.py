"""Reading the records of an MCAP file as far as it is intact, with memory that is limited independently of the sizes in the file."""

from __future__ import annotations

import os
import struct
import zlib
from abc import ABC, abstractmethod
from collections.abc import Container, Iterator, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, ChunkIndex, Footer, Header, Message, Metadata, Schema

from dcrb_ros.text.files import open_regular

MAGIC = b"\x89MCAP0\r\n"
MAX_RECORD = 64 * 1024 * 1024
"""Largest record that is read, compressed or not [bytes]; those of the recorder have a quarter of a megabyte."""
MAX_RATIO = 80
"""Largest size of a file's unpacked chunks relative to the file [-]; the recorder of the bench reaches 44 with a constant signal."""
LEAST_UNPACKED = 16 * 1024 * 1024
"""Size up to which the chunks of a file of any size are unpacked [bytes]."""
MAX_DAMAGE = 100
"""Sentences about damage that are kept."""
HEAD = struct.Struct("<BQ")
"""Opcode and length, which precede every record."""
MESSAGE = struct.Struct("<HIQQ")
"""Channel, sequence, log time and publish time, which precede the data of a message."""
CHANNEL = struct.Struct("<H")
"""The first of them, the channel."""
CHUNK_START = struct.Struct("<QQQ")
"""First and last time in a chunk and its position in the file, at the beginning of the chunk index."""
FOOTER_FIELDS = struct.Struct("<QQI")
"""Positions of the summary and of its offsets, and the checksum of all of the summary before the checksum; 0 for none."""
FOOTER = HEAD.size + FOOTER_FIELDS.size
"""Size of the footer [bytes]; the magic bytes follow it."""
CHECKSUM = 4
"""Size of the checksum in the footer [bytes]."""
KINDS: dict[int, Any] = {
    Opcode.HEADER: Header,
    Opcode.FOOTER: Footer,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK: Chunk,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.ATTACHMENT: Attachment,
    Opcode.METADATA: Metadata,
}


class FileRecords(ABC):
    """The records of a file in the form of MCAP; iterating collects in `damage` a sentence for everything that cannot be read."""

    def __init__(
        self, path: Path, *, chunks: bool = True, topics: Container[str] | None = None, name: str = "", stored: int | None = None
    ) -> None:
        """Read ``path``.

        Args:
            path: the file.
            chunks: whether to read the chunks; without them only the records between them are read, which is fast.
            topics: the topics whose messages are read; by default all.
            name: name of the file in sentences about damage; by default that of ``path``.
            stored: size of the file from which ``path`` was unpacked [bytes]; by default it was not.
        """
        self.path, self._chunks, self._topics, self._name, self._stored = path, chunks, topics, name or path.name, stored
        self.damage: list[str] = []

    @abstractmethod
    def __iter__(self) -> Iterator[Any]:
        """Yield schemas, channels, messages and metadata as records of MCAP."""

    def _report(self, sentence: str) -> None:
        if len(self.damage) < MAX_DAMAGE:
            self.damage.append(f"{self._name}: {sentence}")


class McapRecords(FileRecords):
    """The records of an MCAP file, including those in chunks."""

    def __init__(self, path: Path, **options: Any) -> None:
        super().__init__(path, **options)
        self._summarized: dict[tuple[type[Any], int], Any] = {}
        """Schemas and channels in the summary by kind and number."""
        self._skipped: set[int] = set()
        """Channels of other topics."""
        self._unpacked = self._most_unpacked = 0
        """Size of the chunks that have been unpacked so far, and its limit [bytes]."""

    def __iter__(self) -> Iterator[Any]:
        self.damage, self._unpacked = [], 0
        with open_regular(self.path) as stream:
            size = os.fstat(stream.fileno()).st_size
            # In an unpacked file, chunks that are not compressed themselves have its size.
            most = MAX_RATIO * size if self._stored is None else max(size, MAX_RATIO * self._stored)
            self._most_unpacked = max(LEAST_UNPACKED, most)
            if stream.read(len(MAGIC)) != MAGIC:
                self._report("it does not begin as an MCAP file")
                return
            summary = _summary(stream, size)
            if summary.changed:
                self._report("the summary does not match its checksum, so it is not used")
            self._summarized = {(type(record), record.id): record for record in summary.known}
            if any(self._summarized[type(record), record.id] != record for record in summary.known):
                self._report("the summary gives one number to two schemas or channels, so it is not used")
                summary, self._summarized = Summary(changed=True), {}
            for record in summary.known:
                self._register(record)
                yield record
            yield from self._data(stream, size, summary)

    def _data(self, stream: BinaryIO, size: int, summary: Summary) -> Iterator[Any]:
        """Yield the records up to the footer, or to a changed summary; after an invalid length continue at the next chunk."""
        offset = len(MAGIC)
        while True:
            stream.seek(offset)
            head = stream.read(HEAD.size)
            opcode, length = HEAD.unpack(head) if len(head) == HEAD.size else (0, size)
            if offset + HEAD.size + length > size or not opcode:
                missing = "the footer is missing" if offset == size else f"the record at byte {offset} reaches beyond the end of the file"
                self._report(f"{missing} at {size}")
                later = [start for start in summary.chunks if offset < start < size]
                if not later:
                    return
                offset = later[0]
                continue
            yield from self._record(stream, opcode, length, offset)
            if opcode == Opcode.FOOTER or (opcode == Opcode.DATA_END and summary.changed):
                return
            offset += HEAD.size + length

    def _record(self, stream: BinaryIO, opcode: int, length: int, offset: int) -> Iterator[Any]:
        if opcode in (Opcode.FOOTER, Opcode.CHUNK_INDEX) or (opcode not in KINDS and opcode != Opcode.MESSAGE):
            return
        if opcode == Opcode.CHUNK and (not self._chunks or self._unpacked > self._most_unpacked):
            return
        if length > MAX_RECORD:
            self._report(f"the record at byte {offset} claims {length} bytes; at most {MAX_RECORD} are read")
            return
        try:
            payload = stream.read(length)
            if opcode == Opcode.MESSAGE and CHANNEL.unpack_from(payload)[0] in self._skipped:
                return
            record = parsed(opcode, payload)
            if isinstance(record, Chunk):
                self._check_unpacked(record)
                data = decompressed(record)
            else:
                self._register(record)
                yield record
                return
        except Exception as error:  # parser and decompressor raise various exceptions for damaged data
            self._report(f"the record at byte {offset} is damaged ({_reason(error)})")
            return
        yield from self._in_chunk(data, offset)

    def _check_unpacked(self, chunk: Chunk) -> None:
        """Count the size of a chunk once it is unpacked; raise `ValueError` beyond the limit of the file."""
        self._unpacked += chunk.uncompressed_size
        if self._unpacked > self._most_unpacked:
            most = self._most_unpacked
            raise ValueError(f"the chunks up to it unpack to {self._unpacked} bytes, of this file at most {most} are unpacked")

    def _in_chunk(self, data: bytes, offset: int) -> Iterator[Any]:
        """Yield the records of a chunk's data."""
        for opcode, length, payload in _records(data):
            try:
                if len(payload) < length:
                    raise ValueError(f"it reaches {length - len(payload)} bytes beyond the end of the chunk")
                if opcode == Opcode.MESSAGE:
                    if CHANNEL.unpack_from(payload)[0] not in self._skipped:
                        yield _message(payload)
                elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    record = parsed(opcode, bytes(payload))
                    self._register(record)
                    yield record
            except (struct.error, ValueError, McapError) as error:
                self._report(f"a record in the chunk at byte {offset} is damaged ({_reason(error)})")

    def _register(self, record: Any) -> None:
        """Note whether the messages of a channel are read; raise `ValueError` for a record that differs from that in the summary."""
        if isinstance(record, Schema | Channel) and self._summarized.get((type(record), record.id), record) != record:
            raise ValueError(f"{type(record).__name__.lower()} {record.id} differs from that in the summary")
        if isinstance(record, Channel) and self._topics is not None:
            (self._skipped.discard if record.topic in self._topics else self._skipped.add)(record.id)


def _reason(error: Exception) -> str:
    """Return the text of an error, or its type if it has none, such as the end of the data in the parser of MCAP."""
    return str(error) or type(error).__name__


class _Payload(ReadDataStream):
    """The payload of a record. A field that claims more bytes than follow is damage; the parser of MCAP would shorten the field."""

    def read(self, length: int) -> bytes:
        """Return the next bytes.

        Raises:
            ValueError: fewer follow.
        """
        data = super().read(length)
        if len(data) < length:
            raise ValueError(f"a field claims {length} bytes, but only {len(data)} follow in the record")
        return data


def parsed(opcode: int, payload: bytes) -> Any:
    """Return the record with a payload, without reading beyond it.

    Raises:
        ValueError: a field reaches beyond the payload.
    """
    if opcode == Opcode.MESSAGE:
        return _message(memoryview(payload))
    return KINDS[opcode].read(_Payload(BytesIO(payload)))


def _message(payload: memoryview) -> Message:
    channel, sequence, log_time, publish_time = MESSAGE.unpack_from(payload)
    return Message(channel, log_time, bytes(payload[MESSAGE.size :]), publish_time, sequence)


def decompressed(chunk: Chunk) -> bytes:
    """Return the data of a chunk, checked against its size and its checksum.

    Raises:
        ValueError: the size is too large, or size or checksum are wrong.
    """
    size = chunk.uncompressed_size
    if size > MAX_RECORD:
        raise ValueError(f"a chunk claims {size} bytes, at most {MAX_RECORD} are read")
    if chunk.compression == "zstd":
        # The decompressor allocates the size that the frame claims.
        claimed = zstandard.frame_content_size(chunk.data)
        if claimed > MAX_RECORD:
            raise ValueError(f"a chunk unpacks to {claimed} bytes, at most {MAX_RECORD} are read")
        data = bytes(zstandard.ZstdDecompressor(max_window_size=MAX_RECORD).decompress(chunk.data, max_output_size=max(1, size)))
    elif chunk.compression == "lz4":
        data = bytes(lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1))
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise ValueError(f"a chunk is compressed by '{chunk.compression}'; zstd, lz4 and none are supported")
    if len(data) != size:
        raise ValueError(f"a chunk contains {len(data)} bytes instead of {size}")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise ValueError("the checksum of a chunk does not match its data")
    return data


def has_summary(path: Path) -> bool:
    """Return whether a file ends with an intact summary, which most other readers need."""
    with path.open("rb") as stream:
        return bool(_summary(stream, path.stat().st_size).known)


class Summary(NamedTuple):
    """What the summary of a file says; nothing if it is missing or was changed.

    Schemas and channels are also in the chunks, but those may be damaged.
    """

    known: Sequence[Any] = ()
    """Schemas and channels."""
    chunks: Sequence[int] = ()
    """Positions of the chunks in increasing order [bytes]."""
    changed: bool = False
    """Whether it does not match its checksum, or contradicts itself."""


def _summary(stream: BinaryIO, size: int) -> Summary:
    """Return the summary of a file."""
    known: list[Any] = []
    starts: list[int] = []
    stream.seek(max(0, size - FOOTER - len(MAGIC)))
    tail = stream.read(FOOTER + len(MAGIC))
    if len(tail) < FOOTER + len(MAGIC) or not tail.endswith(MAGIC) or tail[0] != Opcode.FOOTER:
        return Summary()
    begin, _, checksum = FOOTER_FIELDS.unpack_from(tail, HEAD.size)
    end = size - len(tail)
    if not len(MAGIC) < begin < end or end - begin > MAX_RECORD:
        return Summary()
    stream.seek(begin)
    summary = stream.read(end - begin)
    if checksum not in (0, zlib.crc32(summary + tail[: FOOTER - CHECKSUM])):
        return Summary(changed=True)
    with suppress(Exception):  # what follows damage in a summary without a checksum counts as missing
        for opcode, _, payload in _records(summary):
            if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                known.append(parsed(opcode, bytes(payload)))
            elif opcode == Opcode.CHUNK_INDEX:
                starts.append(CHUNK_START.unpack_from(payload)[2])
    return Summary(known, sorted(starts))


def _records(data: bytes) -> Iterator[tuple[int, int, memoryview]]:
    """Yield opcode, length [bytes] and payload of consecutive records; a payload that is cut off is shorter than its length."""
    position, view = 0, memoryview(data)
    while position + HEAD.size <= len(data):
        opcode, length = HEAD.unpack_from(data, position)
        position += HEAD.size
        yield opcode, length, view[position : position + length]
        position += length
