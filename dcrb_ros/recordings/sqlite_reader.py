"""Reading the records of an SQLite file, the other storage of rosbag2, in the form of MCAP records."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.parse import quote

from mcap.records import Channel, Message, Schema

from dcrb_ros.messages.cdr import definition_of
from dcrb_ros.recordings.mcap_reader import MAX_RECORD, FileRecords

MAGIC = b"SQLite format 3\x00"
TABLES = ("topics", "messages")
"""Tables that every bag of rosbag2 has."""
DEFINITIONS = "message_definitions"
"""Table that newer bags have in addition."""


class SqliteRecords(FileRecords):
    """Schemas, channels and messages of an SQLite file. Without ``chunks`` there is nothing to read.

    The file is opened for reading only. Log time and publish time of a message are both the time at which it was received.
    """

    def __iter__(self) -> Iterator[Any]:
        self.damage = []
        if not self._chunks:
            return
        try:
            with closing(_connected(self.path)) as connection:
                yield from self._records(connection)
        except sqlite3.Error as error:
            self._report(f"the database cannot be read further ({error})")

    def _records(self, connection: sqlite3.Connection) -> Iterator[Any]:
        tables = list(connection.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table'"))
        plain = {name for name, text in tables if name in (*TABLES, DEFINITIONS) and _is_plain(connection, name, text)}
        missing = [name for name in TABLES if name not in plain]
        if missing:
            self._report(f"it has no table '{missing[0]}'")
            return
        known = _rows(connection, DEFINITIONS, "topic_type", "encoded_message_definition") if DEFINITIONS in plain else ()
        definitions = {kind: text for kind, text in known if isinstance(text, str)}
        wanted = []
        columns = ("id", "name", "type", "serialization_format", "offered_qos_profiles", "type_description_hash")
        for number, topic, kind, encoding, profiles, type_hash in _rows(connection, "topics", *columns):
            texts = (topic, kind, encoding or "", profiles or "", type_hash or "")
            if not (isinstance(number, int) and all(isinstance(text, str) for text in texts)):
                self._report(f"the topic {topic!r} is damaged")
                continue
            if self._topics is None or topic in self._topics:
                wanted.append(number)
            yield Schema(number, (definitions.get(kind) or definition_of(kind)).encode(), "ros2msg", kind)
            about = {"offered_qos_profiles": profiles or "[]", "topic_type_hash": type_hash or ""}
            yield Channel(number, topic, encoding or "cdr", about, number)
        yield from self._messages(connection, wanted)

    def _messages(self, connection: sqlite3.Connection, wanted: list[int]) -> Iterator[Message]:
        marks = ", ".join("?" * len(wanted))
        query = (
            "SELECT id, topic_id, timestamp, CASE WHEN length(data) <= ? THEN data END FROM messages "
            f"WHERE topic_id IN ({marks}) ORDER BY id"
        )
        for number, topic, time_ns, data in connection.execute(query, (MAX_RECORD, *wanted)):
            if isinstance(number, int) and isinstance(time_ns, int) and isinstance(data, bytes) and time_ns >= 0:
                yield Message(topic, time_ns, data, time_ns, number & 0xFFFFFFFF)
            else:
                self._report(f"message {number} is damaged, or has more than {MAX_RECORD} bytes")


def _connected(path: Path) -> sqlite3.Connection:
    """Return a connection that only reads; a file in a folder that cannot be written is taken as it is."""
    address = f"file:{quote(str(path.absolute()))}?mode=ro"
    connection = sqlite3.connect(address, uri=True)
    connection.text_factory = lambda data: data.decode("utf-8", errors="replace")
    try:
        # Nothing that the file itself defines, such as a view, is to run.
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.execute("SELECT name FROM sqlite_master").fetchone()
    except sqlite3.OperationalError:
        connection.close()
        connection = sqlite3.connect(f"{address}&immutable=1", uri=True)
        connection.text_factory = lambda data: data.decode("utf-8", errors="replace")
    return connection


def _is_plain(connection: sqlite3.Connection, name: str, definition: object) -> bool:
    """Return whether a table is stored in the file; a virtual table or a generated column is computed, of any size."""
    computed = any(row[-1] for row in connection.execute(f"PRAGMA table_xinfo({name})"))
    return isinstance(definition, str) and definition.upper().startswith("CREATE TABLE") and not computed


def _rows(connection: sqlite3.Connection, table: str, *columns: str) -> Iterator[Any]:
    """Return some columns of a table; columns that an older version of rosbag2 lacks are empty."""
    present = {row[1] for row in connection.execute(f"PRAGMA table_info({table})")}
    chosen = ", ".join(column if column in present else "NULL" for column in columns)
    return connection.execute(f"SELECT {chosen} FROM {table}") if present else iter(())
