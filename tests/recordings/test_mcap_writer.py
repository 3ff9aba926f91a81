"""Writing an MCAP file: what has reached the disk at each time."""

from __future__ import annotations

import struct
from dataclasses import FrozenInstanceError, replace
from io import BytesIO
from pathlib import Path

import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import DataEnd, Footer, Message
from mcap.stream_reader import StreamReader

from dcrb_ros.messages.topics import FEATURES, NAMESPACE, ROLLER_STATES, VIBRATION
from dcrb_ros.recordings.mcap_reader import MAGIC, McapRecords
from dcrb_ros.recordings.mcap_writer import CHUNK, MINIMAL_END, McapFile, Span
from dcrb_ros.recordings.recorder import channel_of

CHANNEL = channel_of(FEATURES, NAMESPACE)
MS = 1_000_000


def times_on_disk(path: Path) -> list[int]:
    """Return the log times [ms] of the messages that a reader finds in a file that is still being written."""
    return [record.log_time // MS for record in McapRecords(path) if isinstance(record, Message)]


def test_buffered_messages_are_written_every_half_second_of_simulated_time(tmp_path: Path) -> None:
    """A crash may lose a second, so that half a second is left for the disk."""
    file = McapFile(tmp_path / "file.mcap", {}, "zstd")
    written = []
    for time in range(0, 1701, 100):
        file.write(CHANNEL, time * MS, b"small", 0)
        file.flush_due()
        written.append(max(times_on_disk(file.path), default=None))
    assert written == [*[None] * 5, *[500] * 5, *[1000] * 5, *[1500] * 3]
    file.close({})
    assert times_on_disk(file.path) == list(range(0, 1701, 100))


def test_the_half_second_counts_from_the_last_flush(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "file.mcap", {}, "none")
    for time, expected in ((0, []), (400, []), (499, []), (700, [0, 400, 499, 700]), (1199, [0, 400, 499, 700])):
        file.write(CHANNEL, time * MS, b"small", 0)
        file.flush_due()
        assert times_on_disk(file.path) == expected
    file.write(CHANNEL, 1200 * MS, b"small", 0)
    file.flush_due()
    assert times_on_disk(file.path)[-1] == 1200


def test_a_full_chunk_is_written_at_once(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "file.mcap", {}, "none")
    size = file.size
    file.write(CHANNEL, 0, bytes(CHUNK), 0)
    file.write(CHANNEL, MS, b"small", 1)
    file.flush_due()
    assert times_on_disk(file.path) == [0]
    assert file.size > size + CHUNK


def test_an_abandoned_file_ends_after_its_last_complete_chunk(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "file.mcap", {}, "none")
    file.write(CHANNEL, 0, b"flushed", 0)
    file.flush()
    file.write(CHANNEL, MS, b"lost", 1)
    file.abandon()
    records = McapRecords(file.path)
    assert [record.data for record in records if isinstance(record, Message)] == [b"flushed"]
    assert records.damage == []


@pytest.mark.parametrize(
    ("one", "other", "union"),
    [
        (Span(), Span(), Span()),
        (Span(), Span(3, 5), Span(3, 5)),
        (Span(3, 5), Span(), Span(3, 5)),
        (Span(3, 5), Span(4, 9), Span(3, 9)),
        (Span(4, 9), Span(0, 5), Span(0, 9)),
    ],
)
def test_spans_are_united(one: Span, other: Span, union: Span) -> None:
    assert one.union(other) == union
    assert Span(3, 5).duration_ns == 2
    assert Span().duration_ns == 0


def test_spans_and_channels_cannot_be_changed() -> None:
    assert Span() == Span(first_ns=None, last_ns=0)
    for fixed, name in ((Span(3, 5), "last_ns"), (CHANNEL, "name")):
        with pytest.raises(FrozenInstanceError):
            setattr(fixed, name, 7)


def test_a_span_may_begin_at_zero() -> None:
    assert Span(0, 5).duration_ns == 5
    assert Span(0, 5).union(Span(2, 7)) == Span(0, 7)


@pytest.mark.parametrize(("qos", "profiles"), [("- depth: 3\n- depth: 4\n", 2), ("depth: 3", 0), ("[", 0), ("", 0)])
def test_profiles_that_are_not_a_sequence_count_as_none(qos: str, profiles: int) -> None:
    assert len(replace(CHANNEL, qos=qos).profiles()) == profiles


def test_the_minimal_end_is_an_empty_data_end_and_a_footer_without_a_summary() -> None:
    header = struct.pack("<BQII", Opcode.HEADER, 8, 0, 0)
    records = list(StreamReader(BytesIO(MAGIC + header + MINIMAL_END), validate_crcs=True).records)
    assert records[1:] == [DataEnd(0), Footer(0, 0, 0)]
    assert len(MINIMAL_END) == 13 + 29 + len(MAGIC)


def test_a_message_has_its_simulated_time_twice_and_a_sequence_of_32_bits(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "file.mcap", {}, "none")
    for sequence in (0, 1, 2**32 - 1, 2**32, 2**32 + 5):
        file.write(CHANNEL, 7, b"data", sequence)
    file.close({})
    found = [record for record in McapRecords(file.path) if isinstance(record, Message)]
    assert [message.sequence for message in found] == [0, 1, 2**32 - 1, 0, 5]
    assert {(message.log_time, message.publish_time, message.data) for message in found} == {(7, 7, b"data")}
    assert file.counts == {CHANNEL: 5}


def test_channels_and_types_are_described_once(tmp_path: Path) -> None:
    same_type = channel_of(ROLLER_STATES, NAMESPACE)
    file = McapFile(tmp_path / "file.mcap", {}, "none")
    for channel in (CHANNEL, same_type, CHANNEL, channel_of(VIBRATION, NAMESPACE)):
        file.write(channel, 0, b"data", 0)
    file.close({})
    with file.path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert [channel.topic for channel in summary.channels.values()] == [
        topic.resolved(NAMESPACE) for topic in (FEATURES, ROLLER_STATES, VIBRATION)
    ]
    assert [schema.name for schema in summary.schemas.values()] == [FEATURES.type, VIBRATION.type]
    assert summary.channels[1].metadata == {"offered_qos_profiles": CHANNEL.qos, "topic_type_hash": CHANNEL.type_hash}


def test_a_full_chunk_survives_a_failure_after_it(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "file.mcap", {}, "none")
    for number in range(3):
        file.write(CHANNEL, number * MS, bytes(CHUNK // 2), number)
    file.flush_due()
    file.write(CHANNEL, 3 * MS, b"lost", 3)
    file.abandon()
    assert times_on_disk(file.path) == [0, 1]


def test_a_finished_file_is_not_abandoned(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "file.mcap", {}, "none")
    file.write(CHANNEL, 0, b"data", 0)
    file.close({})
    whole = file.path.read_bytes()
    file.abandon()
    assert file.path.read_bytes() == whole


@pytest.mark.parametrize(("time_ns", "written"), [(499_999_999, 0), (500_000_000, 1)])
def test_the_flush_is_due_at_half_a_second_to_the_nanosecond(time_ns: int, written: int, tmp_path: Path) -> None:
    file = McapFile(tmp_path / "file.mcap", {}, "none")
    file.write(CHANNEL, time_ns, b"small", 0)
    file.flush_due()
    assert len(times_on_disk(file.path)) == written
