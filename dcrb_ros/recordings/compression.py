"""Compression of whole files and of single messages, as rosbag2 applies it (`ros2 bag record --compression-mode file` or `message`)."""

from __future__ import annotations

from pathlib import Path
from typing import IO, BinaryIO

import zstandard

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import open_regular

ZSTD = b"\x28\xb5\x2f\xfd"
"""First bytes of a zstd frame; no message in CDR begins with them."""
OTHERS = {b"\x04\x22\x4d\x18": "lz4", b"\x1f\x8b": "gzip", b"BZh": "bzip2", b"\xfd7zXZ\x00": "xz", b"PK\x03\x04": "zip"}
"""First bytes of compressions that are recognized but not read."""
MAX_WINDOW = 128 * 1024 * 1024
"""Largest window of a zstd frame [bytes]: that of its highest level."""
MAX_RATIO = 1000
"""Largest ratio of the sizes of a file, or of its messages, after and before unpacking."""
FREE_SIZE = 256 * 1024 * 1024
"""Size to which a file of any ratio, or its messages, are unpacked [bytes]."""
PIECE = 64 * 1024
"""Bytes unpacked at a time; damage loses at most as many before it."""


def compression_of(data: bytes) -> str:
    """Return the name of the compression of some data by their first bytes; the empty string if they are not compressed."""
    if data.startswith(ZSTD):
        return "zstd"
    return next((name for magic, name in OTHERS.items() if data.startswith(magic)), "")


def unpacked_message(data: bytes, limit: int) -> bytes:
    """Return the message in a zstd frame.

    Raises:
        ValueError: it is damaged, or larger than ``limit`` [bytes].
    """
    try:
        claimed = zstandard.frame_content_size(data)
        if claimed > limit:
            raise ValueError(f"it unpacks to {claimed} bytes; at most {limit} are read")
        # The limit counts where the frame does not give its size.
        return bytes(zstandard.ZstdDecompressor(max_window_size=MAX_WINDOW).decompress(data, max_output_size=limit))
    except zstandard.ZstdError as error:
        raise ValueError(f"it is damaged or has more than {limit} bytes: {error}") from None


class MessageUnpacker:
    """Unpacks the messages of a file until they exceed its limit together."""

    def __init__(self, path: Path) -> None:
        self._limit, self._total = largest_unpacked(path), 0

    @property
    def excess(self) -> str:
        """Why no further message is unpacked; the empty string as long as they are."""
        return _excess("its messages unpack", self._limit) if self._total > self._limit else ""

    def unpacked(self, data: bytes, limit: int) -> bytes:
        """Return the message in a zstd frame, and count its size; see `unpacked_message`."""
        message = unpacked_message(data, limit)
        self._total += len(message)
        return message


def largest_unpacked(path: Path) -> int:
    """Return the size to which a file, or its messages, are unpacked at most [bytes]."""
    return max(FREE_SIZE, MAX_RATIO * path.stat().st_size)


def _excess(subject: str, limit: int) -> str:
    return f"{subject} to more than {limit} bytes, {MAX_RATIO} times its size; the rest is left out"


def beginning(path: Path, count: int) -> tuple[str, bytes]:
    """Return the compression of a file and its first bytes, unpacked if it is compressed by zstd; no bytes if that is damaged.

    Raises:
        Refusal: it cannot be read.
    """
    try:
        with open_regular(path) as stream:
            head = stream.read(count)
            compression = compression_of(head)
            if compression == "zstd":
                stream.seek(0)
                head = bytes(_reader(stream).read(count))
            return compression, head
    except OSError as error:
        raise Refusal(f"{path} cannot be read: {error.strerror}") from None
    except zstandard.ZstdError:
        return "zstd", b""


def unpack(path: Path, target: IO[bytes]) -> str:
    """Write the data in a zstd file; return why the rest of it cannot be unpacked, or the empty string.

    Raises:
        OSError: the target cannot be written.
        Refusal: the file cannot be read.
    """
    limit, total = largest_unpacked(path), 0
    with open_regular(path) as stream:
        reader = _reader(stream)
        while True:
            try:
                piece = reader.read(PIECE)
            except zstandard.ZstdError as error:
                return f"it cannot be unpacked beyond byte {total} ({error})"
            total += len(piece)
            if not piece:
                return ""
            if total > limit:
                return _excess("it unpacks", limit)
            target.write(piece)


def _reader(stream: BinaryIO) -> zstandard.ZstdDecompressionReader:
    return zstandard.ZstdDecompressor(max_window_size=MAX_WINDOW).stream_reader(stream, read_across_frames=True, closefd=False)
