"""Recovery of a truncated or damaged recording: everything that can be read is written to a new, complete bag or file."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Message as McapMessage

from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import GROUND_TRUTH, VIBRATION, Message
from dcrb_ros.recordings.foreign_files import refuse_foreign, sound
from dcrb_ros.recordings.manifest import OUTCOME, Outcome, now
from dcrb_ros.recordings.mcap_writer import Channel, McapFile, described_channel
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.splitting import SECOND, Bag
from dcrb_ros.recordings.storage import StoredFile, StoredMessage, valid_files
from dcrb_ros.recordings.vehicle_folder import VEHICLE_OUTCOME, box_of, record_name, vehicle_boxes
from dcrb_ros.recordings.verification import RECOVERY, stated_losses
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import Recording as RecordingSettings

ENCODING = ("cdr", "ros2msg")
"""Encodings of messages and their definitions in recordings of ROS 2."""
MAX_DAMAGE = 100
"""Sentences about damaged messages that are kept."""


LATEST = 2**63 - 1
"""Last time of ROS [ns]."""
LONGEST = 100_000_000 * SECOND
"""Longest simulated time, three years; greater times are those of the wall clock [ns]."""


@dataclass
class Recovered:
    """The result of a recovery."""

    messages: int = 0
    last_ns: int = 0
    """Time of the last message [ns]."""
    damage: tuple[str, ...] = ()
    """A sentence for each part that could not be read."""


class Recovery:
    """Copies the readable part of a recording to a new bag."""

    def __init__(self, source: Path) -> None:
        """Open the source.

        Raises:
            Refusal: it cannot be read, or its folder has a file of another recording.
        """
        self._files, self._damage = valid_files(source)
        refuse_foreign(source, self._files)
        self._recordings = _recordings(source)
        if self._recordings:
            self._files = self._recordings[0].stored  # unpacked already
        _, self._lost_before = stated_losses(self._files) or ("", [])
        """Losses of an earlier recovery, whose result the source is."""
        self._source = source
        self._recovered = Recovered()
        self._outcomes = [Outcome(recording.sampling_rate) for recording in self._recordings]
        self._checked = {
            topic.resolved(recording.namespace): (topic, outcome)
            for recording, outcome in zip(self._recordings, self._outcomes, strict=True)
            for topic in (VIBRATION, GROUND_TRUTH)
        }

    def write(self, target: Path) -> Recovered:
        """Write everything that can be read to a new bag.

        Raises:
            Refusal: no message can be read, or the target exists.
            RecordingFailed: the bag could not be written whole, and was removed.
        """
        messages = self._messages()
        first = next(messages, None)
        if first is None:
            reason = f": {self._damage[0]}" if self._damage else ""
            raise Refusal(f"nothing can be recovered from {self._source}, because no message can be read{reason}")
        records = self._opening()
        bag = Bag(target, opening=records, closing=self._closing, settings=self._settings)
        with bag.removed_on_failure():
            bag.write([first])
            for message in messages:
                bag.write([message])
            self._note(self._mismatch())
            unsound = [name for name, entries in records.items() if not sound(name, entries)]
            self._note(f"the record {name} is damaged or was changed; it is kept, and not used by any command" for name in unsound)
        self._recovered.damage = tuple(map(printable, self._damage))
        return self._recovered

    def _messages(self) -> Iterator[tuple[Channel, int, bytes]]:
        for file in self._files:
            damage: list[str] = []
            described: dict[int, tuple[StoredMessage, Channel | None]] = {}
            for stored in file.messages(damage):
                first, channel = described.get(stored.channel.id, (None, None))
                if first is None or first.channel is not stored.channel or first.schema is not stored.schema:
                    channel = self._channel(stored)
                    described[stored.channel.id] = stored, channel
                if channel is not None and self._valid(channel, stored.message):
                    yield channel, stored.message.log_time, stored.message.data
                    self._count(channel, stored.message)
            self._note(damage)

    def _mismatch(self) -> list[str]:
        """Return a sentence if the samples of a source that is readable throughout do not match its digest."""
        if self._damage:
            return []
        read = zip(self._recordings, self._outcomes, strict=True)
        sentences = [recording.compared(outcome).mismatch for recording, outcome in read]
        return [sentence for sentence in sentences if sentence]

    def _channel(self, stored: StoredMessage) -> Channel | None:
        """Return the description of a message's channel; None, counted as damage, if ROS 2 has no such channel."""
        channel, schema = stored.channel, stored.schema
        encoding = channel.message_encoding, schema.encoding if schema else ""
        if schema is None or encoding != ENCODING:
            content = f"{channel.topic} contains {encoding[0] or 'unnamed'} messages defined by {encoding[1] or 'nothing'}"
            self._note([f"{content}, which are left out: dcrb recover repairs ROS 2 recordings, with cdr defined by ros2msg"])
            return None
        return described_channel(channel, schema)

    def _note(self, sentences: Iterable[str]) -> None:
        """Keep new sentences about damage."""
        self._damage += [sentence for sentence in sentences if sentence not in self._damage][: MAX_DAMAGE - len(self._damage)]

    def _valid(self, channel: Channel, record: McapMessage) -> bool:
        """Return false if a message is a corrupt waveform or ground truth of the bench, or if ROS cannot represent its time."""
        if record.log_time > LATEST:
            self._note([f"{channel.name} has a message at {record.log_time} ns, beyond {time_text(LATEST)}, which ROS cannot represent"])
            return False
        topic, _ = self._checked.get(channel.name, (None, None))
        if topic is not None:
            try:
                check = decode_vibration if topic == VIBRATION else decode_truth
                check(record.data)
            except Refusal as refusal:
                self._note([f"{topic.name} at {time_text(record.log_time)}: {refusal}"])
                return False
        return True

    def _count(self, channel: Channel, record: McapMessage) -> None:
        """Count a message that was written, so that a split file states its own samples."""
        topic, outcome = self._checked.get(channel.name, (None, None))
        if topic is not None and outcome is not None:
            outcome.add(Message(topic, record.log_time, record.data))
        self._recovered.messages += 1
        self._recovered.last_ns = max(self._recovered.last_ns, record.log_time)

    def _opening(self) -> dict[str, dict[str, str]]:
        """Return the metadata records of the source, except those of its end; the first sound one of each name, or else the first."""
        records: dict[str, dict[str, str]] = {}
        for record in (record for file in self._files for record in file.metadata()):
            if record.name in ("rosbag2", RECOVERY, VEHICLE_OUTCOME) or record.name.partition("/")[0] == OUTCOME:
                continue
            if record.name not in records or (sound(record.name, record.metadata) and not sound(record.name, records[record.name])):
                records[record.name] = dict(record.metadata)
        return records

    def _closing(self) -> Mapping[str, Mapping[str, str]]:
        lost = list(dict.fromkeys([*self._lost_before, *self._damage]))[:MAX_DAMAGE]
        about: dict[str, Any] = {"source": self._source.name, "lost": lost, "recovered": now()}
        ending = {RECOVERY: {"recovery": json.dumps(about)}}
        for recording, outcome in zip(self._recordings, self._outcomes, strict=True):
            if not recording.described:  # its samples are put in order as they are read, and have another digest then
                ending[record_name(OUTCOME, recording.box)] = outcome.records()[OUTCOME]
        return ending

    @property
    def _settings(self) -> RecordingSettings | None:
        """How the recording was to be written; None if it has no configuration, or one that this version does not understand."""
        if self._recordings and self._recordings[0].configured:
            with suppress(Refusal):
                return self._recordings[0].configuration.recording
        return None


