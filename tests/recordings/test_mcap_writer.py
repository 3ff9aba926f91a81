"""Writing an MCAP file: what has reached the disk at each time."""

from __future__ import annotations

from pathlib import Path

import pytest
from mcap.records import Message

from dcrb_ros.messages.topics import FEATURES, NAMESPACE
from dcrb_ros.recordings.mcap_reader import McapRecords
from dcrb_ros.recordings.mcap_writer import CHUNK, McapFile, Span
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
