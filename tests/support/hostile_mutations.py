"""Hostile inputs at random: sound files of every kind that a command reads, each changed in one place, and command lines.

A change is drawn from a seed and a number, so that a failed case can be made again. Some changes must not pass: an unknown key, a value
of another kind, a damaged digest. Others may, such as a number that stays in its range.
"""

from __future__ import annotations

import copy
import csv
import io
import json
import math
import random
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, NamedTuple

import yaml

UNKNOWN = "zz_unknown"
"""A key and a column that nothing reads."""
NAMES = ("cases", "software", "shards")
"""Groups whose keys are names that the author of a file chooses."""
NUMBERS = (
    *(0, -1, 1, 2, 3, 7, 10**9, 2**31, 2**63, 2**64, 10**40, -(10**12)),
    *(0.0, -0.0, 1e-300, 5e-324, 1e-9, -1e-9, 0.5, 1.5, 1e9, -1e9, 1e300, -1e308, math.inf, -math.inf, math.nan),
)
TEXTS = (
    *("", " ", "x", "abc", "None", "null", "true", "1", "1e5", "1:30", "-5", "0x10", "nan", "inf"),
    *(
        "a" * 300,
        "a/b",
        "../../etc/passwd",
        "/etc/passwd",
        "/dev/zero",
        "~",
        "*",
        "%s%n",
        "{}",
        "[red]",
        "\x1b[2J",
        "\x00",
        "\u202e",
        "\ud800",
    ),
    *("healthy", "outer_ring", "bogie", "smoke", "operating.speed=1", "-", "--help", "é" * 10, "😀", "1,5", "1;2", "a\nb", "'", '"', "#"),
)
OTHERS: tuple[Any, ...] = (True, False, None, [], {}, [1], [[]], [1, "a"], {"a": 1}, {"": ""}, [None] * 5, [0.0] * 300)


class Change(NamedTuple):
    """A changed text or file."""

    content: bytes
    words: str
    """What was done, for the message of a failed test."""
    must_fail: bool = False
    """Whether a command must not accept it without a word."""


@dataclass(frozen=True)
class Target:
    """A kind of input: a sound file and the commands that read it."""

    content: bytes
    change: Callable[[random.Random, bytes], Change]
    commands: tuple[tuple[str, ...], ...]
    suffix: str