def recover(source: Path, target: Path) -> Recovered:
    """Write everything that can be read of a recording to a new bag.

    Raises:
        Refusal: no message can be read, the target exists, or the source is a box of a vehicle.
    """
    whole, box = box_of(source)
    if box:
        raise Refusal(f"{source} is a box in the recording {whole}, which is recovered as a whole: give {whole}")
    return Recovery(source).write(target)


def plain_files(files: Sequence[StoredFile], folder: Path, *, complete: bool) -> tuple[Path, ...]:
    """Return the files of a recording that were read, or a copy of their readable messages where other readers do not take the files.

    Those take ``complete`` MCAP files with a summary and with messages that are not compressed; the copy is written to ``folder``.
    """
    if complete and all(file.rereadable for file in files):
        return tuple(file.path for file in files)
    copy = McapFile(folder / "copy.mcap", {}, "none")
    damage: list[str] = []
    for file in files:
        for number, stored in enumerate(file.messages(damage)):
            if stored.schema is not None:
                message = stored.message
                copy.write(described_channel(stored.channel, stored.schema), message.log_time, message.data, number)
    copy.close({})
    return (copy.path,)


def time_text(time_ns: int) -> str:
    """Return the time of a message [ns] for people: simulated time in seconds, wall-clock time as a date.

    Examples
    --------
    >>> time_text(1_500_000_000)
    '1.500 s'
    >>> time_text(1_795_337_999_437_000_000)
    '2026-11-22 08:59:59.437 UTC'
    """
    if time_ns < LONGEST:
        return f"{time_ns * 1e-9:.3f} s"
    return str(np.datetime64(time_ns // 1_000_000, "ms")).replace("T", " ") + " UTC"


def _recordings(source: Path) -> list[Recording]:
    """Return the source as a recording of the bench, or those of the boxes of a vehicle that can be read; none if it is another bag."""
    recordings = []
    for path in [source / name for name in vehicle_boxes(source)] or [source]:
        with suppress(Refusal):
            recording = Recording(path)
            _ = recording.sampling_rate  # without it no sample can be counted
            recordings.append(recording)
    return recordings
