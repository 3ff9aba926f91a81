"""Records of arrays: one per table of rollers or contacts, an array per quantity and an element per roller.

A table is a class whose annotations name its arrays (`Lanes`, `Indices`) and the tables inside it:

    class Contact:
        force: Lanes
    class Rollers:
        x: Lanes
        inner: Contact

`empty_record(Rollers)` is a numpy array of one record with these arrays, used as ``rollers = state.rollers[0]`` and then
``rollers.inner.force[k]``. All arrays of a record lie in one block of memory at distances that the compiler knows, so it vectorises loops
over rollers without checking each pair of arrays for overlap; separate arrays in a named tuple would need these checks. An array of one
record is handed to a kernel in a third of the time of the record itself, whose buffer numpy describes field by field at every call. A loop
over rollers runs from 0 and contains no branch but a choice between two values.
"""

from __future__ import annotations

import functools
from typing import Any, Protocol, TypeVar, cast, get_type_hints

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Integers = npt.NDArray[np.int64]

Lanes = npt.NDArray[np.float64]
"""An array of a table, shape (LANES,)."""
Indices = npt.NDArray[np.int64]
"""The same of integers."""

LANES = 136
"""Elements of each array: two rows of 60 rollers, filled up; not a power of two, or all arrays would fall on few cache lines."""
CACHE_LINE = 64
"""[bytes]"""
VECTOR = 4
"""Least number of elements that the processor works on at once; loops run over a multiple of it."""

Table = TypeVar("Table")
Content = TypeVar("Content", covariant=True)


class OneRecord(Protocol[Content]):
    """A numpy array of one record, whose element 0 is a table."""

    def __getitem__(self, index: int, /) -> Content:
        """Return the table, for index 0."""


@functools.cache
def dtype_of(table: type) -> np.dtype[Any]:
    """Return the numpy type of a table; the same object at every call, as numba's dispatch wants it."""
    fields: list[tuple[Any, ...]] = []
    for name, hint in get_type_hints(table).items():
        if hint == Lanes:
            fields.append((name, np.float64, (LANES,)))
        elif hint == Indices:
            fields.append((name, np.int64, (LANES,)))
        else:
            fields.append((name, dtype_of(hint)))
    return np.dtype((np.record, fields))


def empty_record(table: type[Table]) -> OneRecord[Table]:
    """Return a table of zeros, as an array of one record, whose arrays begin at cache lines: loads across lines cost half the speed."""
    dtype = dtype_of(table)  # type: ignore[arg-type] # a class can be hashed
    memory = np.zeros(dtype.itemsize + CACHE_LINE, np.uint8)
    first = -memory.ctypes.data % CACHE_LINE
    return cast(OneRecord[Table], memory[first : first + dtype.itemsize].view(dtype))


def view_of(table: OneRecord[Table], first: str, parts: int, rows: int, rollers: int) -> Floats:
    """Return a view of ``parts`` arrays that follow each other from the one named ``first`` on, shape (rows, rollers, parts)."""
    array = cast("np.ndarray[Any, Any]", table)
    fields: Any = array.dtype.fields
    start = fields[first][1] // (LANES * 8)
    split = array.view(np.float64).reshape(-1, LANES)[start : start + parts, : rows * rollers].reshape(parts, rows, rollers)
    return np.moveaxis(split, 0, -1)
