"""Reading the records of an SQLite file of rosbag2: which are yielded, which are reported as damaged."""

from __future__ import annotations

import os
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from mcap.records import Channel, Message, Schema
from ros2_bag_record import WALL_NS, bag_of, messages_of

from dcrb_ros.messages.topics import FEATURES, NAMESPACE, SENSOR
from dcrb_ros.recordings import sqlite_reader
from dcrb_ros.recordings.sqlite_reader import SqliteRecords

TOPICS = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)"
MESSAGES = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)"
ONE_TOPIC = "INSERT INTO topics VALUES (3, '/number', 'std_msgs/msg/Float64', 'cdr')"


def database(path: Path, *statements: str) -> Path:
    with closing(sqlite3.connect(path)) as connection:
        for statement in statements:
            connection.execute(statement)
        connection.commit()
    return path


def read(path: Path, **options: object) -> tuple[list[object], list[str]]:
    records = SqliteRecords(path, **options)  # type: ignore[arg-type]
    return list(records), records.damage


def data_of(records: list[object]) -> list[bytes]:
    return [record.data for record in records if isinstance(record, Message)]


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return bag_of(tmp_path_factory.mktemp("bags") / "bag", messages_of(40), "sqlite3") / "bag.db3"


def test_channels_schemas_and_messages_are_read_in_the_order_of_arrival(file: Path) -> None:
    found, damage = read(file)
    messages = [record for record in found if isinstance(record, Message)]
    assert [(m.log_time, m.publish_time, m.data) for m in messages] == [
        (WALL_NS + 1_000_000 * number, WALL_NS + 1_000_000 * number, message.data) for number, message in enumerate(messages_of(40))
    ]
    channels = {record.id: record for record in found if isinstance(record, Channel)}
    schemas = {record.id: record for record in found if isinstance(record, Schema)}
    first = channels[messages[0].channel_id]
    assert (first.topic, first.message_encoding) == (SENSOR.resolved(NAMESPACE), "cdr")
    assert first.metadata["topic_type_hash"].startswith("RIHS01_")
    schema = schemas[first.schema_id]
    assert (schema.name, schema.encoding) == ("std_msgs/msg/String", "ros2msg")
    assert b"string data" in schema.data
    assert damage == []


def test_only_the_topics_asked_for_are_read(file: Path) -> None:
    found, _ = read(file, topics={FEATURES.resolved(NAMESPACE)})
    assert data_of(found) == [message.data for message in messages_of(40) if message.topic == FEATURES]
    assert read(file, chunks=False) == ([], [])


def test_the_file_is_not_written_and_may_lie_in_a_folder_that_cannot_be(file: Path, tmp_path: Path) -> None:
    folder = tmp_path / "read #only?"
    folder.mkdir()
    copy = folder / "bag.db3"
    copy.write_bytes(file.read_bytes())
    database(copy, "PRAGMA journal_mode = WAL")
    for name in os.listdir(folder):
        (folder / name).chmod(0o444)
    folder.chmod(0o555)
    try:
        before = copy.read_bytes()
        assert len(data_of(read(copy)[0])) == len(messages_of(40))
        assert copy.read_bytes() == before
    finally:
        folder.chmod(0o755)


def test_a_bag_of_an_older_version_without_definitions_is_read(tmp_path: Path) -> None:
    path = database(tmp_path / "old.db3", TOPICS, MESSAGES, ONE_TOPIC, "INSERT INTO messages VALUES (1, 3, 7, x'0001')")
    schema, channel, message = read(path)[0]
    assert (schema.name, schema.data.strip()) == ("std_msgs/msg/Float64", b"float64 data")  # type: ignore[attr-defined]
    assert channel == Channel(3, "/number", "cdr", {"offered_qos_profiles": "[]", "topic_type_hash": ""}, 3)
    assert message == Message(3, 7, b"\0\1", 7, 1)


def test_a_type_that_nobody_defines_gets_an_empty_definition(tmp_path: Path) -> None:
    path = database(tmp_path / "x.db3", TOPICS, MESSAGES, "INSERT INTO topics VALUES (1, '/a', 'private/msg/Type', 'cdr')")
    assert read(path)[0][0] == Schema(1, b"", "ros2msg", "private/msg/Type")


