"""Records of arrays: one per table of rollers or contacts, an array per quantity and an element per roller.

A table is a class whose annotations name its arrays (`Lanes`, `Indices`) and the tables inside it:

    class Contact:
        force: Lanes
    class Rollers:
        x: Lanes
        inner: Contact

`empty_record(Rollers)` is a numpy array of one record with these arrays, used as ``rollers = state.rollers[0]`` and then
``rollers.inner.force[k]``. All arrays of a record lie in one block of memory at constant distances, so the compiler vectorises loops
over rollers without checking each pair of arrays for overlap; separate arrays in a named tuple would need these checks. An array of one
record is handed to a kernel in a third of the time of the record itself, whose buffer numpy describes field by field at every call. A loop
over rollers runs from 0 and contains no branch but a choice between two values.
"""

from __future__ import annotations

import functools
from typing import Any, Protocol, TypeVar, cast, get_type_hints

import llvmlite.binding
import numba
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Integers = npt.NDArray[np.int64]
SingleFloats = npt.NDArray[np.float32]

Lanes = npt.NDArray[np.float64]
"""An array of a table, shape (LANES,)."""
Indices = npt.NDArray[np.int64]
"""The same of integers."""

LANES = 136
"""Elements of each array: two rows of 60 rollers, filled up; not a power of two, or all arrays would fall on few cache lines."""
CACHE_LINE = 64
"""[bytes]"""
VECTOR = 4
"""Least number of elements that the processor works on at once."""
WIDE_TARGETS = "znver4", "znver5"
"""Targets for which LLVM uses the whole of a vector of 512 bits; for Intel's processors with AVX-512 it prefers 256."""
WIDTH = 2 * VECTOR if (numba.config.CPU_NAME or llvmlite.binding.get_host_cpu_name()) in WIDE_TARGETS else VECTOR  # type: ignore[attr-defined]
"""Elements that compiled loops work on at once. They run over a multiple of it: an element of a remainder takes as long as a vector."""

Table = TypeVar("Table")
Content = TypeVar("Content", covariant=True)


class OneRecord(Protocol[Content]):
    """A numpy array of one record, whose element 0 is a table."""

    def __getitem__(self, index: int, /) -> Content:
        """Return the table, for index 0."""


UNUSED = ("unused", np.float64, (CACHE_LINE // 8,))
"""In place of arrays: one cache line, for another whole array cost 4 % of the time loop."""
ByLaw = tuple[tuple[type, tuple[str, ...]], ...]
"""Tables inside tables whose arrays a law names, with these names."""


@functools.cache
def dtype_of(table: Any, by_law: ByLaw = ()) -> np.dtype[Any]:
    """Return the numpy type of a table; the same object at every call, as numba's dispatch requires.

    A table inside it for which a law names no arrays consists of `UNUSED`.
    """
    fields: list[tuple[Any, ...]] = []
    for name, hint in get_type_hints(table).items():
        if hint == Lanes:
            fields.append((name, np.float64, (LANES,)))
        elif hint == Indices:
            fields.append((name, np.int64, (LANES,)))
        elif hint not in dict(by_law):
            fields.append((name, dtype_of(hint, by_law)))
        else:
            lanes: list[Any] = [(array, np.float64, (LANES,)) for array in dict(by_law)[hint]]
            fields.append((name, np.dtype((np.record, lanes or [UNUSED]))))
    return np.dtype((np.record, fields))


def _aligned(dtype: np.dtype[Any]) -> np.ndarray[Any, Any]:
    """Return an array of one record of zeros that begins at a cache line: loads across lines cost half the speed."""
    memory = np.zeros(dtype.itemsize + CACHE_LINE, np.uint8)
    first = -memory.ctypes.data % CACHE_LINE
    return memory[first : first + dtype.itemsize].view(dtype)


def empty_record(table: type[Table], by_law: ByLaw = ()) -> OneRecord[Table]:
    """Return a table of zeros, as an array of one record."""
    return cast(OneRecord[Table], _aligned(dtype_of(table, by_law)))  # type: ignore[arg-type] # a class can be hashed


def copy_of_record(record: OneRecord[Table]) -> OneRecord[Table]:
    """Return a table with the same values and arrays of its own."""
    array = cast("np.ndarray[Any, Any]", record)
    copy = _aligned(array.dtype)
    copy[...] = array
    return cast(OneRecord[Table], copy)


def view_of(table: OneRecord[Table], first: str, parts: int, rows: int, rollers: int) -> Floats:
    """Return a view of ``parts`` arrays that follow each other from the one named ``first`` on, shape (rows, rollers, parts)."""
    array = cast("np.ndarray[Any, Any]", table)
    fields: Any = array.dtype.fields
    view: Floats = np.ndarray((rows, rollers, parts), np.float64, array.data, fields[first][1], (8 * rollers, 8, 8 * LANES))
    return view
