"""Components over time as Arrow arrays, sent to Rerun in parts, since sending one large array takes twice as long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from dcrb_ros.viewer.content import Times

TIMELINE = "ros2_timestamp"
"""Simulated time: the name that Rerun's own reader gives to the header stamps of ROS 2 messages."""
MOST_ROWS = 1 << 16
"""Times in one part [-]."""


def time_column(time_ns: Times) -> rr.TimeColumn:
    """Return simulated times [ns] as a column of the timeline."""
    return rr.TimeColumn(TIMELINE, timestamp=time_ns.astype("datetime64[ns]"))


@dataclass(frozen=True)
class Batch:
    """Arrow values with the interface that Rerun expects."""

    values: pa.Array

    def as_arrow_array(self) -> pa.Array:
        """Return the values."""
        return self.values


@dataclass(frozen=True)
class Column:
    """A component over time: its values concatenated, with ``each`` values per time."""

    descriptor: rr.ComponentDescriptor
    values: pa.Array
    each: int = 1

    def piece(self, first: int, last: int) -> rr.ComponentColumn:
        """Return the values of the times ``first`` to ``last`` (exclusive) as a Rerun column."""
        values = self.values[first * self.each : last * self.each]
        borders = np.arange(0, len(values) + 1, self.each, dtype=np.int32)
        return rr.ComponentColumn(self.descriptor, Batch(values), offsets=borders)


def send(path: str, time_ns: Times, *columns: Column) -> None:
    """Send columns of an entity over simulated times [ns]."""
    for first in range(0, len(time_ns), MOST_ROWS):
        last = min(first + MOST_ROWS, len(time_ns))
        rr.send_columns(path, [time_column(time_ns[first:last])], [column.piece(first, last) for column in columns])


def scalars(values: npt.NDArray[np.floating]) -> Column:
    """Return numbers of shape (times, names) as a column."""
    flat = _flat(values, np.float64)
    return Column(rr.Scalars.descriptor_scalars(), pa.array(flat), values.shape[1])


def strips(points: npt.NDArray[np.floating]) -> Column:
    """Return line strips of equal length, shape (times, strips, points, 2), as a column; Rerun's own function loops over them."""
    times, count, length, _ = points.shape
    flat = _flat(points, np.float32)
    kind = rr.components.LineStrip2DBatch([]).as_arrow_array().type
    inner = pa.FixedSizeListArray.from_arrays(pa.array(flat), type=kind.value_type)
    borders = np.arange(0, times * count * length + 1, length, dtype=np.int32)
    return Column(rr.LineStrips2D.descriptor_strips(), pa.ListArray.from_arrays(pa.array(borders), inner, type=kind), count)


def colours(descriptor: rr.ComponentDescriptor, values: npt.NDArray[np.uint8]) -> Column:
    """Return colours of shape (times, instances, 4) as a column of an archetype's colours."""
    packed = np.ascontiguousarray(values).view(">u4").reshape(-1).astype(np.uint32)
    return Column(descriptor, pa.array(packed), values.shape[1])


def vectors(descriptor: rr.ComponentDescriptor, values: npt.NDArray[np.floating]) -> Column:
    """Return positions or vectors of shape (times, instances, 2) as a column."""
    kind = rr.components.Position2DBatch([]).as_arrow_array().type
    flat = _flat(values, np.float32)
    return Column(descriptor, pa.FixedSizeListArray.from_arrays(pa.array(flat), type=kind), values.shape[1])


def _flat(values: npt.NDArray[np.floating], kind: type[np.floating]) -> npt.NDArray[np.floating]:
    """Return numbers as a contiguous, aligned, one-dimensional array, as Arrow requires; arrays read from a message may be unaligned."""
    return np.require(values, kind, ["C", "A"]).reshape(-1)
