"""The files of a recording in each storage and compression of rosbag2."""

from __future__ import annotations

import gc
import gzip
import shutil
import tempfile
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from made_up_blocks import recorded
from mcap.writer import Writer
from ros2_bag_record import bag_of, messages_of

from dcrb_ros.messages.topics import VIBRATION
from dcrb_ros.recordings import compression, mcap_reader
from dcrb_ros.recordings.mcap_reader import MAGIC
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recovery import recover
from dcrb_ros.recordings.storage import StoredFile, valid_files
from dcrb_ros.recordings.verification import metadata_flaw
from dcrb_ros.schema.refusal import Refusal


def test_files_are_in_the_order_of_their_numbers_after_those_without(tmp_path: Path) -> None:
    names = ["bag.mcap", "bag_0.mcap", "bag_2.mcap", "bag_10.mcap", "bag_x.mcap", "cat_1.mcap"]
    for name in sorted(names):
        (tmp_path / name).write_bytes(MAGIC)
    assert [file.path.name for file in valid_files(tmp_path)[0]] == names
    files, damage = valid_files(tmp_path / "bag_2.mcap")
    assert ([file.path for file in files], damage) == ([tmp_path / "bag_2.mcap"], [])


def test_files_that_are_none_are_named_with_the_reason(tmp_path: Path) -> None:
    for name, content in (("a_0.mcap", b""), ("a_1.mcap", b"other bytes")):
        (tmp_path / name).write_bytes(content)
    with pytest.raises(Refusal, match=r"a_0\.mcap is not an MCAP file: it is empty$"):
        valid_files(tmp_path)
    (tmp_path / "a_2.mcap").write_bytes(MAGIC)
    files, damage = valid_files(tmp_path)
    assert [file.path.name for file in files] == ["a_2.mcap"]
    assert damage == [
        "a_0.mcap: left out, not an MCAP file: it is empty",
        f"a_1.mcap: left out, not an MCAP file: it must begin with {MAGIC!r}",
    ]


