"""The files of a recording as rosbag2 stores them: MCAP or SQLite, compressed as a whole, message by message or not at all."""

from __future__ import annotations

import re
import tempfile
import weakref
from collections import Counter
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from mcap.records import Channel, Message, Metadata, Schema

from dcrb_ros.recordings import mcap_reader, sqlite_reader
from dcrb_ros.recordings.compression import MessageUnpacker, beginning, compression_of, unpack
from dcrb_ros.recordings.mcap_reader import MAX_RECORD, FileRecords, McapRecords, has_summary
from dcrb_ros.recordings.sqlite_reader import SqliteRecords
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import checked_path, special_kind
from dcrb_ros.text.yaml import read_yaml

METADATA = "metadata.yaml"
"""File in the folder of a recording that names the others."""
LARGEST_METADATA = 4_000_000
"""Largest of these files that is read [bytes]; those of the bench have a few thousand."""
SHOWN_FILES = 5
"""Missing files that are named at most [-]."""
PACKED = ("zstd", "zst", "lz4", "gz", "bz2", "xz", "zip")
"""Suffixes of compressed files."""
FILE_NAME = re.compile(rf"(?P<stem>.+)\.(?P<storage>mcap|db3)(\.({'|'.join(PACKED)}))?")
"""Names of the files of a recording."""
NAMES = {"mcap": "MCAP", "db3": "SQLite"}
WRITTEN_NAME = re.compile(r"_([0-9]{1,9})\.mcap['\"]?\nfiles:\n")
"""The end of the name of the file in the metadata that a recorder of the bench writes to its end."""
STORAGES: dict[bytes, type[FileRecords]] = {mcap_reader.MAGIC: McapRecords, sqlite_reader.MAGIC: SqliteRecords}
"""Readers by the first bytes of a file."""


@dataclass(frozen=True)
class StoredMessage:
    """A message with the channel and the schema that describe it."""

    channel: Channel
    schema: Schema | None
    message: Message


class StoredFile:
    """A file of a recording. One that is compressed as a whole is unpacked once for this object, to a temporary file removed with it."""

    def __init__(self, path: Path) -> None:
        """Examine the first bytes of ``path``.

        Raises:
            Refusal: it cannot be read, or it is compressed by something else than zstd.
        """
        self.path = path
        self._compression, self._head = "", b""
        self._kind = special_kind(path)
        if self._kind:
            return
        self._compression, self._head = beginning(path, max(map(len, STORAGES)))
        if self._compression not in ("", "zstd"):
            raise Refusal(f"{path} is compressed by {self._compression}, which cannot be read: unpack it first; zstd can be read")
        self._copy: weakref.finalize[Any, Any] | None = None
        """Removes the unpacked copy."""
        self._unpacking = ""
        """Why the rest of the file cannot be unpacked."""
        self._packed_messages = False

    @property
    def flaw(self) -> str:
        """The mistake in the first bytes; the empty string if they are valid."""
        if self._kind:
            return f"is {self._kind}"
        if self._storage is not None:
            return ""
        name = FILE_NAME.fullmatch(self.path.name)
        magic = sqlite_reader.MAGIC if name is not None and name["storage"] == "db3" else mcap_reader.MAGIC
        empty = "cannot be unpacked" if self._compression else "is empty"
        return f"must begin with {magic!r}" if self._head else empty

    @property
    def storage_name(self) -> str:
        """The storage that the name of the file claims."""
        name = FILE_NAME.fullmatch(self.path.name)
        return NAMES[name["storage"]] if name else NAMES["mcap"]

    @property
    def rereadable(self) -> bool:
        """Whether other readers of MCAP take the file: whole messages, and a summary; known after all messages have been read."""
        return self._storage is McapRecords and not self._compression and not self._packed_messages and has_summary(self.path)

    @property
    def number(self) -> int:
        """Number in its split recording, from 0, also if it was renamed; 0 if it is unknown."""
        texts = [record.metadata.get("serialized_metadata", "") for record in self.metadata() if record.name == "rosbag2"]
        found = WRITTEN_NAME.search(texts[-1]) if texts else None
        return int(found[1]) if found else 0

    def metadata(self, damage: list[str] | None = None) -> Iterator[Metadata]:
        """Yield the metadata records; at the end add a sentence for each unreadable part outside of the chunks to ``damage``."""
        records = self._records(chunks=False)
        yield from (record for record in records if isinstance(record, Metadata))
        if damage is not None:
            damage += records.damage

    def messages(self, damage: list[str], topics: Container[str] | None = None) -> Iterator[StoredMessage]:
        """Yield the messages on some topics, by default on all; at the end add a sentence for each unreadable part to ``damage``."""
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        unknown: Counter[int] = Counter()
        flaws: list[str] = []
        records, unpacker = self._records(topics=topics), MessageUnpacker(self.path)
        for record in records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message):
                channel = channels.get(record.channel_id)
                if channel is None:
                    unknown[record.channel_id] += 1
                    continue
                message = self._unpacked(record, channel, unpacker, flaws)
                if message is not None:
                    yield StoredMessage(channel, schemas.get(channel.schema_id), message)
        name = self.path.name
        flaws += [f"{name}: {count} messages belong to channel {number}, which is not described" for number, count in unknown.items()]
        unpacking = [f"{name}: {self._unpacking}"] if self._unpacking else []
        damage += [sentence for sentence in (*unpacking, *records.damage, *flaws) if sentence not in damage]

    def close(self) -> None:
        """Remove the unpacked copy; a process does so at its end, but not if it ends at once."""
        if self._copy is not None:
            self._copy()

    @property
    def _storage(self) -> type[FileRecords] | None:
        return next((storage for magic, storage in STORAGES.items() if self._head.startswith(magic)), None)

    def _records(self, **options: Any) -> FileRecords:
        stored = self.path.stat().st_size if self._compression else None
        assert self._storage is not None  # `valid_files` leaves out the others
        return self._storage(self._readable, name=self.path.name, stored=stored, **options)

    @cached_property
    def _readable(self) -> Path:
        """The file itself, or an unpacked copy of it."""
        if not self._compression:
            return self.path
        try:
            with tempfile.NamedTemporaryFile(prefix="dcrb-", suffix=f"-{self.path.stem}", delete=False) as copy:
                self._copy = weakref.finalize(self, Path(copy.name).unlink, missing_ok=True)
                self._unpacking = unpack(self.path, copy.file)
        except OSError as error:
            folder = tempfile.gettempdir()
            raise Refusal(f"{self.path} cannot be unpacked to {folder}: {error.strerror}; make room there or set TMPDIR") from None
        return Path(copy.name)

    def _unpacked(self, message: Message, channel: Channel, unpacker: MessageUnpacker, flaws: list[str]) -> Message | None:
        """Return a message as it was sent; None if it cannot be unpacked, with the reason added to ``flaws``."""
        packed = compression_of(message.data)
        if not packed:
            return message
        self._packed_messages = True
        if packed != "zstd":
            sentence = f"messages are compressed by {packed}, which cannot be read; zstd can"
        elif unpacker.excess:
            sentence = unpacker.excess
        else:
            try:
                return replace(message, data=unpacker.unpacked(message.data, MAX_RECORD))
            except ValueError as error:
                sentence = f"a message on {channel.topic} is damaged ({error})"
        if len(flaws) < mcap_reader.MAX_DAMAGE and f"{self.path.name}: {sentence}" not in flaws:
            flaws.append(f"{self.path.name}: {sentence}")
        return None


