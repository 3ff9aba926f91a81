"""Tables of numbers in text files, with a line per sample and a column per channel."""

from __future__ import annotations

import csv
import itertools
import re
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted

Array = npt.NDArray[Any]
LONGEST_LINE = 100_000
"""Longest line of a CSV file that is read for the names of the columns [characters]."""
TWO_INTEGERS = re.compile(r"[-+]?[0-9]+,[0-9]+([eE][-+]?[0-9]+)?")
"""A line that is two integers, or a number with a decimal comma."""
NOT_A_NUMBER = re.compile(r"could not convert string (.*) to \w+ at row \d+, column (\d+)", re.DOTALL)
COLUMNS_CHANGED = re.compile(r"the number of columns changed from \d+ to \d+")
"""Errors of `numpy.loadtxt`, which counts rows instead of lines."""
COMPARED_LINES = 100
"""Last lines in which the number of decimals is compared."""
LONGEST_SHOWN = 40
"""Longest text of a file in an error message [characters]."""
UNKNOWN = ("na", "n/a", "null", "none", "-", "?")
"""Words for an unknown value, of which none is the name of a column."""


def read_table(path: Path) -> tuple[tuple[str, ...], Callable[[str | int], Array]]:
    """Return the names of the columns of a CSV file, and a function that returns a column by its name or its number.

    Raises:
        Refusal: it contains no numbers, decimal commas, or characters that are not UTF-8.
    """
    try:
        return _read(path)
    except UnicodeDecodeError:
        raise Refusal(f"{path} contains characters that are not UTF-8: save it as UTF-8") from None


def _read(path: Path) -> tuple[tuple[str, ...], Callable[[str | int], Array]]:
    with path.open(encoding="utf-8-sig") as stream:
        first = next((line for line in iter(lambda: stream.readline(LONGEST_LINE), "") if line.strip() and not line.startswith("#")), "")
    if len(first) == LONGEST_LINE:
        raise Refusal(f"{path} has a line of {LONGEST_LINE} characters or more: give a file with one column per channel")
    delimiter = next((character for character in ";\t," if character in first), None)
    names = _fields(first, delimiter)
    # An index before numbered columns has no name.
    headed = any(name and not _is_number(name) for name in names) or (names[:1] == ("",) and _counted(names[1:]))
    if len(names) > 1 and _counted(names):
        raise Refusal(
            f"{path} begins with {first.strip()[:LONGEST_SHOWN]!r}, which may be samples or numbers of the columns: write the names of the "
            "columns in the first line"
        )
    # Columns of numbers may have names of a library's own behind an index with a name: time,0,1.
    numbered = names[0].lower() not in UNKNOWN and not _is_number(names[0]) and _counted(names[1:])
    unknown = all(name.lower() in UNKNOWN for name in names)
    if unknown or (not numbered and any(name and not _is_number(name) for name in names) and any(map(_is_number, names))):
        raise Refusal(
            f"{path} begins with {first.strip()[:LONGEST_SHOWN]!r}, which has numbers or unknown values beside words: write the names of "
            "the columns in the first line, none of them a number, nan for an unknown value, and a # before other lines above them"
        )
    number, latest = 0, deque[str](maxlen=COMPARED_LINES)

    def filled(stream: Iterator[str]) -> Iterator[str]:
        nonlocal number
        for number, line in enumerate(stream, 1):  # noqa: B007
            if line.strip():
                latest.append(line)
                yield line

    with path.open(encoding="utf-8-sig") as stream:
        lines = itertools.dropwhile(lambda line: line.startswith("#"), filled(stream))
        if headed:
            next(lines, None)
        begin = next(lines, None)
        if begin is None:
            raise Refusal(f"{path} contains no numbers: give a file with one column per channel")
        if (delimiter != "," and "," in begin) or (not headed and TWO_INTEGERS.fullmatch(begin.strip())):
            raise Refusal(
                f"{path} may have decimal commas ({begin.strip()[:LONGEST_SHOWN]!r}): write decimal points, the names in the first line, "
                "and a # before other lines above them"
            )
        try:
            table = np.loadtxt(itertools.chain([begin], lines), delimiter=delimiter, ndmin=2, comments=None)
        except ValueError as error:
            raise Refusal(f"{path} cannot be read as CSV: line {number}{_mistake_in_table(str(error))}") from None
    if _is_cut_off(latest):
        raise Refusal(
            f"{path} may be cut off: it ends with {latest[-1][-LONGEST_SHOWN:]!r}, without a line end, and its last number has fewer "
            "decimals than those before: copy it again, or end or delete the last line"
        )

    def column(name: str | int) -> Array:
        if not isinstance(name, str) or not headed:
            return numbered_column(table, name)
        if len(names) != table.shape[1]:
            raise Refusal(
                f"{path} has {len(names)} names in its first line, but {counted(table.shape[1], 'column')}: give each one a name, or the "
                "numbers of the channels"
            )
        if names.count(name) > 1:
            raise Refusal(f"{path} has {names.count(name)} columns called '{name}': give the number of the channel, from 1")
        return np.asarray(table[:, names.index(name)])

    return names if headed else tuple(str(k + 1) for k in range(table.shape[1])), column


def _is_cut_off(lines: Sequence[str]) -> bool:
    """Return whether the last line has no end, and its last number fewer characters after the point than those of all lines before."""
    *before, last = (line.rpartition(".")[2] if "." in line else "" for line in lines)
    return len(before) == COMPARED_LINES - 1 and not last.endswith("\n") and len(last) < min(len(text.rstrip()) for text in before)


def _fields(line: str, delimiter: str | None) -> tuple[str, ...]:
    """Return the words of a line of a table; a delimiter in quotes belongs to its word."""
    if delimiter is None:
        return tuple(word.strip('"') for word in line.split())
    return tuple(word.strip() for word in next(csv.reader([line.strip()], delimiter=delimiter, skipinitialspace=True)))


def _mistake_in_table(error: str) -> str:
    """Return what is wrong in a line of a table, from an error of `numpy.loadtxt`."""
    if (found := NOT_A_NUMBER.search(error)) is not None:
        text = f"{found[1][:LONGEST_SHOWN]} is not a number" if found[1] != "''" else "the field is empty"
        return f", column {found[2]}: {text}: write plain numbers, and nan for an unknown one"
    if (found := COLUMNS_CHANGED.search(error)) is not None:
        return f": {found[0]}; a file that was cut off lacks columns in its last line: copy it again, or delete the line"
    return f": {error}"


def _counted(words: tuple[str, ...]) -> bool:
    """Return whether words are 0, 1, 2 and so on, or 1, 2, 3 and so on."""
    return words in [tuple(str(first + k) for k in range(len(words))) for first in (0, 1)]


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def numbered_column(table: Array, name: str | int) -> Array:
    """Return a column by its number, counted from 1."""
    number = int(name)
    if not 1 <= number <= table.shape[1]:
        raise IndexError(name)
    return np.asarray(table[:, number - 1])
