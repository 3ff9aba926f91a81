"""CSV tables from outside: every column is known, and every row has a value for each."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.text.files import read_text

LARGEST_TABLE = 10_000_000
"""Largest table that is read [bytes]: some 100 000 rows."""


def read_rows(path: Path, needed: Sequence[str], optional: Sequence[str] = ()) -> list[dict[str, str]]:
    """Return the rows of a CSV file with a header; values have no space at their ends.

    Raises:
        Refusal: the file cannot be read, lacks a needed column, has an unknown one or one twice, or a row has more or fewer fields.
    """
    text = read_text(path, LARGEST_TABLE).removeprefix("\ufeff")
    try:
        lines = [line for line in csv.reader(io.StringIO(text, newline=""), strict=True) if line]
    except csv.Error as error:
        raise Refusal(f"{path} cannot be read as CSV: {error}") from None
    columns, known = [name.strip() for name in (lines[0] if lines else ())], (*needed, *optional)
    missing = [name for name in needed if name not in columns]
    unknown = next((name for name in columns if name not in known), None)
    if missing:
        more = f"; unknown is '{unknown}'{nearest(unknown, known)}" if unknown is not None else ""
        raise Refusal(f"{path} lacks the columns {', '.join(missing)}: it needs {', '.join(needed)}{more}")
    if unknown is not None:
        raise Refusal(f"{path} has the unknown column '{unknown}'{nearest(unknown, known)}: known are {', '.join(known)}")
    twice = next((name for name in columns if columns.count(name) > 1), None)
    if twice is not None:
        raise Refusal(f"{path} has the column {twice} twice: remove one")
    for number, line in enumerate(lines[1:], 2):
        if len(line) != len(columns):
            raise Refusal(f"{path}, row {number}: {len(line)} fields, but {len(columns)} columns: quote a value that contains a comma")
    return [{name: value.strip() for name, value in zip(columns, line, strict=True)} for line in lines[1:]]
