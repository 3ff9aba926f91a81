"""The files of a run: its waveform, and its windows, segments of equal length, each with its own label."""

from __future__ import annotations

import io
import itertools
from bisect import bisect_right
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.schema.arrays import Integers, Samples
from dcrb_ros.stream.block import Truth
from dcrb_ros.sweep.sweep_file import Windows

INDEX = "index"
"""Array of a waveform file with the index of each sample, where samples are missing."""
COLUMNS: Mapping[str, str] = {
    "run": "name of the run, as in the labels",
    "case": "name of its case",
    "split": "train, validation or test",
    "start": "index of the first sample since the start of the simulation or the recording",
    "time": "its time [s]",
    "fault": "fault at the first sample",
    "width": "width of the widest defect there [m], 0 without one, NaN if unknown",
    "speed": "speed of the inner ring there [rad/s], NaN if unknown",
    "load": "magnitude of the load there [N], NaN if unknown",
    "mixed": "whether a fault changes within the window",
    "ax": "acceleration in X, a list of samples [m/s^2]",
    "ay": "acceleration in Y, a list of samples [m/s^2]",
}


def window_starts(samples: int, windows: Windows) -> npt.NDArray[np.int64]:
    """Return the first sample of each window that fits into a run of ``samples``, shape (windows,) [-]."""
    return np.arange(0, samples - windows.length + 1, windows.hop, dtype=np.int64)


def cut_windows(acceleration: Samples, windows: Windows) -> Samples:
    """Return the windows of a waveform, shape (windows, 2, length) [m/s^2]."""
    if len(acceleration) < windows.length:
        return np.zeros((0, 2, windows.length), np.float32)
    view = np.lib.stride_tricks.sliding_window_view(acceleration, windows.length, axis=0)
    cut: Samples = np.ascontiguousarray(view[window_starts(len(acceleration), windows)])
    return cut


def window_labels(begin: npt.NDArray[np.int64], first_index: int, rate: int, windows: Windows, truths: list[Truth]) -> dict[str, Any]:
    """Return the label columns of windows that start at the samples ``begin`` of a run.

    A window is labelled with the faults, the speed and the load at its first sample; ``mixed`` is true if the faults change within it.
    """
    times = [truth.time_ns for truth in truths]
    begin_ns = [(first_index + int(sample)) * 1_000_000_000 // rate for sample in begin]
    end_ns = [(first_index + int(sample) + windows.length) * 1_000_000_000 // rate - 1 for sample in begin]
    # The last instant that is not after the time, the first one if there is none.
    first, last = ([max(bisect_right(times, time_ns) - 1, 0) for time_ns in instants] for instants in (begin_ns, end_ns))
    at_first = [truths[number] for number in first]
    # A fault that begins and ends within a window leaves its ends equal.
    changes = [0, *itertools.accumulate(before.faults != after.faults for before, after in itertools.pairwise(truths))]
    # Speed and load change gradually between two instants of the ground truth.
    speed, across, along = (np.interp(begin_ns, times, values) for values in zip(*((t.speed, *t.load) for t in truths), strict=True))
    return {
        "start": begin + first_index,
        "time": (begin + first_index) / rate,
        "fault": np.array([class_of(truth.faults) for truth in at_first], dtype=str),
        "width": np.array([max((fault.get("width", 0.0) for fault in truth.faults.values()), default=0.0) for truth in at_first]),
        "speed": speed,
        "load": np.hypot(across, along),
        "mixed": np.array([changes[begin] != changes[end] for begin, end in zip(first, last, strict=True)], dtype=bool),
    }


def parquet_bytes(table: Any, **options: Any) -> bytes:
    """Return an Arrow table as the bytes of a Parquet file."""
    from pyarrow import parquet

    stream = io.BytesIO()
    parquet.write_table(table, stream, **options)
    return stream.getvalue()


def windows_file(x: Samples, labels: dict[str, Any], about: dict[str, str], kind: str) -> bytes:
    """Return windows and labels as the bytes of a file; ``about`` holds the values common to all windows."""
    if kind == "npz":
        stream = io.BytesIO()
        arrays: dict[str, Any] = {"x": x, **labels, **{name: np.array(value) for name, value in about.items()}}
        np.savez(stream, **arrays)
        return stream.getvalue()
    import pyarrow

    columns = {name: pyarrow.array([value] * len(x), pyarrow.string()) for name, value in about.items()}
    columns |= {name: pyarrow.array(values) for name, values in labels.items()}
    for axis, name in enumerate(("ax", "ay")):
        columns[name] = pyarrow.FixedSizeListArray.from_arrays(pyarrow.array(x[:, axis].ravel()), x.shape[2])
    return parquet_bytes(pyarrow.table(columns), compression="zstd", use_dictionary=list(about))


def waveform_file(
    acceleration: Samples, shaft_angle: Samples, rate: int, first_index: int, kind: str, *, index: Integers | None = None
) -> bytes:
    """Return a waveform as the bytes of a file, npz or Parquet; equal samples give equal bytes.

    Args:
        acceleration: shape (samples, 2) [m/s^2].
        shaft_angle: shape (samples,) [rad].
        rate: sampling rate [Hz].
        first_index: index of the first sample since the start of the simulation or the recording [-].
        kind: ``npz`` or ``parquet``.
        index: index of each sample, shape (samples,), where some are missing; npz only.
    """
    columns: dict[str, Any] = {"ax": acceleration[:, 0], "ay": acceleration[:, 1], "shaft_angle": shaft_angle}
    if kind == "npz":
        columns |= {"sampling_rate": np.array(rate), "first_index": np.array(first_index)} | ({} if index is None else {INDEX: index})
        stream = io.BytesIO()
        np.savez(stream, **columns)
        return stream.getvalue()
    import pyarrow

    table = pyarrow.table({name: np.ascontiguousarray(values) for name, values in columns.items()})
    table = table.replace_schema_metadata({"sampling_rate": str(rate), "first_index": str(first_index)})
    return parquet_bytes(table, compression="zstd", use_dictionary=False)