def valid_files(path: Path) -> tuple[list[StoredFile], list[str]]:
    """Return the files of a recording, and sentences on files that are left out, because they do not begin like one, or are missing.

    A crash or a power loss right after a split leaves an empty file. Of a file and its compressed form, which `ros2 bag play` leaves both,
    the former is taken.

    Raises:
        Refusal: there are none, or they are in different storages.
    """
    if not checked_path(path).exists():
        raise Refusal(f"there is no recording {path}: give a folder made by dcrb simulate, dcrb bench or ros2 bag record, or an .mcap file")
    try:
        files = [StoredFile(file) for file in (_listed(path) if path.is_dir() else [path])]
    except OSError as error:
        raise Refusal(f"{path} cannot be read: {error.strerror}") from None
    if not files:
        raise Refusal(f"{path} contains no .mcap file and no .db3 file: give the folder of a recording")
    flaws = {file.path: file.flaw for file in files if file.flaw}
    if len(flaws) == len(files):
        raise Refusal(f"{files[0].path} is not an {files[0].storage_name} file: it {files[0].flaw}")
    sound = [file for file in files if file.path not in flaws]
    if len({file.storage_name for file in sound}) > 1:
        raise Refusal(f"{path} contains both .mcap and .db3 files: give the folder of a single recording, or one of the files")
    left_out = [f"{file.path.name}: left out, not an {file.storage_name} file: it {file.flaw}" for file in files if file.flaw]
    return sound, [*left_out, *_missing(path, files)]


def named_files(folder: Path) -> list[str]:
    """Return the files that metadata.yaml names, without the suffix of their compression.

    Raises:
        Refusal: it cannot be read.
        ValueError, KeyError, TypeError, RecursionError: it is damaged.
    """
    about = read_yaml(folder / METADATA, LARGEST_METADATA)["rosbag2_bagfile_information"]
    return [plain_name(str(name)) for name in about["relative_file_paths"]]


def _missing(path: Path, files: Sequence[StoredFile]) -> Iterator[str]:
    """Yield a sentence if files are missing that metadata.yaml names; if it names none of those in the folder, they were renamed."""
    try:
        named = dict.fromkeys(named_files(path)) if path.is_dir() else {}
    except (ValueError, KeyError, TypeError, RecursionError):  # a recording can be read without it
        return
    present = {plain_name(file.path.name) for file in files}
    missing = [printable(name) for name in named if name not in present]
    if missing and len(missing) < len(named):
        others = f" and {len(missing) - SHOWN_FILES} more" if len(missing) > SHOWN_FILES else ""
        yield f"{METADATA} names files that are missing: {', '.join(missing[:SHOWN_FILES])}{others}"


def _listed(folder: Path) -> list[Path]:
    """Return the files of a recording in a folder, in order."""
    files: dict[str, Path] = {}
    for file in sorted(folder.iterdir(), key=lambda file: len(file.name), reverse=True):
        if FILE_NAME.fullmatch(file.name):
            # The shortest name, the one without compression, comes last.
            files[plain_name(file.name)] = file
    return sorted(files.values(), key=_file_order)


def plain_name(name: str) -> str:
    """Return the name of a file without the suffix of its compression."""
    parts = FILE_NAME.fullmatch(name)
    return f"{parts['stem']}.{parts['storage']}" if parts else name


def _file_order(path: Path) -> tuple[str, int, str]:
    """Return a sort key that puts NAME_2 before NAME_10."""
    stem = FILE_NAME.fullmatch(path.name)
    numbered = re.fullmatch(r"(.*)_(\d{1,9})", stem["stem"] if stem else path.stem)
    return (numbered[1], int(numbered[2]), path.name) if numbered else (path.stem, -1, path.name)