def read(path: Path) -> tuple[list[bytes], list[str]]:
    """Return the data of the messages in a file, and what could not be read."""
    damage: list[str] = []
    return [stored.message.data for stored in StoredFile(path).messages(damage)], damage


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a bag of 20 blocks."""
    return bag_of(tmp_path_factory.mktemp("bags") / "bag", messages_of(20)) / "bag.mcap"


def test_an_unpacked_file_lies_in_the_temporary_folder_as_long_as_it_is_used(
    plain: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    packed = tmp_path / "bag_0.mcap.zstd"
    packed.write_bytes(zstandard.compress(plain.read_bytes()))
    file = StoredFile(packed)
    assert [one.name for one in tmp_path.iterdir()] == ["bag_0.mcap.zstd"]  # nothing is unpacked before it is needed
    for _ in range(2):
        assert len(list(file.messages([]))) == len(messages_of(20))
        assert len(list(tmp_path.iterdir())) == 2
    del file
    gc.collect()
    assert [one.name for one in tmp_path.iterdir()] == ["bag_0.mcap.zstd"]


def test_of_a_file_and_its_compressed_form_one_is_read(plain: Path, tmp_path: Path) -> None:
    """`ros2 bag play` leaves the unpacked file beside the other."""
    shutil.copy(plain, tmp_path / "bag_0.mcap")
    (tmp_path / "bag_0.mcap.zstd").write_bytes(zstandard.compress(plain.read_bytes()))
    (tmp_path / "bag_1.mcap.zst").write_bytes(zstandard.compress(plain.read_bytes()))
    assert [file.path.name for file in valid_files(tmp_path)[0]] == ["bag_0.mcap", "bag_1.mcap.zst"]
    names = "[bag_0.mcap.zstd, bag_1.mcap.zst]"
    (tmp_path / "metadata.yaml").write_text(f"rosbag2_bagfile_information: {{relative_file_paths: {names}}}")
    assert metadata_flaw(tmp_path) == ""


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        (
            "a.mcap.lz4",
            lz4.frame.compress(MAGIC),
            r"a\.mcap\.lz4 is compressed by lz4, which cannot be read: unpack it first; zstd can be read",
        ),
        ("a.mcap.gz", gzip.compress(MAGIC, mtime=0), r"a\.mcap\.gz is compressed by gzip"),
        ("a.mcap", gzip.compress(MAGIC, mtime=0), r"a\.mcap is compressed by gzip"),
        ("a.db3", b"", r"a\.db3 is not an SQLite file: it is empty"),
        ("a.db3.zstd", zstandard.compress(b"text"), r"a\.db3\.zstd is not an SQLite file: it must begin with b'SQLite format 3"),
        ("a.mcap.zstd", compression.ZSTD + b"damaged", r"a\.mcap\.zstd is not an MCAP file: it cannot be unpacked"),
    ],
)
def test_a_compression_or_content_that_cannot_be_read_is_named(name: str, content: bytes, words: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    for path in (tmp_path, tmp_path / name):
        with pytest.raises(Refusal, match=words):
            valid_files(path)


def test_files_of_both_storages_in_one_folder_are_refused(plain: Path, tmp_path: Path) -> None:
    shutil.copy(plain, tmp_path / "bag_0.mcap")
    shutil.copy(bag_of(tmp_path / "other", messages_of(1), "sqlite3") / "other.db3", tmp_path / "bag_0.db3")
    with pytest.raises(Refusal, match=r"contains both \.mcap and \.db3 files: give the folder of a single recording, or one of the files"):
        valid_files(tmp_path)
    assert len(valid_files(tmp_path / "bag_0.db3")[0]) == 1


def test_the_intact_part_of_a_compressed_file_is_read(tmp_path: Path) -> None:
    own = recorded(tmp_path / "own", 60, compression="none") / "own_0.mcap"
    whole, packed = own.read_bytes(), tmp_path / "bag.mcap.zstd"
    compressor = zstandard.ZstdCompressor().compressobj()
    first = compressor.compress(whole[: 3 * len(whole) // 4]) + compressor.flush(zstandard.COMPRESSOBJ_FLUSH_BLOCK)
    for rest in (b"", b"\xff" * 1000):
        packed.write_bytes(first + rest)
        found, damage = read(packed)
        assert 0 < len(found) < len(read(own)[0])
        assert found == read(own)[0][: len(found)]
        assert all(sentence.startswith("bag.mcap.zstd: ") for sentence in damage)
        assert any("reaches beyond the end of the file" in sentence for sentence in damage)
        assert any("cannot be unpacked beyond byte" in sentence for sentence in damage) is bool(rest)


def test_a_file_is_unpacked_to_a_bounded_size(plain: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compression, "FREE_SIZE", 1000)
    monkeypatch.setattr(compression, "MAX_RATIO", 2)
    monkeypatch.setattr(compression, "PIECE", 100)
    packed = tmp_path / "bag.mcap.zstd"
    packed.write_bytes(zstandard.compress(MAGIC + bytes(100_000)))
    _, damage = read(packed)
    assert damage[0] == "bag.mcap.zstd: it unpacks to more than 1000 bytes, 2 times its size; the rest is left out"


def test_messages_are_unpacked_to_a_bounded_size_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compression, "FREE_SIZE", 5_000)
    monkeypatch.setattr(compression, "MAX_RATIO", 1)
    path = tmp_path / "x.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        channel = writer.register_channel("/number", "cdr", writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data"))
        for number in range(100):
            writer.add_message(channel, number, zstandard.compress(bytes(1000)), number)
        writer.add_message(channel, 100, b"plain", 100)
        writer.finish()
    found, damage = read(path)
    assert len(found) == 7  # up to the message that exceeds the limit, and the one that is not compressed
    assert damage == ["x.mcap: its messages unpack to more than 5000 bytes, 1 times its size; the rest is left out"]


def test_the_chunks_of_a_compressed_file_are_limited_by_its_own_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mcap_reader, "LEAST_UNPACKED", 100_000)
    path, noise = tmp_path / "x.mcap", np.random.default_rng(1).bytes(2000)
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=90_000)
        writer.start(profile="ros2")
        channel = writer.register_channel("/number", "cdr", writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data"))
        for number in range(200):
            writer.add_message(channel, number, noise + bytes(90_000), number)
        writer.finish()
    packed = path.with_name("x.mcap.zstd")
    packed.write_bytes(zstandard.compress(path.read_bytes()))
    most = mcap_reader.MAX_RATIO * packed.stat().st_size
    assert most < 200 * 92_000 < mcap_reader.MAX_RATIO * path.stat().st_size
    found, damage = read(packed)
    assert sum(map(len, found)) <= most
    assert f"of this file at most {most} are unpacked" in damage[0]
    assert len(read(path)[0]) == 200


def test_a_full_temporary_folder_is_refused(plain: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nothing"))
    packed = tmp_path / "bag.mcap.zstd"
    packed.write_bytes(zstandard.compress(plain.read_bytes()))
    with pytest.raises(Refusal, match=r"cannot be unpacked to .*nothing: No such file or directory; make room there or set TMPDIR"):
        read(packed)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (gzip.compress(b"x", mtime=0), "x.mcap: messages are compressed by gzip, which cannot be read; zstd can"),
        (compression.ZSTD + b"damaged", "x.mcap: a message on /number is damaged ("),
    ],
)
def test_messages_that_cannot_be_unpacked_are_reported_once(data: bytes, words: str, tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        channel = writer.register_channel("/number", "cdr", writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data"))
        for number in range(3):
            writer.add_message(channel, number, data, number)
        writer.add_message(channel, 3, b"plain", 3)
        writer.finish()
    found, damage = read(path)
    assert found == [b"plain"]
    assert len(damage) == 1
    assert damage[0].startswith(words)


def test_messages_of_a_channel_without_description_are_reported(plain: Path, tmp_path: Path) -> None:
    whole = plain.read_bytes()
    cut = whole[: whole.index(b"\x0f" + (4).to_bytes(8, "little"))]  # without the summary, which has the channels, too
    name = VIBRATION.resolved("/dcrb").encode()
    at = cut.index(name)
    begin = cut.rindex(b"\x04", 0, at - 8)
    (tmp_path / "x.mcap").write_bytes(cut[:begin] + b"\x80" + cut[begin + 1 :])
    found, damage = read(tmp_path / "x.mcap")
    assert len(found) == len(messages_of(20)) - 20
    assert any("20 messages belong to channel" in sentence for sentence in damage)


@pytest.mark.parametrize(
    ("form", "rereadable"), [("mcap", True), ("mcap_zstd_chunks", True), ("mcap_zstd_messages", False), ("sqlite3", False)]
)
def test_other_readers_take_whole_messages_in_mcap_only(form: str, rereadable: bool, tmp_path: Path) -> None:
    recording = Recording(bag_of(tmp_path / "bag", messages_of(3), form))
    assert recording.counts()
    assert [file.rereadable for file in recording.stored] == [rereadable]


@pytest.mark.parametrize("lost", [[0], [2, 3], [4], [1, 2, 3, 4]])
def test_files_that_metadata_names_and_that_are_missing_are_damage(lost: list[int], tmp_path: Path) -> None:
    # Each file states the samples up to its own end, so that without the last ones the digests agreed.
    bag = recorded(tmp_path / "bag", 100, split_duration=0.4)
    assert (len(Recording(bag).files), Recording(bag).damage) == (5, [])
    for number in lost:
        (bag / f"bag_{number}.mcap").unlink()
    names = ", ".join(f"bag_{number}.mcap" for number in lost)
    recording = Recording(bag)
    assert not recording.complete
    assert recording.damage[0] == f"metadata.yaml names files that are missing: {names}"
    assert recover(bag, tmp_path / "recovered").damage[0] == recording.damage[0]
    assert Recording(tmp_path / "recovered").damage == []


def test_renamed_files_and_damaged_metadata_are_no_missing_files(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 100, split_duration=0.4)
    for number in range(5):
        (bag / f"bag_{number}.mcap").rename(bag / f"run_{number}.mcap")
    assert Recording(bag).damage == []
    for text in ("", "- 1", "rosbag2_bagfile_information: {relative_file_paths: 3}", "{"):
        (bag / "metadata.yaml").write_text(text)
        assert Recording(bag).damage == []
