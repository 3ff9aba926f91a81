"""Recordings as questions: the truth, and what a detector said while it was recorded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.records import Channel, Message

from dcrb_ros.exam.opinion import Opinion, opinion_of
from dcrb_ros.exam.question import Question
from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import DIAGNOSIS, GROUND_TRUTH
from dcrb_ros.recordings.mcap_reader import McapRecords
from dcrb_ros.recordings.reader import sound_files
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.settings.parameters import rpm
from dcrb_ros.simulation.block import Truth


@dataclass(frozen=True)
class Tape:
    """A recording that tells the truth, and perhaps what a detector said."""

    path: Path
    question: Question
    opinions: tuple[Opinion, ...]
    damage: tuple[str, ...]
    """What could not be read, in words."""


def read_tape(path: Path, *, name: str = "") -> Tape:
    """Return the question that a recording asks, and the answers in it; of the bench or of `ros2 bag record`.

    Raises:
        Refusal: no recording, no ground truth in it, or one that a single verdict cannot answer.
    """
    truths, opinions = [], []
    files, damage = sound_files(path)
    for file in files:
        records = McapRecords(file)
        for topic, data in _messages(records):
            if topic.endswith(f"/{GROUND_TRUTH.name}"):
                truths.append(decode_truth(data))
            elif topic.endswith(f"/{DIAGNOSIS.name}"):
                opinions.append(opinion_of(data))
        damage += records.damage
    if not truths:
        raise Refusal(
            f"{path} holds no messages on {GROUND_TRUTH.name}: nobody knows what would be right; give a recording of the bench "
            "(dcrb simulate, dcrb bench --record, or ros2 bag record -a beside it)"
            + (f"; not all of it could be read: {damage[0]}" if damage else "")
        )
    # A diagnosis that came while the recording began may judge what was before.
    opinions = [opinion for opinion in opinions if opinion.time >= truths[0].time_ns * 1e-9]
    return Tape(path, _question(path, name or path.name, truths, opinions), tuple(opinions), tuple(damage))


def _messages(records: McapRecords) -> Iterator[tuple[str, bytes]]:
    channels: dict[int, Channel] = {}
    for record in records:
        if isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Message) and record.channel_id in channels:
            yield channels[record.channel_id].topic, record.data


def _question(path: Path, name: str, truths: Sequence[Truth], opinions: Sequence[Opinion]) -> Question:
    present: Mapping[str, Mapping[str, Any]] = {}
    for truth in truths:
        gone = set(present) - set(truth.faults)
        if gone:
            raise Refusal(
                f"{path}: the fault {sorted(gone)[0]} ends at {truth.time_ns * 1e-9:g} s; a scenario has one right verdict from the "
                "onset on: cut the recording there"
            )
        present = truth.faults
    last = truths[-1]
    begin, end = truths[0].time_ns * 1e-9, max([last.time_ns * 1e-9, *(opinion.time for opinion in opinions)])
    # What is older than the recording can be found from its beginning on.
    onsets = {fault: max(begin, float(fields.get("onset", 0.0))) for fault, fields in present.items()}
    verdict = class_of(present)
    tags: dict[str, str | float] = {"speed": last.speed, "speed_rpm": round(rpm(last.speed), 1), "load": -last.load[1]}
    widths = [float(fault["width"]) for fault in present.values() if "width" in fault]
    tags |= {"width": max(widths)} if widths else {}
    return Question(
        name,
        verdict,
        end - begin,
        _since(onsets, verdict),
        tags,
        first_onset=min(onsets.values(), default=begin),
        begin=begin,
        bearing_onset=min((onset for fault, onset in onsets.items() if class_of([fault]) != "sensor"), default=None),
    )


def _since(onsets: Mapping[str, float], verdict: str) -> float:
    """Return since when a verdict is right, faults coming one after the other [s]: another defect of a kind does not change it."""
    moments = sorted(set(onsets.values()))
    return next((now for now in moments if class_of([f for f, onset in onsets.items() if onset <= now]) == verdict), 0.0)
