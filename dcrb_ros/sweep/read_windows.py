"""The windows of a split with their classes, read run by run."""

from __future__ import annotations

import io
import operator
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.runtime.optional import installed
from dcrb_ros.schema.arrays import Samples
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.sweep_file import LONGEST_WINDOW, Windows
from dcrb_ros.sweep.windows import cut_windows, window_starts

USUAL_LENGTH = 4096
KEPT_BYTES = 256 << 20
"""Windows that are kept in memory for the next access [byte]."""


class Source(Protocol):
    """The part of a `DataSet` that windows are read from."""

    folder: Path

    @property
    def classes(self) -> tuple[str, ...]:
        """The fault classes by their numbers."""

    def waveform(self, run: str) -> Waveform:
        """Return the waveform of a run."""

    def files(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """Return the records of the files of a run by their names."""

    def content(self, row: Mapping[str, Any], name: str) -> bytes:
        """Return the contents of a file of a run."""


class ReadWindows(Sequence[tuple[Samples, int]]):
    """The windows of a split, see `DataSet.windows`.

    Item ``k`` is the acceleration of a window, shape (2, length) [m/s^2], with the number of its class in `classes`. A run is read when one
    of its windows is needed, so that a split may be larger than the memory. PyTorch's ``DataLoader`` takes this object as a map-style data
    set, also with several workers.
    """

    def __init__(self, data_set: Source, rows: Sequence[Mapping[str, Any]], length: int | None, hop: int | None) -> None:
        self._data_set, self._rows = data_set, rows
        self.classes = data_set.classes
        """Names of the classes, by their numbers."""
        self._stored = length is None and hop is None and all(row.get("windows") is not None for row in rows)
        kept = next((row for row in rows if row.get("windows")), None)
        if length is None and hop is not None and kept is not None:
            length = self._stored_windows(kept)[0].shape[2]
        self._shape = _shape(length, hop)
        if not self._stored and any(row.get("scenario") for row in rows):
            raise Refusal(
                f"the faults in {data_set.folder} change during a run, so the class of a new window is uncertain: make the data set with "
                "'windows' in its sweep file, and leave out length and hop"
            )
        counts = [int(row["windows"]) if self._stored else len(window_starts(int(row["samples"]), self._shape)) for row in rows]
        self._ends = list(accumulate(counts))
        self._kept: dict[int, tuple[Samples, npt.NDArray[np.int64]]] = {}

    def __repr__(self) -> str:
        return f"<windows: {len(self)} of {len(self._rows)} runs, classes {', '.join(self.classes)}>"

    def __len__(self) -> int:
        return self._ends[-1] if self._ends else 0

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        k = operator.index(index)
        k += len(self) if k < 0 else 0
        if not 0 <= k < len(self):
            raise IndexError(f"window {index} of {len(self)}")
        run = bisect_right(self._ends, k)
        x, y = self._run(run)
        first = k - (self._ends[run - 1] if run else 0)
        return x[first], int(y[first])

    def __iter__(self) -> Iterator[tuple[Samples, int]]:
        for run in range(len(self._rows)):
            x, y = self._run(run)
            yield from zip(x, y.tolist(), strict=True)

    def arrays(self) -> tuple[Samples, npt.NDArray[np.int64]]:
        """Return all windows in memory: shape (windows, 2, length) [m/s^2], and the numbers of their classes, shape (windows,) [-]."""
        if not len(self) and not self._stored:
            longest = max((int(row["samples"]) for row in self._rows), default=0)
            raise Refusal(
                f"the windows of {self._shape.length} samples are longer than every run of this split in {self._data_set.folder}: give a "
                f"length of at most {longest}"
            )
        runs = [self._read(row) for row in self._rows]
        if len({x.shape[2] for x, _ in runs if len(x)}) > 1 or not len(self):
            raise Refusal(f"{self._data_set.folder} has no windows of one length in this split: give the length, in samples")
        parts = [(x, y) for x, y in runs if len(x)]
        return np.concatenate([x for x, _ in parts]), np.concatenate([y for _, y in parts])

    def torch(self) -> Any:
        """Return all windows in memory as a ``torch.utils.data.TensorDataset``.

        Raises
        ------
        Refusal
            PyTorch is not installed.
        """
        torch = installed("torch", "windows as tensors need PyTorch, which is not installed: pip install torch")
        data = installed("torch.utils.data", "windows as tensors need PyTorch, which is not installed: pip install torch")
        x, y = self.arrays()
        return data.TensorDataset(torch.from_numpy(x), torch.from_numpy(y))

    def _run(self, number: int) -> tuple[Samples, npt.NDArray[np.int64]]:
        """Return the windows of a run; the last ones read are kept in memory."""
        if number not in self._kept:
            read = self._read(self._rows[number])
            while self._kept and sum(x.nbytes for x, _ in self._kept.values()) + read[0].nbytes > KEPT_BYTES:
                self._kept.pop(next(iter(self._kept)))
            self._kept[number] = read
        return self._kept[number]

    def _read(self, row: Mapping[str, Any]) -> tuple[Samples, npt.NDArray[np.int64]]:
        x, faults = self._stored_windows(row) if self._stored else self._cut(row)
        unknown = next((name for name in faults if name not in self.classes), None)
        if unknown is not None:
            raise Refusal(
                f"a window of the run {row['run']} has the fault '{unknown}', which no label has: repeat the command that made it"
            )
        return x, np.array([self.classes.index(name) for name in faults], np.int64)

    def _cut(self, row: Mapping[str, Any]) -> tuple[Samples, list[str]]:
        waveform = self._data_set.waveform(str(row["run"]))
        if (np.diff(waveform.index) != 1).any():
            raise Refusal(
                f"samples of the run {row['run']} in {self._data_set.folder} are missing, which new windows would bridge: leave out length "
                "and hop"
            )
        x = cut_windows(waveform.acceleration, self._shape)
        return x, [str(row["fault"])] * len(x)

    def _stored_windows(self, row: Mapping[str, Any]) -> tuple[Samples, list[str]]:
        name = next((name for name in self._data_set.files(row) if name.startswith("windows/")), "")
        data = io.BytesIO(self._data_set.content(row, name))
        if name.endswith(".npz"):
            with np.load(data, allow_pickle=False) as content:
                x, faults = content["x"], content["fault"].tolist()
        else:
            from pyarrow import parquet

            table = parquet.read_table(data, columns=["ax", "ay", "fault"])
            values = [table[key].combine_chunks().flatten().to_numpy() for key in ("ax", "ay")]
            axes = [flat.reshape(len(table), len(flat) // max(1, len(table))) for flat in values]
            x, faults = np.stack(axes, axis=1).astype(np.float32, copy=False), table["fault"].to_pylist()
        if len(x) != row["windows"]:
            raise Refusal(
                f"{self._data_set.folder / name} has {len(x)} windows instead of {row['windows']}: repeat the command that made it"
            )
        return x, [str(fault) for fault in faults]


def _shape(length: int | None, hop: int | None) -> Windows:
    for name, value in (("length", length), ("hop", hop)):
        whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
        if value is not None and not (whole and 1 <= value <= LONGEST_WINDOW):
            raise Refusal(f"{name} = {value!r} is not a number of samples: give a whole number within 1 .. {LONGEST_WINDOW}")
    samples = USUAL_LENGTH if length is None else int(length)
    step = max(1, samples // 2) if hop is None else int(hop)
    if step > samples:
        raise Refusal(f"hop = {step} samples is above length = {samples}: give at most the length, so that no samples are left out")
    return Windows.model_construct(length=samples, overlap=1.0 - step / samples)