@pytest.mark.parametrize(
    ("statements", "sentence"),
    [
        ((), "x.db3: it has no table 'topics'"),
        ((TOPICS,), "x.db3: it has no table 'messages'"),
        ((TOPICS, "CREATE VIEW messages AS SELECT 1 id, 3 topic_id, 7 timestamp, x'00' data"), "x.db3: it has no table 'messages'"),
        (("CREATE TABLE topics(a)", "CREATE TABLE messages(a)", "INSERT INTO topics VALUES (1)"), "x.db3: the topic None is damaged"),
        ((TOPICS, "CREATE TABLE messages(a)", ONE_TOPIC), "x.db3: the database cannot be read further (no such column: id)"),
    ],
)
def test_another_database_is_damage(statements: tuple[str, ...], sentence: str, tmp_path: Path) -> None:
    found, damage = read(database(tmp_path / "x.db3", "CREATE TABLE other(a)", *statements))
    assert data_of(found) == []
    assert damage[0] == sentence


@pytest.mark.parametrize(
    "values", ["1, 3, 'late', x'00'", "1, 3, 7, 'text'", "1, 3, 7, NULL", "1, 3, -1, x'00'", "1, 3, 7, zeroblob(2000)"]
)
def test_a_damaged_message_leaves_the_others_readable(values: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sqlite_reader, "MAX_RECORD", 1999)
    inserts = (f"INSERT INTO messages VALUES ({values})", "INSERT INTO messages VALUES (2, 3, 8, zeroblob(1999))")
    found, damage = read(database(tmp_path / "x.db3", TOPICS, MESSAGES, ONE_TOPIC, *inserts))
    assert data_of(found) == [bytes(1999)]
    assert damage == ["x.db3: message 1 is damaged, or has more than 1999 bytes"]


@pytest.mark.parametrize("share", [0.9, 0.5, 0.1, 0.001])
def test_the_intact_part_of_a_file_that_is_cut_off_is_read(share: float, file: Path, tmp_path: Path) -> None:
    whole, cut = file.read_bytes(), tmp_path / "cut.db3"
    cut.write_bytes(whole[: int(share * len(whole))])
    found, damage = read(cut)
    expected = [message.data for message in messages_of(40)]
    assert data_of(found) == expected[: len(data_of(found))]
    assert len(data_of(found)) < len(expected)
    assert damage[0].startswith("cut.db3: the database cannot be read further (")


@pytest.mark.parametrize(
    ("topic", "named"),
    [
        ("(3, '/number', 'std_msgs/msg/Float64', 5, '[]', '')", "the topic '/number' is damaged"),
        ("(3, '/number', 'std_msgs/msg/Float64', 'cdr', 5, '')", "the topic '/number' is damaged"),
        ("(3, '/number', 'std_msgs/msg/Float64', 'cdr', '[]', x'00ff')", "the topic '/number' is damaged"),
        ("('a', '/number', 'std_msgs/msg/Float64', 'cdr', '[]', '')", "the topic '/number' is damaged"),
    ],
)
def test_a_topic_with_entries_of_other_types_is_reported(topic: str, named: str, tmp_path: Path) -> None:
    topics = "CREATE TABLE topics(id, name, type, serialization_format, offered_qos_profiles, type_description_hash)"
    path = database(
        tmp_path / "x.db3", topics, MESSAGES, f"INSERT INTO topics VALUES {topic}", "INSERT INTO messages VALUES (1, 3, 5, x'00')"
    )
    found, damage = read(path)
    assert not any(isinstance(record, Channel) for record in found)
    assert damage == [f"x.db3: {named}"]


def test_a_message_whose_number_is_a_text_is_reported(tmp_path: Path) -> None:
    messages = "CREATE TABLE messages(id TEXT, topic_id, timestamp, data)"
    path = database(tmp_path / "x.db3", TOPICS, messages, ONE_TOPIC, "INSERT INTO messages VALUES ('a', 3, 5, x'00')")
    found, damage = read(path)
    assert data_of(found) == []
    assert damage[0].startswith("x.db3: message a is damaged")


def test_a_definition_that_is_not_text_is_replaced_by_the_known_one(tmp_path: Path) -> None:
    definitions = "CREATE TABLE message_definitions(topic_type, encoded_message_definition)"
    wrong = "INSERT INTO message_definitions VALUES ('std_msgs/msg/Float64', 5)"
    path = database(tmp_path / "x.db3", TOPICS, MESSAGES, definitions, wrong, ONE_TOPIC)
    schemas = [record for record in read(path)[0] if isinstance(record, Schema)]
    assert b"float64 data" in schemas[0].data


def test_a_table_with_computed_columns_is_not_read(tmp_path: Path) -> None:
    # A file of some kilobytes would have messages of any size.
    messages = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data GENERATED ALWAYS AS (zeroblob(1000000)) VIRTUAL)"
    row = "INSERT INTO messages(id, topic_id, timestamp) VALUES (1, 3, 5)"
    found, damage = read(database(tmp_path / "x.db3", TOPICS, messages, ONE_TOPIC, row))
    assert found == []
    assert damage == ["x.db3: it has no table 'messages'"]
