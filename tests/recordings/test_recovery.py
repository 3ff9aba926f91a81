"""Recovery: the readable part of a damaged recording becomes a complete one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from made_up_blocks import BODIES, encoded, recorded, written
from mcap.reader import make_reader
from mcap.records import Metadata
from mcap.writer import Writer
from rosbags.highlevel import AnyReader
from separate_process import fresh_dcrb

from dcrb_ros.messages.topics import FEATURES, GROUND_TRUTH, MANIFEST, NAMESPACE, VIBRATION, Message
from dcrb_ros.recordings import recovery
from dcrb_ros.recordings.manifest import OUTCOME, opening
from dcrb_ros.recordings.mcap_reader import McapRecords
from dcrb_ros.recordings.mcap_writer import Channel, described_channel
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import channel_of
from dcrb_ros.recordings.recovery import Recovered, recover
from dcrb_ros.recordings.splitting import Bag
from dcrb_ros.recordings.verification import RECOVERY, metadata_flaw
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.events import LoadCommand

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("bags") / "bag", 150, events={7: LoadCommand(0.0, -90000.0)})


def waveform(bag: Path) -> list[int]:
    return [block.first_index(51200) for block in Recording(bag).vibrations()]


def test_a_cut_off_recording_becomes_complete(bag: Path, tmp_path: Path) -> None:
    whole = (bag / "bag_0.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: int(0.6 * len(whole))])
    done = fresh_dcrb("recover", str(cut), "-o", str(tmp_path / "new"))
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


def test_a_complete_recording_is_recovered_unchanged(bag: Path, tmp_path: Path) -> None:
    salvage = recover(bag, tmp_path / "new")
    assert salvage.damage == ()
    old, new = Recording(bag), Recording(tmp_path / "new")
    assert new.outcome is not None
    assert old.outcome is not None
    assert (new.outcome["sha256"], new.outcome["commands"]) == (old.outcome["sha256"], old.outcome["commands"])
    assert [(m.topic, m.time_ns, m.data) for m in old.messages()] == [(m.topic, m.time_ns, m.data) for m in new.messages()]


def test_messages_after_a_damaged_chunk_are_recovered(bag: Path, tmp_path: Path) -> None:
    broken = bytearray((bag / "bag_0.mcap").read_bytes())
    broken[len(broken) // 3] ^= 0xFF
    path = tmp_path / "broken.mcap"
    path.write_bytes(broken)
    salvage = recover(path, tmp_path / "new")
    assert len(salvage.damage) == 1
    found = waveform(tmp_path / "new")
    assert 130 < len(found) < 150
    assert found[-1] == 149 * 1024


def test_a_channel_is_described_once_for_all_of_its_messages(bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    channels = list[Channel]()
    monkeypatch.setattr(recovery, "described_channel", lambda *records: channels.append(described_channel(*records)) or channels[-1])
    recover(bag, tmp_path / "new")
    assert len(channels) == len({channel.name for channel in channels}) > 1


def test_a_damaged_length_loses_one_chunk(bag: Path, tmp_path: Path) -> None:
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


def test_a_corrupt_message_is_left_out_and_reported(bag: Path, tmp_path: Path) -> None:
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


@pytest.mark.parametrize("headless", [b"", bytes(4096)], ids=["empty", "zeros"])  # left by a power loss right after a split
def test_a_file_without_a_beginning_is_left_out_and_reported(headless: bytes, tmp_path: Path) -> None:
    split = recorded(tmp_path / "split", 60, split_duration=0.5)
    (split / "split_2.mcap").write_bytes(headless)
    recording = Recording(split)
    assert waveform(split) == [1024 * k for k in range(50)]
    assert not recording.complete
    told = fresh_dcrb("info", str(split))
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


def test_recordings_of_other_programs_are_recovered(tmp_path: Path) -> None:
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


def test_quality_of_service_in_numbers_is_recovered_by_names(tmp_path: Path) -> None:
    """As rosbag2 wrote it before version 9 of its metadata; the recovered bag has version 9, whose readers take names only."""
    path = tmp_path / "old.mcap"
    numbers = (
        "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 2\n  liveliness: 1\n- {reliability: 2, durability: 1, history: 9}\n"
    )
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        schema = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        channel = writer.register_channel("/number", "cdr", schema, {"offered_qos_profiles": numbers})
        writer.add_message(channel, 1, b"\x00\x01\x00\x00" + bytes(8), 1)
        writer.finish()
    recover(path, tmp_path / "new")
    about = yaml.safe_load((tmp_path / "new" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    named = [
        {"history": "unknown", "depth": 0, "reliability": "reliable", "durability": "volatile", "liveliness": "automatic"},
        {"reliability": "best_effort", "durability": "transient_local", "history": 9},
    ]
    assert about["topics_with_message_count"][0]["topic_metadata"]["offered_qos_profiles"] == named
    with (tmp_path / "new" / "new_0.mcap").open("rb") as stream:
        ((_, written, _),) = make_reader(stream).iter_messages()
    assert yaml.safe_load(written.metadata["offered_qos_profiles"]) == named


def test_unrecoverable_input_is_refused(bag: Path, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="exists: give another name"):
        recover(bag, bag)
    head = tmp_path / "head.mcap"
    head.write_bytes((bag / "bag_0.mcap").read_bytes()[:60])
    with pytest.raises(Refusal, match="nothing can be recovered"):
        recover(head, tmp_path / "new")
    assert not (tmp_path / "new").exists()


def compressions(bag: Path) -> set[str]:
    """Return the compressions of the chunks in a recording."""
    found = set()
    for file in sorted(bag.glob("*.mcap")):
        with file.open("rb") as stream:
            summary = make_reader(stream).get_summary()
        assert summary is not None
        found |= {index.compression for index in summary.chunk_indexes}
    return found


def test_the_result_counts_the_messages_and_states_the_last_time(bag: Path, tmp_path: Path) -> None:
    salvage = recover(bag, tmp_path / "new")
    messages = list(Recording(bag).messages())
    assert salvage.messages == len(messages) == sum(Recording(bag).counts().values())
    assert salvage.last_ns == max(message.time_ns for message in messages)
    assert Recovered() == Recovered(messages=0, last_ns=0, damage=())


def test_a_recovered_recording_is_split_and_compressed_like_the_source(tmp_path: Path) -> None:
    split = recorded(tmp_path / "split", 60, split_duration=0.5, compression="lz4")
    recover(split, tmp_path / "new")
    assert [len(waveform(file)) for file in Recording(tmp_path / "new").files] == [25, 25, 10]
    assert compressions(tmp_path / "new") == {"lz4"}


@pytest.mark.parametrize("damaged", [0, 1])
def test_a_sound_manifest_of_any_file_is_kept(damaged: int, tmp_path: Path) -> None:
    """Each file of a split recording has the manifest; an edited one of the first file must not hide that of the second."""
    split = recorded(tmp_path / "split", 60, split_duration=0.6)
    content = (split / f"split_{damaged}.mcap").read_bytes()
    assert b'"rollers_per_row": 16' in content
    (split / f"split_{damaged}.mcap").write_bytes(content.replace(b'"rollers_per_row": 16', b'"rollers_per_row": 17'))
    manifest = Recording(split).manifest
    recover(split, tmp_path / "new")
    recovered = Recording(tmp_path / "new")
    assert recovered.complete
    assert recovered.manifest == manifest


def test_a_manifest_without_a_sound_copy_is_reported(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 3)
    (file,) = bag.glob("*.mcap")
    file.write_bytes(file.read_bytes().replace(b'"rollers_per_row": 16', b'"rollers_per_row": 17'))
    assert recover(bag, tmp_path / "new").damage == (
        "the record dcrb_ros is damaged or was changed; it is kept, and not used by any command",
    )
    assert not Recording(tmp_path / "new").complete


def test_imported_data_are_recovered_as_one_file(tmp_path: Path) -> None:
    messages = encoded(3)
    imported = written(tmp_path / "bag", messages, imported={}, configuration=None, outcome={})
    assert recover(imported, tmp_path / "new").damage == ()
    recording = Recording(tmp_path / "new")
    assert recording.imported
    assert (recording.outcome or {})["samples"] == 3 * 1024
    assert compressions(tmp_path / "new") == {"zstd"}


def test_a_recording_with_an_impossible_sampling_rate_is_recovered(tmp_path: Path) -> None:
    messages = encoded(3)
    bag = written(tmp_path / "bag", messages, sampling_rate=0, outcome={})
    assert recover(bag, tmp_path / "new").messages == len(messages)


def test_a_hundred_sentences_about_corrupt_messages_are_kept(tmp_path: Path) -> None:
    corrupt = [Message(topic, 20_000_000 * k, b"corrupt") for k in range(60) for topic in (VIBRATION, GROUND_TRUTH)]
    source = written(tmp_path / "bag", [*corrupt, Message(FEATURES, 7, b"kept")], outcome={})
    salvage = recover(source, tmp_path / "new")
    assert (salvage.messages, salvage.last_ns, len(salvage.damage)) == (1, 7, 100)
    assert salvage.damage[0].startswith("outer_ring/vibration at 0.000 s: ")
    assert salvage.damage[3].startswith("ground_truth at 0.020 s: ")


def test_messages_of_another_namespace_are_not_examined(tmp_path: Path) -> None:
    source = written(tmp_path / "bag", [Message(VIBRATION, 7, b"corrupt")], below="/other", namespace="/other", outcome={})
    assert Recording(source).manifest["namespace"] == "/other" != NAMESPACE
    with pytest.raises(Refusal, match="no message can be read: outer_ring/vibration"):
        recover(source, tmp_path / "new")
    bag = Bag(tmp_path / "two", opening=opening(Configuration(), BODIES, NAMESPACE), closing=dict)
    bag.write([(channel_of(VIBRATION, "/other"), 7, b"corrupt")])
    bag.close()
    assert recover(tmp_path / "two", tmp_path / "kept").messages == 1


def test_what_was_lost_is_listed_in_the_recovered_recording(bag: Path, tmp_path: Path) -> None:
    whole = (bag / "bag_0.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    salvage = recover(tmp_path / "cut.mcap", tmp_path / "new")
    assert recover(tmp_path / "new", tmp_path / "again").damage == ()
    for folder in ("new", "again"):  # a second recovery keeps the losses of the first
        names = [record for record in McapRecords(tmp_path / folder / f"{folder}_0.mcap", chunks=False) if isinstance(record, Metadata)]
        assert [record.name for record in names] == [MANIFEST, RECOVERY, OUTCOME, "rosbag2"]
        assert json.loads(names[1].metadata["recovery"])["lost"] == list(salvage.damage)


def test_the_reason_why_nothing_can_be_recovered_is_the_first_damage(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=r"because no message can be read$"):
        recover(written(tmp_path / "empty", [], outcome={}), tmp_path / "new")
    source = written(tmp_path / "bag", [Message(VIBRATION, 20_000_000 * k, b"corrupt") for k in range(1, 4)], outcome={})
    with pytest.raises(Refusal, match=r"because no message can be read: outer_ring/vibration at 0\.020 s: "):
        recover(source, tmp_path / "new")


@pytest.mark.parametrize(
    ("encoding", "definition", "words"),
    [
        ("json", "ros2msg", "/number contains json messages defined by ros2msg"),
        ("cdr", "ros1msg", "/number contains cdr messages defined by ros1msg"),
        ("", "", "/number contains unnamed messages defined by nothing"),
    ],
)
def test_messages_of_other_encodings_are_refused(encoding: str, definition: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "foreign.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="")
        channel = writer.register_channel("/number", encoding, writer.register_schema("Number", definition, b"{}"))
        writer.add_message(channel, 0, b"0", 0)
        writer.finish()
    with pytest.raises(Refusal, match=words):
        recover(path, tmp_path / "new")


def test_the_last_time_is_printed_for_people(bag: Path, tmp_path: Path) -> None:
    # The same messages as rosbag2 records them: on the wall clock, and one of them at a time beyond that of ROS.
    path = tmp_path / "wall.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        channel = writer.register_channel("/number", "cdr", writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data"))
        for time_ns in (1_795_337_999_437_000_000, 2**63):
            writer.add_message(channel, time_ns, bytes(12), 0)
        writer.finish()
    done = fresh_dcrb("recover", str(path), "-o", str(tmp_path / "new"))
    assert done.stdout == f"{tmp_path / 'new'}: 1 message, the last at 2026-11-22 08:59:59.437 UTC\n"
    words = "/number has a message at 9223372036854775808 ns, beyond 2262-04-11 23:47:16.854 UTC, which ROS cannot represent"
    assert done.stderr == f"dcrb: {words}\n"
    assert metadata_flaw(tmp_path / "new") == ""
    assert fresh_dcrb("recover", str(bag), "-o", str(tmp_path / "again")).stdout.endswith(" the last at 2.980 s\n")
