"""Reading the records of an MCAP file: which are yielded, which are reported as damaged."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.records import Channel, Header, Message, Metadata
from mcap.writer import Writer

from dcrb_ros.messages.topics import FEATURES, NAMESPACE, VIBRATION
from dcrb_ros.recordings import mcap_reader
from dcrb_ros.recordings.mcap_reader import MAGIC, MAX_DAMAGE, McapRecords, has_summary
from dcrb_ros.recordings.mcap_writer import McapFile
from dcrb_ros.recordings.recorder import channel_of

UNKNOWN = 0x80
"""An opcode that the specification of MCAP leaves to applications."""
CHUNK_HEADER = struct.calcsize("<QQQIIQ")
"""Size of the fields of an uncompressed chunk before its data [bytes]."""


def record(opcode: int, payload: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(payload)) + payload


def text(content: str) -> bytes:
    return struct.pack("<I", len(content)) + content.encode()


def message(data: bytes, *, channel: int = 1, sequence: int = 7) -> bytes:
    return record(Opcode.MESSAGE, struct.pack("<HIQQ", channel, sequence, 10, 20) + data)


def metadata(name: str) -> bytes:
    return record(Opcode.METADATA, text(name) + struct.pack("<I", 0))


def chunk(data: bytes, *, compression: str = "", packed: bytes | None = None, size: int | None = None, checksum: int = 0) -> bytes:
    content = data if packed is None else packed
    claimed = len(data) if size is None else size
    fields = struct.pack("<QQQI", 0, 0, claimed, checksum) + text(compression) + struct.pack("<Q", len(content))
    return record(Opcode.CHUNK, fields + content)


HEADER = record(Opcode.HEADER, text("ros2") + text("test"))
END = record(Opcode.DATA_END, bytes(4)) + record(Opcode.FOOTER, bytes(20)) + MAGIC


def records_of(folder: Path, *parts: bytes, chunks: bool = True) -> tuple[list[object], list[str]]:
    """Return the records of a file with some content, and the damage without the name of the file."""
    path = folder / "x.mcap"
    path.write_bytes(MAGIC + b"".join(parts))
    records = McapRecords(path, chunks=chunks)
    return list(records), [sentence.removeprefix("x.mcap: ") for sentence in records.damage]


def data_of(records: list[object]) -> list[bytes]:
    return [found.data for found in records if isinstance(found, Message)]


def test_records_in_and_between_chunks_are_read_and_unknown_ones_are_skipped(tmp_path: Path) -> None:
    inner = record(UNKNOWN, b"ignored") + message(b"one") + message(b"two")
    found, damage = records_of(tmp_path, HEADER, record(UNKNOWN, b"ignored"), chunk(inner), message(b"three"), metadata("m"), END)
    assert [type(one) for one in found] == [Header, Message, Message, Message, Metadata]
    assert data_of(found) == [b"one", b"two", b"three"]
    assert (found[1], found[3]) == (Message(1, 10, b"one", 20, 7), Message(1, 10, b"three", 20, 7))
    assert damage == []


def test_without_chunks_only_the_records_between_them_are_read(tmp_path: Path) -> None:
    found, damage = records_of(tmp_path, HEADER, chunk(message(b"one")), metadata("m"), END, chunks=False)
    assert [type(one) for one in found] == [Header, Metadata]
    assert damage == []


def test_nothing_is_read_after_the_footer(tmp_path: Path) -> None:
    found, damage = records_of(tmp_path, HEADER, END, metadata("m"))
    assert [type(one) for one in found] == [Header]
    assert damage == []


def test_a_file_that_ends_after_a_record_lacks_its_footer_only(tmp_path: Path) -> None:
    content = HEADER + metadata("m")
    found, damage = records_of(tmp_path, content)
    assert [type(one) for one in found] == [Header, Metadata]
    assert damage == [f"the footer is missing at {len(MAGIC + content)}"]
    assert records_of(tmp_path) == ([], ["the footer is missing at 8"])


@pytest.mark.parametrize("kept", range(-1, -len(metadata("m")), -1))
def test_a_record_that_is_cut_off_is_reported_with_its_place(kept: int, tmp_path: Path) -> None:
    content = HEADER + metadata("m")
    found, damage = records_of(tmp_path, content[:kept])
    assert [type(one) for one in found] == [Header]
    assert damage == [f"the record at byte {len(MAGIC + HEADER)} reaches beyond the end of the file at {len(MAGIC + content) + kept}"]


def test_a_file_without_magic_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(b"\x88" + MAGIC[1:] + HEADER)
    records = McapRecords(path)
    assert list(records) == []
    assert records.damage == ["x.mcap: it does not begin as an MCAP file"]
    assert list(records) == []
    assert len(records.damage) == 1  # of the last reading


COMPRESSED = {
    "zstd": zstandard.ZstdCompressor().compress,
    "zstd without its size": lambda data: zstandard.ZstdCompressor(write_content_size=False).compress(data),
    "lz4": lz4.frame.compress,
    "": bytes,
}


@pytest.mark.parametrize("name", COMPRESSED)
@pytest.mark.parametrize("data", [message(b"one"), b""], ids=["message", "empty"])
def test_chunks_of_each_compression_are_read(name: str, data: bytes, tmp_path: Path) -> None:
    packed = chunk(data, compression=name.split(" ")[0], packed=COMPRESSED[name](data), checksum=zlib.crc32(data))
    found, damage = records_of(tmp_path, HEADER, packed, END)
    assert data_of(found) == ([b"one"] if data else [])
    assert damage == []


@pytest.mark.parametrize("name", COMPRESSED)
@pytest.mark.parametrize("error", [-1, 1])
def test_a_chunk_of_another_size_than_it_claims_is_damage(name: str, error: int, tmp_path: Path) -> None:
    data = message(b"one") + record(UNKNOWN, b"")
    packed = chunk(data, compression=name.split(" ")[0], packed=COMPRESSED[name](data), size=len(data) + error)
    found, damage = records_of(tmp_path, HEADER, packed, metadata("m"), END)
    assert [type(one) for one in found] == [Header, Metadata]
    (sentence,) = damage
    assert sentence.startswith(f"the record at byte {len(MAGIC + HEADER)} is damaged (")
    if name in ("zstd", ""):
        assert f"a chunk contains {len(data)} bytes instead of {len(data) + error}" in sentence


def test_the_reason_of_damage_is_never_empty(tmp_path: Path) -> None:
    """The parser of MCAP raises an error without a text at the end of the data."""
    _, damage = records_of(tmp_path, HEADER, record(Opcode.METADATA, b""), chunk(record(Opcode.SCHEMA, b"")), END)
    at = len(MAGIC + HEADER)
    assert damage == [
        f"the record at byte {at} is damaged (EndOfFile)",
        f"a record in the chunk at byte {at + len(record(Opcode.METADATA, b''))} is damaged (EndOfFile)",
    ]


@pytest.mark.parametrize("opcode", [Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL])
@pytest.mark.parametrize("payload", [b"", b"\x01", b"\x01\x00\x09"])
def test_a_damaged_record_in_a_chunk_leaves_the_others_readable(opcode: int, payload: bytes, tmp_path: Path) -> None:
    for inner in (message(b"one") + record(opcode, payload) + message(b"two"), message(b"one") + message(b"two") + record(opcode, payload)):
        found, damage = records_of(tmp_path, HEADER, chunk(inner), END)
        assert data_of(found) == [b"one", b"two"]
        assert [sentence.startswith(f"a record in the chunk at byte {len(MAGIC + HEADER)} is damaged (") for sentence in damage] == [True]


@pytest.mark.parametrize(
    ("opcode", "payload"),
    [
        (Opcode.SCHEMA, struct.pack("<H", 1) + text("std_msgs/msg/Float64") + text("ros2msg") + struct.pack("<I", 2**31) + b"float64 data"),
        (Opcode.CHANNEL, struct.pack("<HHI", 2, 1, 2**31) + b"/topic"),
        (Opcode.CHANNEL, struct.pack("<HH", 2, 1) + text("/topic") + struct.pack("<I", 2**31) + b"cdr"),
    ],
)
def test_a_field_that_claims_more_than_its_record_has_is_damage(opcode: int, payload: bytes, tmp_path: Path) -> None:
    """The parser of MCAP takes what there is, so the description of a type or a topic would be shortened without a word."""
    found, damage = records_of(tmp_path, HEADER, chunk(record(opcode, payload) + message(b"one")), END)
    assert data_of(found) == [b"one"]
    assert not any(hasattr(one, "id") for one in found)
    assert [sentence.split("(")[1].startswith("a field claims 2147483648 bytes, but only ") for sentence in damage] == [True]


def test_a_hundred_sentences_about_damage_are_kept(tmp_path: Path) -> None:
    _, damage = records_of(tmp_path, HEADER, *[record(Opcode.METADATA, b"")] * 150, END)
    assert len(damage) == MAX_DAMAGE == 100


@pytest.mark.parametrize("excess", [0, 1])
def test_records_up_to_the_limit_are_read(excess: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    long = metadata("a long name")
    monkeypatch.setattr(mcap_reader, "MAX_RECORD", len(long) - 9 - excess)
    found, damage = records_of(tmp_path, HEADER, long, metadata("m"), END)
    at, limit = len(MAGIC + HEADER), mcap_reader.MAX_RECORD
    assert [one.name for one in found if isinstance(one, Metadata)] == (["m"] if excess else ["a long name", "m"])
    assert damage == ([f"the record at byte {at} claims {limit + 1} bytes; at most {limit} are read"] if excess else [])


@pytest.mark.parametrize("excess", [0, 1])
@pytest.mark.parametrize("name", ["zstd", "lz4"])
def test_chunks_up_to_the_limit_are_unpacked(excess: int, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = message(bytes(2000))
    monkeypatch.setattr(mcap_reader, "MAX_RECORD", len(data) - excess)
    found, damage = records_of(tmp_path, HEADER, chunk(data, compression=name, packed=COMPRESSED[name](data)), END)
    assert data_of(found) == ([] if excess else [bytes(2000)])
    assert [f"a chunk claims {len(data)} bytes, at most {len(data) - 1} are read" in sentence for sentence in damage] == [True] * excess


@pytest.mark.parametrize("excess", [0, 1])
def test_the_size_in_a_frame_of_zstd_is_checked_before_it_is_unpacked(excess: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = message(bytes(2000))
    monkeypatch.setattr(mcap_reader, "MAX_RECORD", len(data) - excess)
    _, damage = records_of(tmp_path, HEADER, chunk(data, compression="zstd", packed=COMPRESSED["zstd"](data), size=10), END)
    expected = f"a chunk unpacks to {len(data)} bytes, at most {len(data) - 1} are read" if excess else f"{len(data)} bytes instead of 10"
    assert expected in damage[0]


def test_sixteen_megabytes_of_manifest_can_be_read(tmp_path: Path) -> None:
    """The recorder limits the outcome record to 16 MiB."""
    entry = record(Opcode.METADATA, text("m") + struct.pack("<I", 24 + (1 << 24)) + text("key") + text("x" * ((1 << 24) + 13)))
    found, damage = records_of(tmp_path, HEADER, entry, END)
    assert [type(one) for one in found] == [Header, Metadata]
    assert damage == []


@pytest.fixture
def four(tmp_path: Path) -> tuple[Path, list[int]]:
    """Four chunks with two messages each, on two topics; return the file and the positions of the chunks."""
    path = tmp_path / "four.mcap"
    file, starts = McapFile(path, {}, "none"), []
    for number in range(4):
        starts.append(file.size)
        for topic in (FEATURES, VIBRATION):
            file.write(channel_of(topic, NAMESPACE), number, b"%d" % number, number)
        file.flush()
    file.close({})
    return path, starts


@pytest.mark.parametrize("number", range(4))
def test_an_invalid_length_loses_its_chunk_only(number: int, four: tuple[Path, list[int]]) -> None:
    path, starts = four
    broken = bytearray(path.read_bytes())
    assert broken[starts[number]] == Opcode.CHUNK
    broken[starts[number] + 1 : starts[number] + 9] = struct.pack("<Q", 1 << 62)
    path.write_bytes(broken)
    records = McapRecords(path)
    assert data_of(list(records)) == [b"%d" % k for k in range(4) if k != number for _ in range(2)]
    assert records.damage == [f"four.mcap: the record at byte {starts[number]} reaches beyond the end of the file at {len(broken)}"]


def test_channels_are_known_from_the_summary_when_the_chunk_that_defines_them_is_damaged(four: tuple[Path, list[int]]) -> None:
    path, starts = four
    broken = bytearray(path.read_bytes())
    broken[starts[0] + 9 + CHUNK_HEADER + 20] ^= 0xFF
    path.write_bytes(broken)
    records = McapRecords(path, topics={VIBRATION.resolved(NAMESPACE)})
    found = list(records)
    assert data_of(found) == [b"1", b"2", b"3"]
    assert ["the checksum of a chunk does not match its data" in sentence for sentence in records.damage] == [True]


def in_summary(path: Path) -> int:
    """Return how many channels are yielded before the header: those of the summary."""
    types = [type(one) for one in McapRecords(path, chunks=False)]
    return types[: types.index(Header)].count(Channel)


@pytest.mark.parametrize("end", [b"", b"\x00"], ids=["cut off", "overwritten"])
def test_a_summary_without_the_magic_after_it_is_not_used(end: bytes, four: tuple[Path, list[int]]) -> None:
    path, _ = four
    whole = path.read_bytes()
    assert in_summary(path) == 2
    path.write_bytes(whole[:-1] + end)
    assert in_summary(path) == 0
    assert len(data_of(list(McapRecords(path)))) == 8


def test_a_changed_summary_is_none_for_other_readers(four: tuple[Path, list[int]]) -> None:
    path, _ = four
    whole = path.read_bytes()
    assert has_summary(path)
    (begin,) = struct.unpack_from("<Q", whole, len(whole) - len(MAGIC) - 20)
    for place in (begin + 40, len(whole) - len(MAGIC) - 8, len(whole) - len(MAGIC) - 1):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        assert not has_summary(path)
    path.write_bytes(whole[: -len(MAGIC) - 4] + bytes(4) + MAGIC)  # of a writer without checksums
    assert has_summary(path)


@pytest.mark.parametrize("byte", [b"\xae", b"x"], ids=["no text", "another topic"])
def test_a_channel_that_was_changed_in_the_summary_is_read_from_its_chunk(byte: bytes, four: tuple[Path, list[int]]) -> None:
    path, _ = four
    whole, topic = path.read_bytes(), VIBRATION.resolved(NAMESPACE)
    place = whole.rindex(topic.encode())
    path.write_bytes(whole[:place] + byte + whole[place + 1 :])
    records = McapRecords(path, topics={topic})
    assert data_of(list(records)) == [b"0", b"1", b"2", b"3"]
    assert records.damage == ["four.mcap: the summary does not match its checksum, so it is not used"]


def test_a_summary_with_two_channels_of_one_number_is_not_used(four: tuple[Path, list[int]]) -> None:
    path, _ = four
    whole = path.read_bytes()
    first, second = [record for record in McapRecords(path, chunks=False) if isinstance(record, Channel)][:2]
    place = whole.rindex(second.topic.encode()) - struct.calcsize("<HHI")
    assert struct.unpack_from("<H", whole, place) == (second.id,)
    whole = whole[:place] + struct.pack("<H", first.id) + whole[place + 2 : -len(MAGIC) - 4] + bytes(4) + MAGIC  # without a checksum
    path.write_bytes(whole)
    records = McapRecords(path)
    assert len(data_of(list(records))) == 8
    assert records.damage == ["four.mcap: the summary gives one number to two schemas or channels, so it is not used"]


@pytest.mark.parametrize("begin", [0, 7, 1 << 40], ids=["none", "in the magic", "beyond the end"])
def test_an_impossible_place_of_the_summary_counts_as_none(begin: int, four: tuple[Path, list[int]]) -> None:
    path, _ = four
    broken = bytearray(path.read_bytes())
    at = len(broken) - len(MAGIC) - 20
    broken[at : at + 8] = struct.pack("<Q", begin)
    path.write_bytes(broken)
    assert in_summary(path) == 0
    assert len(data_of(list(McapRecords(path)))) == 8


@pytest.mark.parametrize("begin", [1 << 40, 1 << 62, (1 << 64) - 1], ids=["beyond the end", "no place", "no offset"])
def test_a_chunk_that_the_summary_puts_beyond_the_end_is_not_searched_there(begin: int, four: tuple[Path, list[int]]) -> None:
    path, _ = four
    broken = bytearray(path.read_bytes())
    (at,) = struct.unpack_from("<Q", broken, len(broken) - len(MAGIC) - 20)
    while broken[at] != Opcode.FOOTER:
        opcode, length = struct.unpack_from("<BQ", broken, at)
        if opcode == Opcode.CHUNK_INDEX:
            broken[at + 9 + 16 : at + 9 + 24] = struct.pack("<Q", begin)
        at += 9 + length
    broken[len(MAGIC) + 1 : len(MAGIC) + 9] = struct.pack("<Q", 1 << 40)  # the length of the first record
    path.write_bytes(broken)
    records = McapRecords(path)
    assert data_of(list(records)) == []
    assert any("reaches beyond the end of the file" in sentence for sentence in records.damage)


@pytest.mark.parametrize("excess", [0, 1])
def test_a_summary_up_to_the_limit_is_read(excess: int, four: tuple[Path, list[int]], monkeypatch: pytest.MonkeyPatch) -> None:
    path, _ = four
    whole = path.read_bytes()
    footer = len(whole) - len(MAGIC) - 20 - 9
    (begin,) = struct.unpack_from("<Q", whole, footer + 9)
    monkeypatch.setattr(mcap_reader, "MAX_RECORD", footer - begin - excess)
    assert in_summary(path) == (0 if excess else 2)


def test_messages_of_other_topics_are_skipped_until_their_channel_gets_another_topic(tmp_path: Path) -> None:
    def channel(topic: str) -> bytes:
        return record(Opcode.CHANNEL, struct.pack("<HH", 1, 0) + text(topic) + text("cdr") + struct.pack("<I", 0))

    path = tmp_path / "x.mcap"
    inner = channel("/other") + message(b"other") + channel("/wanted") + message(b"wanted") + channel("/other") + message(b"other")
    path.write_bytes(MAGIC + HEADER + chunk(inner) + END)
    assert data_of(list(McapRecords(path, topics={"/wanted"}))) == [b"wanted"]
    assert data_of(list(McapRecords(path))) == [b"other", b"wanted", b"other"]


def test_a_file_of_another_writer_without_chunks_is_read(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, use_chunking=False)
        writer.start(profile="ros2")
        channel = writer.register_channel("/number", "cdr", writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data"))
        for number in range(3):
            writer.add_message(channel, number, b"%d" % number, number)
        writer.finish()
    records = McapRecords(path)
    assert data_of(list(records)) == [b"0", b"1", b"2"]
    assert records.damage == []


def unchunked(path: Path, *topics: str) -> Path:
    """Write a file without chunks: a message on each topic."""
    with path.open("wb") as stream:
        writer = Writer(stream, use_chunking=False)
        writer.start(profile="ros2")
        known = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        for number, topic in enumerate(topics):
            writer.add_message(writer.register_channel(topic, "cdr", known), number, topic.encode(), number)
        writer.finish()
    return path


@pytest.mark.parametrize("summary", [True, False])
def test_only_the_topics_asked_for_are_read_outside_chunks(summary: bool, tmp_path: Path) -> None:
    path = unchunked(tmp_path / "x.mcap", "/other", "/wanted", "/third")
    if not summary:
        whole = path.read_bytes()
        path.write_bytes(whole[: whole.index(record(Opcode.DATA_END, b"")[:1] + struct.pack("<Q", 4))] + END)
    records = McapRecords(path, topics={"/wanted"})
    assert data_of(list(records)) == [b"/wanted"]
    assert records.damage == []


def test_a_record_that_reaches_beyond_its_chunk_is_damage(tmp_path: Path) -> None:
    inner = message(b"one") + message(b"two")[:-1]
    found, damage = records_of(tmp_path, HEADER, chunk(inner), END)
    assert data_of(found) == [b"one"]
    assert damage == [f"a record in the chunk at byte {len(MAGIC + HEADER)} is damaged (it reaches 1 bytes beyond the end of the chunk)"]


@pytest.mark.parametrize("kind", [Opcode.CHANNEL, Opcode.SCHEMA])
def test_a_channel_or_schema_that_differs_from_the_summary_is_damage(kind: int, four: tuple[Path, list[int]]) -> None:
    path, starts = four
    broken = bytearray(path.read_bytes())
    old, new = {Opcode.CHANNEL: (b"/dcrb/outer_ring/vibration", b"/dcrb/outer_ring/vibratiox"), Opcode.SCHEMA: (b"ros2msg", b"ros2msh")}[
        kind
    ]
    at = broken.index(old, starts[0])
    broken[at : at + len(old)] = new
    crc = starts[0] + 9 + struct.calcsize("<QQQ")
    broken[crc : crc + 4] = bytes(4)  # not checked
    path.write_bytes(broken)
    records = McapRecords(path, topics={VIBRATION.resolved(NAMESPACE)})
    assert data_of(list(records)) == [b"0", b"1", b"2", b"3"]
    assert [sentence.endswith("differs from that in the summary)") for sentence in records.damage] == [True]


@pytest.mark.parametrize("beyond", [0, 1])
def test_the_size_of_all_unpacked_chunks_is_limited(beyond: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = message(bytes(100))
    parts = [HEADER, *[chunk(data, compression="zstd", packed=zstandard.compress(data))] * (3 + beyond), END]
    monkeypatch.setattr(mcap_reader, "MAX_RATIO", 0)
    monkeypatch.setattr(mcap_reader, "LEAST_UNPACKED", 3 * len(data) - beyond)
    found, damage = records_of(tmp_path, *parts)
    assert sum(isinstance(one, Message) for one in found) == 3 - beyond
    if beyond:
        (sentence,) = damage
        assert f"the chunks up to it unpack to {3 * len(data)} bytes, of this file at most {3 * len(data) - 1} are unpacked" in sentence
    monkeypatch.setattr(mcap_reader, "MAX_RATIO", 3)  # of the size of the file
    assert records_of(tmp_path, *parts)[1] == []
