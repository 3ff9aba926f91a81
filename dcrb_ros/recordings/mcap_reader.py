"""The records of an MCAP file as far as they can be read: bounded memory, whatever the file claims."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Container, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, ChunkIndex, Footer, Header, Message, Metadata, Schema

MAGIC = b"\x89MCAP0\r\n"
LARGEST = 64 * 1024 * 1024
"""Largest record, packed or unpacked, that is read [bytes]; ours have a quarter of a megabyte."""
HEAD = struct.Struct("<BQ")
"""Opcode and length before every record."""
MESSAGE = struct.Struct("<HIQQ")
"""Channel, sequence, log time and publish time before the data of a message."""
CHANNEL = struct.Struct("<H")
"""The first of them."""
START = struct.Struct("<QQQ")
"""First and last time in a chunk and where it begins, at the head of its index."""
FOOTER = HEAD.size + 20
"""Size of the footer [bytes]; the magic follows it."""
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


class McapRecords:
    """The records of a file, chunks unpacked; iterating collects in `damage` what could not be read."""

    def __init__(self, path: Path, *, chunks: bool = True, topics: Container[str] | None = None) -> None:
        """Read ``path``; without ``chunks`` only what lies between them, at the speed of a seek; of messages those on ``topics``."""
        self.path, self._chunks, self._topics = path, chunks, topics
        self._unwanted: set[int] = set()
        """Channels of other topics."""
        self.damage: list[str] = []

    def __iter__(self) -> Iterator[Any]:
        self.damage = []
        size = self.path.stat().st_size
        with self.path.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                self._remark("it does not begin as an MCAP file")
                return
            known, starts = _summary(stream, size)
            for record in known:
                self._heed(record)
                yield record
            yield from self._data(stream, size, starts)

    def _data(self, stream: BinaryIO, size: int, starts: list[int]) -> Iterator[Any]:
        """Yield the records from the beginning to the footer; where the way is lost, go on at the next of the chunks' ``starts``."""
        at = len(MAGIC)
        while True:
            stream.seek(at)
            head = stream.read(HEAD.size)
            opcode, length = HEAD.unpack(head) if len(head) == HEAD.size else (0, size)
            if at + HEAD.size + length > size or not opcode:
                missing = "the footer is missing" if at == size else f"the record at byte {at} reaches beyond the end of the file"
                self._remark(f"{missing} at {size}")
                later = [start for start in starts if start > at]
                if not later:
                    return
                at = later[0]
                continue
            yield from self._record(stream, opcode, length, at)
            if opcode == Opcode.FOOTER:
                return
            at += HEAD.size + length

    def _record(self, stream: BinaryIO, opcode: int, length: int, at: int) -> Iterator[Any]:
        if opcode in (Opcode.FOOTER, Opcode.CHUNK_INDEX) or (opcode not in KINDS and opcode != Opcode.MESSAGE):
            return
        if opcode == Opcode.CHUNK and not self._chunks:
            return
        if length > LARGEST:
            self._remark(f"the record at byte {at} claims {length} bytes; {LARGEST} are the most")
            return
        try:
            record = parsed(opcode, stream.read(length))
            if isinstance(record, Chunk):
                inner = unpacked(record)
            else:
                self._heed(record)
                yield record
                return
        except Exception as error:  # a damaged record breaks parser or decompressor anywhere, each in its own way
            self._remark(f"the record at byte {at} is damaged ({error or type(error).__name__})")
            return
        yield from self._inside(inner, at)

    def _inside(self, data: bytes, at: int) -> Iterator[Any]:
        """Yield the records of a chunk's data."""
        position, view, unwanted = 0, memoryview(data), self._unwanted
        while position + HEAD.size <= len(data):
            opcode, length = HEAD.unpack_from(data, position)
            position += HEAD.size
            try:
                if opcode == Opcode.MESSAGE:
                    if CHANNEL.unpack_from(data, position)[0] not in unwanted:
                        yield _message(view[position : position + length])
                elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    record = parsed(opcode, data[position : position + length])
                    self._heed(record)
                    yield record
            except (struct.error, ValueError, EOFError) as error:
                self._remark(f"a record in the chunk at byte {at} is damaged ({error})")
            position += length

    def _heed(self, record: Any) -> None:
        """Note whether the messages of a channel are wanted."""
        if isinstance(record, Channel) and self._topics is not None:
            (self._unwanted.discard if record.topic in self._topics else self._unwanted.add)(record.id)

    def _remark(self, words: str) -> None:
        if len(self.damage) < 100:
            self.damage.append(f"{self.path.name}: {words}")


def parsed(opcode: int, payload: bytes) -> Any:
    """Return the record of a payload; it cannot read beyond it."""
    if opcode == Opcode.MESSAGE:
        return _message(memoryview(payload))
    return KINDS[opcode].read(ReadDataStream(BytesIO(payload)))


def _message(payload: memoryview) -> Message:
    channel, sequence, log_time, publish_time = MESSAGE.unpack_from(payload)
    return Message(channel, log_time, bytes(payload[MESSAGE.size :]), publish_time, sequence)


def unpacked(chunk: Chunk) -> bytes:
    """Return the data of a chunk, checked against its size and its sum.

    Raises:
        ValueError: it claims too much, or is not what it claims.
    """
    size = chunk.uncompressed_size
    if size > LARGEST:
        raise ValueError(f"a chunk claims {size} bytes, {LARGEST} are the most")
    if chunk.compression == "zstd":
        # The frame's own claim is what the decompressor would believe.
        claimed = zstandard.frame_content_size(chunk.data)
        if claimed > LARGEST:
            raise ValueError(f"a chunk unpacks to {claimed} bytes, {LARGEST} are the most")
        data = bytes(zstandard.ZstdDecompressor(max_window_size=LARGEST).decompress(chunk.data, max_output_size=max(1, size)))
    elif chunk.compression == "lz4":
        data = bytes(lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1))
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise ValueError(f"a chunk is packed by '{chunk.compression}'; zstd, lz4 and none are known")
    if len(data) != size:
        raise ValueError(f"a chunk holds {len(data)} bytes where it claims {size}")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise ValueError("the sum of a chunk does not fit its data")
    return data


def _summary(stream: BinaryIO, size: int) -> tuple[list[Any], list[int]]:
    """Return schemas and channels from the end of a file, and where its chunks begin; nothing where the end is missing.

    They stand in the first chunks too, but those may be damaged.
    """
    known: list[Any] = []
    starts: list[int] = []
    stream.seek(max(0, size - FOOTER - len(MAGIC)))
    tail = stream.read(FOOTER + len(MAGIC))
    if len(tail) < FOOTER + len(MAGIC) or not tail.endswith(MAGIC) or tail[0] != Opcode.FOOTER:
        return known, starts
    begin = int(struct.unpack_from("<Q", tail, HEAD.size)[0])
    end = size - len(tail)
    if not len(MAGIC) < begin < end or end - begin > LARGEST:
        return known, starts
    stream.seek(begin)
    data, position = stream.read(end - begin), 0
    while position + HEAD.size <= len(data):
        opcode, length = HEAD.unpack_from(data, position)
        position += HEAD.size
        try:
            if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                known.append(parsed(opcode, data[position : position + length]))
            elif opcode == Opcode.CHUNK_INDEX:
                starts.append(START.unpack_from(data[position : position + length])[2])
        except Exception:  # a damaged summary is one that is not there
            return known, sorted(starts)
        position += length
    return known, sorted(starts)
