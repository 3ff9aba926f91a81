"""Repair: what can be read of a damaged recording makes a whole one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command import dcrb
from made_up_blocks import recorded
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.highlevel import AnyReader

from dcrb_ros.messages.topics import NAMESPACE, VIBRATION
from dcrb_ros.recordings.reader import Recording, metadata_flaw
from dcrb_ros.recordings.recovery import recover
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.stream.events import LoadCommand


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("bags") / "bag", 150, events={7: LoadCommand(0.0, -90000.0)})


def waveform(bag: Path) -> list[int]:
    return [block.first_index(51200) for block in Recording(bag).vibrations()]


def test_a_cut_off_recording_becomes_whole(bag: Path, tmp_path: Path) -> None:
    whole = (bag / "bag_0.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: int(0.6 * len(whole))])
    done = dcrb("recover", str(cut), "-o", str(tmp_path / "new"))
    assert done.returncode == 0, done.stderr
    assert "reaches beyond the end of the file" in done.stderr
    assert "Traceback" not in done.stderr
    recording = Recording(tmp_path / "new")
    assert waveform(tmp_path / "new") == waveform(cut)
    assert recording.complete
    assert metadata_flaw(tmp_path / "new") == ""
    assert [timed.command for timed in recording.commands()] == [LoadCommand(0.0, -90000.0)]
    assert recording.configuration == Recording(bag).configuration
    with AnyReader([tmp_path / "new"]) as reader:
        counts = {c.topic: c.msgcount for c in reader.connections}
    assert counts[VIBRATION.resolved(NAMESPACE)] == len(waveform(cut))


def test_a_whole_recording_is_recovered_to_the_same(bag: Path, tmp_path: Path) -> None:
    salvage = recover(bag, tmp_path / "new")
    assert salvage.damage == ()
    old, new = Recording(bag), Recording(tmp_path / "new")
    assert new.outcome is not None
    assert old.outcome is not None
    assert (new.outcome["sha256"], new.outcome["commands"]) == (old.outcome["sha256"], old.outcome["commands"])
    assert [(m.topic, m.time_ns, m.data) for m in old.messages()] == [(m.topic, m.time_ns, m.data) for m in new.messages()]


def test_what_lies_behind_a_damaged_chunk_is_saved(bag: Path, tmp_path: Path) -> None:
    broken = bytearray((bag / "bag_0.mcap").read_bytes())
    broken[len(broken) // 3] ^= 0xFF
    path = tmp_path / "broken.mcap"
    path.write_bytes(broken)
    salvage = recover(path, tmp_path / "new")
    assert len(salvage.damage) == 1
    found = waveform(tmp_path / "new")
    assert 130 < len(found) < 150
    assert found[-1] == 149 * 1024


def test_damaged_lengths_lose_one_chunk(bag: Path, tmp_path: Path) -> None:
    from mcap.reader import make_reader

    whole = bytearray((bag / "bag_0.mcap").read_bytes())
    with (bag / "bag_0.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    start = summary.chunk_indexes[3].chunk_start_offset
    whole[start + 1 : start + 9] = np.uint64(2**63).tobytes()
    path = tmp_path / "lengths.mcap"
    path.write_bytes(whole)
    recording = Recording(path)
    found = [block.first_index(51200) for block in recording.vibrations()]
    assert 130 < len(found) < 150
    assert not recording.complete


def test_a_message_that_is_none_is_left_out_and_named(bag: Path, tmp_path: Path) -> None:
    # Damage that no checksum tells of.
    broken, blocks = tmp_path / "broken.mcap", 0
    with (bag / "bag_0.mcap").open("rb") as source, broken.open("wb") as stream:
        reader, writer, channels = make_reader(source), Writer(stream), {}
        writer.start(profile="ros2")
        for schema, channel, message in reader.iter_messages():
            if channel.topic not in channels:
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, channel.message_encoding, known, channel.metadata)
            blocks += channel.topic == VIBRATION.resolved(NAMESPACE)
            third = channel.topic == VIBRATION.resolved(NAMESPACE) and blocks == 3
            data = message.data[:40] + b"\xff" * 8 + message.data[48:] if third else message.data
            writer.add_message(channels[channel.topic], message.log_time, data, message.publish_time, message.sequence)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, dict(metadata.metadata))
        writer.finish()
    salvage = recover(broken, tmp_path / "new")
    assert any("outer_ring/vibration at 0.040 s" in words for words in salvage.damage)
    recording = Recording(tmp_path / "new")
    assert recording.complete
    assert metadata_flaw(tmp_path / "new") == ""
    assert waveform(tmp_path / "new") == [index for index in waveform(bag) if index != 2048]


@pytest.mark.parametrize("headless", [b"", bytes(4096)], ids=["empty", "zeros"])  # what a power loss leaves of a file just begun
def test_a_file_that_has_not_begun_is_left_out_and_named(headless: bytes, tmp_path: Path) -> None:
    split = recorded(tmp_path / "split", 60, split_duration=0.5)
    (split / "split_2.mcap").write_bytes(headless)
    recording = Recording(split)
    assert waveform(split) == [1024 * k for k in range(50)]
    assert not recording.complete
    told = dcrb("info", str(split))
    assert (told.returncode, "damaged: split_2.mcap: left out, not an MCAP file" in told.stdout) == (0, True), told.stdout + told.stderr
    salvage = recover(split, tmp_path / "new")
    assert len(salvage.damage) == 1
    assert "split_2.mcap: left out" in salvage.damage[0]
    assert waveform(tmp_path / "new") == waveform(split)
    assert Recording(tmp_path / "new").complete
    for file in split.glob("*.mcap"):
        file.write_bytes(headless)
    with pytest.raises(Refusal, match=r"split_0\.mcap is not an MCAP file"):
        Recording(split)


def test_foreign_recordings_are_repaired_too(tmp_path: Path) -> None:
    path = tmp_path / "foreign.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        schema = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        channel = writer.register_channel("/number", "cdr", schema)
        for k in range(5):
            writer.add_message(channel, k, b"\x00\x01\x00\x00" + bytes(8), k)
        writer.flush()
    salvage = recover(path, tmp_path / "new")
    assert salvage.messages == 5
    with AnyReader([tmp_path / "new"]) as reader:
        assert [(c.topic, c.msgcount) for c in reader.connections] == [("/number", 5)]


def test_what_cannot_be_recovered_is_refused(bag: Path, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="exists: give another name"):
        recover(bag, bag)
    head = tmp_path / "head.mcap"
    head.write_bytes((bag / "bag_0.mcap").read_bytes()[:60])
    with pytest.raises(Refusal, match="nothing can be recovered"):
        recover(head, tmp_path / "new")
    assert not (tmp_path / "new").exists()