def _places(tree: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every value below a tree."""
    inside: Any = tree.items() if isinstance(tree, Mapping) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in inside:
        yield (*path, key)
        yield from _places(value, (*path, key))


def _at(tree: Any, path: Sequence[Any]) -> Any:
    for key in path:
        tree = tree[key]
    return tree


def hostile_value(draw: random.Random) -> Any:
    """Return any value."""
    return copy.deepcopy(draw.choice((draw.choice(NUMBERS), draw.choice(NUMBERS), draw.choice(TEXTS), draw.choice(OTHERS))))


def changed_tree(draw: random.Random, tree: Any, free: frozenset[str] = frozenset()) -> tuple[Any, str, bool]:
    """Return a tree with one change, what it is, and whether it must not pass; groups in ``free`` may have any keys."""
    tree = copy.deepcopy(tree)
    places = list(_places(tree))
    if not places:
        return hostile_value(draw), "another document", False
    path = draw.choice(places)
    parent, key, old = _at(tree, path[:-1]), path[-1], _at(tree, path)
    shown = ".".join(str(part) for part in path)
    open_place = any(str(part) in free for part in path[:-1]) or (len(path) > 1 and path[-2] in NAMES)
    match draw.randrange(7):
        case 0:
            groups = [(), *(place for place in places if isinstance(_at(tree, place), Mapping))]
            place = draw.choice([place for place in groups if isinstance(_at(tree, place), Mapping)] or [None])
            if place is None:
                return hostile_value(draw), "another document", False
            _at(tree, place)[UNKNOWN] = hostile_value(draw)
            return tree, f"unknown key in {'.'.join(map(str, place)) or 'the document'}", not any(str(part) in free for part in place)
        case 1 if isinstance(parent, dict):
            parent[f"{key}x"] = parent.pop(key)
            return tree, f"{shown} renamed to {key}x", not open_place
        case 2:
            del parent[key]
            return tree, f"{shown} removed", False
        case 3:
            parent[key] = {UNKNOWN: 1} if not isinstance(old, Mapping) else 7
            return tree, f"{shown} of another kind", not open_place and old is not None and not isinstance(old, Mapping)
        case 4 if isinstance(old, list) and old:
            parent[key] = old * draw.choice((2, 40))
            return tree, f"{shown} repeated", False
        case 5:
            other = copy.deepcopy(_at(tree, draw.choice(places)))
            parent[key] = other
            return tree, f"{shown} = {str(other)[:60]}", False
        case _:
            value = hostile_value(draw)
            parent[key] = value
            return tree, f"{shown} = {str(value)[:60]!r}", False


def changed_bytes(draw: random.Random, content: bytes) -> Change:
    """Return bytes with one change: cut, flipped, overwritten, doubled, moved."""
    size = len(content)
    at, length = draw.randrange(max(size, 1)), draw.choice((1, 2, 8, 64, 4096))
    part = content[at : at + length]
    match draw.randrange(8):
        case 0:
            return Change(content[:at], f"cut at {at}")
        case 1:
            flipped = bytes([content[at] ^ (1 << draw.randrange(8))]) if size else b"x"
            return Change(content[:at] + flipped + content[at + 1 :], f"bit flipped at {at}")
        case 2:
            return Change(content[:at] + bytes(len(part)) + content[at + length :], f"{length} zeros at {at}")
        case 3:
            return Change(content[:at] + b"\xff" * len(part) + content[at + length :], f"{length} ones at {at}")
        case 4:
            return Change(content[:at] + content[at + length :], f"{length} bytes removed at {at}")
        case 5:
            return Change(content[:at] + part * 3 + content[at + length :], f"{length} bytes repeated at {at}")
        case 6:
            other = draw.randrange(max(size, 1))
            return Change(content[:at] + content[other : other + length] + content[at + length :], f"{length} bytes from {other} at {at}")
        case _:
            return Change(content[:at] + draw.randbytes(length) + content[at + length :], f"{length} random bytes at {at}")


def changed_yaml(free: frozenset[str] = frozenset()) -> Callable[[random.Random, bytes], Change]:
    """Return a change of YAML: mostly of its tree, sometimes of its bytes."""

    def change(draw: random.Random, content: bytes) -> Change:
        if draw.random() < 0.15:
            return changed_bytes(draw, content)
        tree, words, must_fail = changed_tree(draw, yaml.safe_load(content), free)
        return Change(yaml.safe_dump(tree, sort_keys=False, allow_unicode=True).encode("utf-8", "surrogatepass"), words, must_fail)

    return change


def changed_json(free: frozenset[str] = frozenset(), sign: Callable[[Any], Any] | None = None) -> Callable[[random.Random, bytes], Change]:
    """Return a change of JSON; ``sign`` gives a changed tree a valid digest, in half of the cases."""

    def change(draw: random.Random, content: bytes) -> Change:
        if draw.random() < 0.15:
            return changed_bytes(draw, content)
        tree, words, must_fail = changed_tree(draw, json.loads(content), free)
        if sign is not None and isinstance(tree, dict) and draw.random() < 0.5:
            try:
                tree, words, must_fail = sign(tree), f"{words}, with a new digest", False
            except (TypeError, ValueError, UnicodeError):
                must_fail = False
        return Change(json.dumps(tree).encode("utf-8", "surrogatepass"), words, must_fail)

    return change


def changed_table(draw: random.Random, content: bytes) -> Change:
    """Return a CSV table with one change."""
    if draw.random() < 0.15:
        return changed_bytes(draw, content)
    rows = list(csv.reader(io.StringIO(content.decode())))
    row, column = draw.randrange(1, len(rows)), draw.randrange(len(rows[0]))
    must_fail, name = False, rows[0][column]
    match draw.randrange(9):
        case 0:
            rows[0].append(UNKNOWN)
            for one in rows[1:]:
                one.append(str(hostile_value(draw))[:400])
            words, must_fail = "unknown column", True
        case 1:
            rows[0][column] = f"{name}x"
            words, must_fail = f"column {name} renamed", True
        case 2:
            for one in rows:
                del one[column]
            words = f"column {name} removed"
        case 3:
            rows[0][draw.randrange(len(rows[0]))] = name
            words, must_fail = f"column {name} twice", rows[0].count(name) > 1
        case 4:
            rows.append(list(rows[row]))
            words, must_fail = f"row {row} twice", True
        case 5:
            rows[row].append("more")
            words, must_fail = f"row {row} has another field", True
        case 6:
            del rows[row][column]
            words = f"row {row} lacks a field"
        case _:
            value = str(hostile_value(draw))[:400]
            rows[row][column] = value
            words = f"{name} of row {row} = {value[:60]!r}"
    text = io.StringIO()
    csv.writer(text).writerows(rows)
    return Change(text.getvalue().encode("utf-8", "surrogatepass"), words, must_fail)


def command_line(draw: random.Random, options: Mapping[str, Sequence[str]], files: Sequence[str]) -> list[str]:
    """Return a command line with options of a command and of none, and with any values."""
    command = draw.choice(list(options))
    words = command.split()
    for _ in range(draw.randrange(4)):
        if draw.random() < 0.7 and options[command]:
            words.append(draw.choice(options[command]))
        if draw.random() < 0.8:
            value = hostile_value(draw)
            words.append(draw.choice((str(value), draw.choice(TEXTS), draw.choice(files), f"{draw.choice(TEXTS)}={value}")))
    return [word.replace("\0", "\\0").encode("utf-8", "replace").decode()[:1000] for word in words]


def changed_database(draw: random.Random, content: bytes) -> Change:
    """Return an SQLite file with other bytes, or with another value in one of its rows."""
    if draw.random() < 0.5:
        return changed_bytes(draw, content)
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
        connection.deserialize(content)
        table = draw.choice([name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")])
        column = draw.choice([row[1] for row in connection.execute(f"PRAGMA table_info({table})")])
        rows = [row for (row,) in connection.execute(f"SELECT rowid FROM {table}")]
        value = draw.choice((draw.choice(TEXTS), draw.choice(NUMBERS), draw.randbytes(50), None))
        stored = (
            str(value).encode("utf-8", "replace") if isinstance(value, str) or (isinstance(value, int) and abs(value) >= 2**63) else value
        )
        words = f"{column} of a row of {table} = {str(value)[:60]!r}"
        try:
            connection.execute(f"UPDATE {table} SET {column} = ? WHERE rowid = ?", (stored, draw.choice(rows)))
        except sqlite3.Error as error:  # such as a second row with the same key
            words = f"no change: {error}"
        return Change(connection.serialize(), words)


class CatalogueLine(NamedTuple):
    """A call of `dcrb config new`."""

    words: tuple[str, ...]
    asked: dict[str, float]
    """Parameters that the configuration must have."""


def catalogue_line(draw: random.Random) -> CatalogueLine:
    """Return a call with the data of a possible bearing, of which up to two are replaced by any value."""
    diameter, rollers = draw.uniform(3.0, 60.0), draw.randrange(6, 40)
    inner = diameter * rollers * draw.uniform(0.31, 0.45) - diameter
    given: dict[str, Any] = {
        "-F": inner,
        "-Z": rollers,
        "--roller-diameter": diameter,
        "--roller-length": diameter * draw.uniform(0.7, 3.0),
        "--rpm": draw.uniform(-3000.0, 3000.0),
    }
    others = {
        "-E": inner + 2.0 * diameter,
        "--rows": draw.choice((1, 2)),
        "-d": inner - diameter * draw.uniform(0.3, 1.0),
        "-D": inner + diameter * draw.uniform(2.3, 3.0),
        "-B": diameter * draw.uniform(1.0, 6.0),
        "--clearance": draw.uniform(0.0, 200.0),
        "--load": draw.uniform(0.0, 1e5),
        "--contact-angle": draw.uniform(0.0, 30.0),
    }
    given |= {option: value for option, value in others.items() if draw.random() < 0.3}
    for option in draw.sample(list(given), draw.choice((0, 0, 1, 1, 2))):
        factor = draw.choice((-1.0, 0.0, 1e-3, 0.1, 10.0, 1e3))
        given[option] = draw.choice((factor * float(given[option]), draw.choice(NUMBERS), hostile_value(draw)))
    words = [str(word).replace("\0", "\\0").encode("utf-8", "replace").decode() for pair in given.items() for word in pair]
    keys = {"-Z": ("bearing.rollers_per_row", 1.0), "-F": ("bearing.inner_raceway_radius", 5e-4), "--load": ("operating.load", 1.0)}
    keys |= {"--rpm": ("operating.speed", math.pi / 30.0), "--roller-length": ("bearing.roller_length", 1e-3)}
    numbers = {option: value for option, value in given.items() if isinstance(value, int | float)}
    return CatalogueLine(
        ("config", "new", *words), {key: factor * numbers[option] for option, (key, factor) in keys.items() if option in numbers}
    )
