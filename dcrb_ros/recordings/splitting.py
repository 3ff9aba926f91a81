"""Splitting and closing a recording: a rosbag2 folder of MCAP files, and a metadata.yaml that is replaced atomically."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import yaml

from dcrb_ros.recordings.mcap_writer import Channel, McapFile, Span
from dcrb_ros.recordings.storage import METADATA
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import Recording as RecordingSettings
from dcrb_ros.text.files import checked_path
from dcrb_ros.text.temporary import temporary
from dcrb_ros.text.writing import remedy_of, sync

SECOND = 1_000_000_000

Records = Mapping[str, Mapping[str, str]]
"""Metadata records by name."""


class RecordingFailed(RuntimeError):
    """Writing failed, on a full disk for instance; everything flushed before can be read."""

    def __init__(self, event: str, remedy: str = "") -> None:
        super().__init__(f"{event}; {remedy} or give another folder" if remedy else event)
        self.event, self.remedy = event, remedy


def new_folder(path: Path) -> Path:
    """Create the folder of a recording.

    Raises:
        Refusal: it exists or cannot be created.
    """
    if checked_path(path).exists():
        raise Refusal(f"{path} exists: give another name or remove it, a recording is never overwritten")
    try:
        path.mkdir(parents=True)
    except OSError as error:
        raise Refusal(f"{path} cannot be created: {error.strerror}; give a folder that can be written") from None
    return path


class Bag:
    """A rosbag2 folder being written, with one MCAP file or several.

    Every file begins with the metadata records ``opening`` and the last messages on latched topics, so that it can be read alone. It ends
    with the metadata records that ``closing`` returns.

    Raises:
        Refusal: the path exists or cannot be written.
        RecordingFailed: a write failed later.
    """

    def __init__(self, path: Path, *, opening: Records, closing: Callable[[], Records], settings: RecordingSettings | None = None) -> None:
        self.path = new_folder(path)
        self._opening, self._closing = opening, closing
        self._settings = settings or RecordingSettings()
        self._ended: list[McapFile] = []
        self._sequences: Counter[Channel] = Counter()
        self._latched: dict[Channel, bytes] = {}
        """The last message on each latched topic."""
        self.open = True
        try:
            self._file = self._begin_file(0)
            self._write_metadata()
        except BaseException as error:
            shutil.rmtree(self.path, ignore_errors=True)
            if not isinstance(error, OSError):
                raise
            raise Refusal(f"{self.path} cannot be written: {error.strerror}; {remedy_of(error)} or give another folder") from None

    @property
    def files(self) -> list[Path]:
        """The MCAP files written so far."""
        return [file.path for file in self._all()]

    def write(self, messages: Iterable[tuple[Channel, int, bytes]]) -> None:
        """Write messages, each with its channel and simulated time [ns]; a closed bag ignores them."""
        if not self.open:
            return
        with self._end_on_failure():
            for channel, time_ns, data in messages:
                if self._full(time_ns):
                    self._split()
                    for latched, last in self._latched.items():
                        if latched != channel:
                            self._write(latched, time_ns, last)
                self._write(channel, time_ns, data)
            self._file.flush_due()

    def _full(self, time_ns: int) -> bool:
        """Return whether a message of ``time_ns`` [ns] belongs to the next file."""
        first, size, duration_ns = self._file.span.first_ns, self._settings.split_size, round(self._settings.split_duration * SECOND)
        return first is not None and bool((size and self._file.size >= size) or (duration_ns and time_ns - first >= duration_ns))

    def _write(self, channel: Channel, time_ns: int, data: bytes) -> None:
        self._file.write(channel, time_ns, data, self._sequences[channel])
        self._sequences[channel] += 1
        if channel.latched:
            self._latched[channel] = data

    def flush(self) -> None:
        """Write everything to the file."""
        if not self.open:
            return
        with self._end_on_failure():
            self._file.flush()

    def close(self) -> None:
        """Finish the bag; a second call does nothing."""
        if not self.open:
            return
        try:
            self._end_file()
            self._write_metadata()
        except OSError as error:
            self._abandon()
            raise RecordingFailed(f"the recording {self.path} could not be finished: {error.strerror}", remedy_of(error)) from None
        self.open = False

    @contextmanager
    def removed_on_failure(self) -> Iterator[None]:
        """Finish the bag at the end of the context; if that or the context fails, nothing is left behind."""
        try:
            yield
            self.close()
        except BaseException as error:
            self._abandon()
            shutil.rmtree(self.path, ignore_errors=True)
            if isinstance(error, RecordingFailed):
                raise RecordingFailed(f"{error.event}; it was removed", error.remedy) from None
            raise

    @contextmanager
    def _end_on_failure(self) -> Iterator[None]:
        """End the recording if a write in the context fails."""
        try:
            yield
        except OSError as error:
            self._abandon()
            reached = max((file.span.last_ns for file in self._all()), default=0) / SECOND
            event = f"the recording {self.path} ended at {reached:.1f} s: {error.strerror}"
            raise RecordingFailed(event, remedy_of(error)) from None

    def _begin_file(self, number: int) -> McapFile:
        return McapFile(self.path / f"{self.path.name}_{number}.mcap", self._opening, self._settings.compression)

    def _split(self) -> None:
        self._end_file()
        following = self._begin_file(len(self._ended) + 1)
        self._ended.append(self._file)
        self._file = following
        self._write_metadata()

    def _end_file(self) -> None:
        serialized = yaml.safe_dump(self._metadata([self._file]), sort_keys=False)
        self._file.close({**self._closing(), "rosbag2": {"serialized_metadata": serialized}})

    def _abandon(self) -> None:
        """Stop writing; the files remain readable."""
        self.open = False
        self._file.abandon()
        with suppress(OSError):  # the metadata written at the last split remain; `dcrb recover` writes new ones
            self._write_metadata()

    def _all(self) -> list[McapFile]:
        return [*self._ended, self._file]

    def _metadata(self, files: list[McapFile]) -> dict[str, Any]:
        """Return the content of metadata.yaml, version 9, for some files; every key is mandatory."""
        span = Span()
        counts: Counter[Channel] = Counter()
        for file in files:
            span = span.union(file.span)
            counts.update(file.counts)
        return {
            "version": 9,
            "storage_identifier": "mcap",
            "duration": {"nanoseconds": span.duration_ns},
            "starting_time": {"nanoseconds_since_epoch": span.first_ns or 0},
            "message_count": sum(counts.values()),
            "topics_with_message_count": [_topic(channel, count) for channel, count in counts.items()],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [file.path.name for file in files],
            "files": [_file(file) for file in files],
            "custom_data": {"dcrb_ros": __version__},
            "ros_distro": "jazzy",
        }

    def _write_metadata(self) -> None:
        """Replace metadata.yaml atomically."""
        document = {"rosbag2_bagfile_information": self._metadata(self._all())}
        with temporary(self.path, ".yaml") as written:
            written.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")
            sync(written)
            written.replace(self.path / METADATA)
            sync(self.path)


def _topic(channel: Channel, count: int) -> dict[str, Any]:
    metadata = {
        "name": channel.name,
        "type": channel.type,
        "serialization_format": "cdr",
        "offered_qos_profiles": channel.profiles(),
        "type_description_hash": channel.type_hash,
    }
    return {"topic_metadata": metadata, "message_count": count}


def _file(file: McapFile) -> dict[str, Any]:
    return {
        "path": file.path.name,
        "starting_time": {"nanoseconds_since_epoch": file.span.first_ns or 0},
        "duration": {"nanoseconds": file.span.duration_ns},
        "message_count": sum(file.counts.values()),
    }
