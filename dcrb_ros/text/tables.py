"""CSV tables from outside: every column is known, and every row has a value for each."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from dcrb_ros.schema.refusal import Refusal, nearest, repeated
from dcrb_ros.text.files import read_text

LARGEST_TABLE = 10_000_000
"""Largest table that is read [bytes]: some 100 000 rows."""
OTHER_SEPARATORS = {";": "semicolons", "\t": "tabs"}
"""Separators that spreadsheets write instead of commas, and their names."""


def read_rows(path: Path, needed: Sequence[str], optional: Sequence[str] = ()) -> list[tuple[int, dict[str, str]]]:
    """Return the rows of a CSV file with a header; values have no space at their ends.

    Each follows the number of its first line in the file, from 1, with blank lines counted.

    Raises:
        Refusal: the file cannot be read, has other separators than commas, lacks a needed column, has an unknown one or one twice, or a row
            has more or fewer fields.
    """
    (_, header), *records = _records(path) or [(1, [])]
    if len(header) == 1 and (other := next((mark for mark in OTHER_SEPARATORS if mark in header[0]), "")):
        raise Refusal(f"{path} separates its columns by {OTHER_SEPARATORS[other]}: save it with commas, and with points in its numbers")
    columns, known = [name.strip() for name in header], (*needed, *optional)
    missing = [name for name in needed if name not in columns]
    unknown = next((name for name in columns if name not in known), None)
    if missing:
        more = f"; unknown is '{unknown}'{nearest(unknown, known)}" if unknown is not None else ""
        raise Refusal(f"{path} lacks the columns {', '.join(missing)}: it needs {', '.join(needed)}{more}")
    if unknown is not None:
        raise Refusal(f"{path} has the unknown column '{unknown}'{nearest(unknown, known)}: known are {', '.join(known)}")
    if (twice := repeated(columns)) is not None:
        raise Refusal(f"{path} has the column {twice} twice: remove one")
    for line, fields in records:
        if len(fields) != len(columns):
            raise Refusal(f"{path}, line {line}: {len(fields)} fields, but {len(columns)} columns: quote a value that contains a comma")
    return [(line, {name: value.strip() for name, value in zip(columns, fields, strict=True)}) for line, fields in records]


def _records(path: Path) -> list[tuple[int, list[str]]]:
    """Return the fields of every line that is not blank, after its number; a value in quotes may continue on further lines."""
    reader = csv.reader(io.StringIO(read_text(path, LARGEST_TABLE).removeprefix("\ufeff"), newline=""), strict=True)
    records, line = [], 1
    try:
        for fields in reader:
            if fields:
                records.append((line, fields))
            line = reader.line_num + 1
    except csv.Error as error:
        raise Refusal(f"{path} cannot be read as CSV: line {line}: {error}") from None
    return records
