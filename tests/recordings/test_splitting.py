"""A rosbag2 folder: its metadata, and when it continues in a new file."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml
from mcap.records import Message, Metadata

from dcrb_ros import __version__
from dcrb_ros.messages.topics import FEATURES, NAMESPACE, SENSOR, VIBRATION
from dcrb_ros.recordings.mcap_reader import McapRecords
from dcrb_ros.recordings.mcap_writer import Channel
from dcrb_ros.recordings.recorder import channel_of
from dcrb_ros.recordings.splitting import SECOND, Bag, RecordingFailed
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import Recording

ONE, OTHER, LATCHED = (channel_of(topic, NAMESPACE) for topic in (FEATURES, VIBRATION, SENSOR))
MS = 1_000_000


def bag_of(path: Path, messages: Sequence[tuple[Channel, int, bytes]] = (), *, size: int = 0, duration_ns: int = 0) -> Bag:
    settings = Recording(compression="none", split_size=size, split_duration=duration_ns / SECOND)
    bag = Bag(path, opening={"first": {"a": "1"}}, closing=lambda: {"last": {"b": "2"}}, settings=settings)
    bag.write(messages)
    return bag


def at(*times: int) -> list[tuple[Channel, int, bytes]]:
    """Return messages at some times [ms]."""
    return [(ONE, time * MS, b"data") for time in times]


def times_in(path: Path) -> list[int]:
    """Return the times of the messages in a file [ms]."""
    return [record.log_time // MS for record in McapRecords(path) if isinstance(record, Message)]


def metadata_of(bag: Bag) -> dict[str, Any]:
    text = (bag.path / "metadata.yaml").read_text()
    assert text.index("version:") < text.index("storage_identifier:") < text.index("relative_file_paths:")
    found: dict[str, Any] = yaml.safe_load(text)["rosbag2_bagfile_information"]
    return found


def topic(channel: Channel, count: int) -> dict[str, Any]:
    about = {"name": channel.name, "type": channel.type, "serialization_format": "cdr"}
    about |= {"offered_qos_profiles": yaml.safe_load(channel.qos), "type_description_hash": channel.type_hash}  # type: ignore[dict-item]
    return {"topic_metadata": about, "message_count": count}


def test_metadata_state_the_content_of_each_file(tmp_path: Path) -> None:
    messages = [(ONE, 3 * MS, b"1"), (OTHER, 5 * MS, b"2"), (ONE, 9 * MS, b"3"), (ONE, 13 * MS, b"4"), (ONE, 14 * MS, b"5")]
    bag = bag_of(tmp_path / "bag", messages, duration_ns=10 * MS)
    bag.close()
    assert metadata_of(bag) == {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": 11 * MS},
        "starting_time": {"nanoseconds_since_epoch": 3 * MS},
        "message_count": 5,
        "topics_with_message_count": [topic(ONE, 4), topic(OTHER, 1)],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": ["bag_0.mcap", "bag_1.mcap"],
        "files": [
            {
                "path": "bag_0.mcap",
                "starting_time": {"nanoseconds_since_epoch": 3 * MS},
                "duration": {"nanoseconds": 6 * MS},
                "message_count": 3,
            },
            {
                "path": "bag_1.mcap",
                "starting_time": {"nanoseconds_since_epoch": 13 * MS},
                "duration": {"nanoseconds": 1 * MS},
                "message_count": 2,
            },
        ],
        "custom_data": {"dcrb_ros": __version__},
        "ros_distro": "jazzy",
    }
    for number, file in enumerate(bag.files):
        records = {record.name: record.metadata for record in McapRecords(file) if isinstance(record, Metadata)}
        assert (records["first"], records["last"]) == ({"a": "1"}, {"b": "2"})
        text = records["rosbag2"]["serialized_metadata"]
        assert text.startswith("version: 9\nstorage_identifier: mcap\n")
        assert yaml.safe_load(text)["files"] == [metadata_of(bag)["files"][number]]


def test_a_bag_without_messages_begins_at_zero(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag")
    about = metadata_of(bag)
    assert (about["starting_time"], about["duration"]) == ({"nanoseconds_since_epoch": 0}, {"nanoseconds": 0})
    assert (about["files"][0]["starting_time"], about["message_count"]) == ({"nanoseconds_since_epoch": 0}, 0)
    bag.close()
    assert metadata_of(bag) == about


def test_a_file_ends_before_the_message_that_exceeds_its_duration(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", at(5, 14, 15, 20, 24, 25, 26, 60), duration_ns=10 * MS)
    bag.close()
    assert [times_in(file) for file in bag.files] == [[5, 14], [15, 20, 24], [25, 26], [60]]
    assert [file.name for file in bag.files] == [f"bag_{k}.mcap" for k in range(4)]


def test_a_file_ends_once_it_has_its_size(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", at(0, 1, 2), size=1)
    bag.close()
    assert [times_in(file) for file in bag.files] == [[0], [1], [2]]
    size = bag_of(tmp_path / "first", at(0))
    size.flush()
    limit = size.files[0].stat().st_size
    for excess, files in ((0, 2), (1, 1)):
        bag = bag_of(tmp_path / f"bag{excess}", at(0), size=limit + excess)
        bag.flush()
        assert bag.files[0].stat().st_size == limit
        bag.write(at(1))
        assert len(bag.files) == files


def test_a_duration_in_seconds_is_exact_in_nanoseconds() -> None:
    assert SECOND == 10**9
    assert round(1e6 * SECOND) == 10**15


def test_a_file_is_never_left_without_messages(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", at(50), size=1, duration_ns=1)
    assert len(bag.files) == 1


def test_without_limits_there_is_one_file(tmp_path: Path) -> None:
    for bag in (bag_of(tmp_path / "bag"), Bag(tmp_path / "default", opening={}, closing=dict)):
        bag.write(at(0, 10**6, 10**9))
        assert len(bag.files) == 1


def test_messages_are_numbered_per_topic_across_files(tmp_path: Path) -> None:
    messages = [(channel, time * MS, b"") for time in range(4) for channel in (ONE, OTHER)]
    bag = bag_of(tmp_path / "bag", messages, duration_ns=2 * MS)
    bag.close()
    found = [record.sequence for file in bag.files for record in McapRecords(file) if isinstance(record, Message)]
    assert found == [0, 0, 1, 1, 2, 2, 3, 3]


def test_a_closed_bag_ignores_messages(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", at(1))
    assert bag.open
    bag.close()
    assert not bag.open
    before = bag.files[0].read_bytes()
    bag.write(at(2))
    bag.flush()
    bag.close()
    assert bag.files[0].read_bytes() == before
    assert metadata_of(bag)["message_count"] == 1


def test_what_is_flushed_can_be_read_before_the_end(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", at(1))
    assert times_in(bag.files[0]) == []
    bag.flush()
    assert times_in(bag.files[0]) == [1]


def test_missing_parents_of_the_folder_are_created_and_an_existing_folder_is_kept(tmp_path: Path) -> None:
    bag_of(tmp_path / "some" / "where" / "bag").close()
    with pytest.raises(Refusal, match="exists: give another name"):
        bag_of(tmp_path / "some" / "where" / "bag")
    assert (tmp_path / "some" / "where" / "bag" / "bag_0.mcap").exists()


def test_a_folder_that_disappears_ends_the_recording_with_a_reason(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", at(0, 2500), duration_ns=10 * MS)
    shutil.rmtree(bag.path)
    with pytest.raises(RecordingFailed, match=r"bag ended at 2\.5 s: No such file or directory; create its folder or give another folder"):
        bag.write(at(3000))
    assert not bag.open
    bag.write(at(4000))


def test_a_bag_that_is_removed_on_failure_says_so(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", at(0, 2500), duration_ns=10 * MS)
    shutil.rmtree(bag.path)
    removed = r"bag ended at 2\.5 s: No such file or directory; it was removed; create its folder or give another folder"
    with pytest.raises(RecordingFailed, match=removed), bag.removed_on_failure():
        bag.write(at(3000))
    assert not bag.path.exists()


def test_every_file_begins_with_the_last_messages_on_latched_topics(tmp_path: Path) -> None:
    messages = [(LATCHED, 0, b"first"), *at(0, 5), (LATCHED, 6 * MS, b"second"), *at(10, 19), (LATCHED, 20 * MS, b"third"), *at(21, 30)]
    bag = bag_of(tmp_path / "bag", messages, duration_ns=10 * MS)
    bag.close()
    found = [[(m.log_time // MS, m.data, m.sequence) for m in McapRecords(file) if isinstance(m, Message)][:2] for file in bag.files]
    assert found == [
        [(0, b"first", 0), (0, b"data", 0)],
        [(10, b"second", 2), (10, b"data", 2)],
        [(20, b"third", 3), (21, b"data", 4)],  # once, where it is the message that begins the file
        [(30, b"third", 4), (30, b"data", 5)],
    ]
    counts = {entry["topic_metadata"]["name"]: entry["message_count"] for entry in metadata_of(bag)["topics_with_message_count"]}
    assert counts == {LATCHED.name: 5, ONE.name: 6}
    assert [entry["message_count"] for entry in metadata_of(bag)["files"]] == [4, 3, 2, 2]


@pytest.mark.parametrize(
    ("qos", "latched"),
    [
        ("- durability: transient_local", True),
        ("- {durability: volatile}\n- {durability: transient_local}", True),
        ("- durability: volatile", False),
        ("- transient_local", False),
        ("[]", False),
        ("{", False),
    ],
)
def test_a_topic_is_latched_if_a_publisher_offers_it(qos: str, latched: bool) -> None:
    assert Channel("/a", "std_msgs/msg/String", "", qos, "").latched is latched
