"""Reading a data set of `dcrb sweep` or `dcrb collect`: labels, waveforms and windows, each checked against its hash."""

from __future__ import annotations

import hashlib
import io
import json
import os
import warnings
from collections import Counter
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dcrb_ros.bearing.fault_lines import UNKNOWN
from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime.frames import pandas
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.sweep.division import REMEDIES, in_several, warnings_of
from dcrb_ros.sweep.label import DONE
from dcrb_ros.sweep.read_windows import ReadWindows
from dcrb_ros.sweep.schema import SPLITS, healthy_first
from dcrb_ros.sweep.store import Store, local_folder, record_of
from dcrb_ros.sweep.sums import SUMS, read_sums
from dcrb_ros.sweep.table import LABELS
from dcrb_ros.sweep.windows import INDEX
from dcrb_ros.text.files import read_bytes

if TYPE_CHECKING:
    import pandas as pd

NEEDED = ("run", "split", "fault", "status", "file", "files", "sampling_rate", "samples")
"""Columns of the labels without which a data set cannot be read."""
REMEDY = "repeat the command that made the data set"
LARGEST_FILE = 4 << 30
"""Largest file of a run that is read into memory [byte]: a run of 600 s has 0.4 GB."""


class DataSet:
    """A data set of `dcrb sweep` or `dcrb collect` in a folder, whose path may be given as an address ``file://``.

    Every file is compared with its hash before its contents are used. A data set without hashes, or with a bearing or a
    machine in more than one split, is read with a warning.

    Raises
    ------
    Refusal
        The folder is not a data set, or one of its files has been changed.

    Examples
    --------
    >>> import dcrb_ros
    >>> bearings = dcrb_ros.DataSet("bearings")  # doctest: +SKIP
    >>> x, y = bearings.windows("train").arrays()  # doctest: +SKIP
    >>> x.shape, y.shape, bearings.classes  # doctest: +SKIP
    ((600, 2, 4096), (600,), ('healthy', 'cage', 'inner_ring', 'outer_ring', 'roller'))
    """

    def __init__(self, folder: str | Path) -> None:
        if not isinstance(folder, (str, os.PathLike)):
            raise Refusal(f"a {type(folder).__name__} is not the path of a data set: give the folder of dcrb sweep or dcrb collect")
        self.folder = local_folder(folder)
        self._sums = read_sums(Store(str(self.folder))) if self.folder.is_dir() else None
        if not (self.folder / LABELS).is_file():
            raise Refusal(f"{self.folder} has no {LABELS}, so it is not a finished data set: give the folder of dcrb sweep or dcrb collect")
        if self._sums is None:
            _warn(f"{self.folder} has no {SUMS}, without its hashes: changes of its labels are not found")
        self._rows = self._read_rows()
        shared = {name: in_several((row.get(name), row["split"]) for row in self._rows.values()) for name in REMEDIES}
        for sentence in warnings_of(shared, remedy=False).values():
            _warn(f"{self.folder}: {sentence}")

    def __repr__(self) -> str:
        splits = ", ".join(f"{count} {split}" for split, count in self.splits.items())
        return f"<DataSet {self.folder}: {len(self._rows)} runs in {len(self.classes)} classes, {splits}>"

    def __len__(self) -> int:
        return len(self._rows)

    @cached_property
    def splits(self) -> dict[str, int]:
        """Number of runs of each split [-]."""
        counts = Counter(str(row["split"]) for row in self._rows.values())
        return {split: counts[split] for split in SPLITS if counts[split]}

    @cached_property
    def classes(self) -> tuple[str, ...]:
        """The fault classes of the data set, ``healthy`` first: the number of a class is its place here."""
        faults = {str(row["fault"]) for row in self._rows.values()}
        for row in self._rows.values():
            if row.get("window_faults"):
                faults |= set(json.loads(row["window_faults"]))
            elif row.get("scenario"):  # no windows were kept
                faults |= {"healthy", *(class_of([name]) for name in json.loads(row["faults"] or "{}"))}
        return tuple(healthy_first(faults))

    @property
    def runs(self) -> list[str]:
        """Names of the runs that succeeded."""
        return list(self._rows)

    def labels(self, split: str | None = None) -> pd.DataFrame:
        """Return the labels of the runs that succeeded, of one split or of all, as a DataFrame; the data card describes the columns.

        Raises
        ------
        Refusal
            pandas is not installed, or the data set has no such split.
        """
        pandas()  # refuses where it is not installed
        table = self._table(LABELS).to_pandas()
        chosen = table["status"] == DONE
        if split is not None:
            chosen &= table["split"] == self._split(split)
        return table[chosen].reset_index(drop=True)

    def lives(self) -> pd.DataFrame:
        """Return the table of the bearings of a sweep of lives as a DataFrame.

        Raises
        ------
        Refusal
            pandas is not installed, or the data set is not one of lives.
        """
        name = "lives.parquet"
        if not (self.folder / name).is_file():
            raise Refusal(f"{self.folder} has no {name}: only a sweep of kind life has one")
        pandas()  # refuses where it is not installed
        return self._table(name).to_pandas()

    def waveform(self, run: str) -> Waveform:
        """Return the waveform of a run: acceleration [m/s^2], shaft angle [rad], and the orders of its bearing.

        Raises
        ------
        Refusal
            There is no such run, or its file is damaged.
        """
        if not isinstance(run, str) or run not in self._rows:
            raise Refusal(f"{self.folder} has no run '{run}'{nearest(str(run), self._rows)}: its runs are in DataSet.runs")
        row = self._rows[run]
        name = str(row["file"])
        if not name.endswith((".npz", ".parquet")):
            for part, record in self.files(row).items():
                path = self._inside(part)
                if part.startswith(f"{name}/") and (not path.is_file() or record_of(path) != record):
                    raise Refusal(f"{path} is missing or has been changed: {REMEDY}")
            return Recording(self.folder / name).waveform()
        columns = _arrays(self.content(row, name), name)
        values = [np.asarray(columns[key], np.float32) for key in ("ax", "ay", "shaft_angle")]
        index = columns.get(INDEX, np.arange(len(values[0]), dtype=np.int64) + int(row.get("first_index") or 0))
        if {len(value) for value in (*values, index)} != {row["samples"]}:
            raise Refusal(f"{self.folder / name} has {len(values[0])} samples instead of {row['samples']}: {REMEDY}")
        return Waveform(
            acceleration=np.column_stack(values[:2]),
            shaft_angle=values[2],
            sampling_rate=int(row["sampling_rate"]),
            index=np.asarray(index, np.int64),
            orders=_orders(row),
        )

    def windows(self, split: str, length: int | None = None, hop: int | None = None) -> ReadWindows:
        """Return the windows of a split with their classes.

        Parameters
        ----------
        split
            ``train``, ``validation`` or ``test``.
        length
            Samples in a window. By default as in the windows of the data set, or 4096 if it has none.
        hop
            Samples from the start of a window to the start of the next, half the length by default. Without length and hop, the windows
            are those of the data set, if it has some.

        Raises
        ------
        Refusal
            The data set has no such split, or a window has no certain class: a run with a scenario needs ``windows`` in its sweep file.
        """
        rows = [row for row in self._rows.values() if row["split"] == self._split(split)]
        return ReadWindows(self, rows, length, hop)

    def content(self, row: Mapping[str, Any], name: str) -> bytes:
        """Return the contents of a file of a run.

        Raises
        ------
        Refusal
            It is not a file of the data set, it is missing, or it does not have the hash of its label.
        """
        path = self._inside(name)
        stated = self.files(row).get(name) or {}
        if not path.is_file() or path.stat().st_size > LARGEST_FILE:
            raise Refusal(f"{path} is missing or too large: {REMEDY}")
        if hashlib.sha256(data := read_bytes(path, path.stat().st_size)).hexdigest() != stated.get("sha256"):
            raise Refusal(f"{path} has been changed: its SHA-256 is not the one in its label; {REMEDY}")
        return data

    def files(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """Return the records of the files of a run, with size and hash, by their names.

        Raises
        ------
        Refusal
            They are damaged.
        """
        try:
            return {str(name): dict(record) for name, record in json.loads(row["files"]).items()}
        except (ValueError, TypeError, AttributeError):
            raise Refusal(f"{self.folder / LABELS} is damaged: the files of the run {row['run']} are no records; {REMEDY}") from None

    def _inside(self, name: str) -> Path:
        """Return the path of a file of the data set; refuse one outside the folder."""
        parts = name.split("/")
        path = self.folder / name
        if parts[0] not in ("runs", "windows") or {"", ".", ".."} & set(parts) or not path.resolve().is_relative_to(self.folder.resolve()):
            raise Refusal(f"{self.folder / LABELS} names the file {name!r} outside the data set: {REMEDY}")
        return path

    def _table(self, name: str) -> Any:
        """Return a table that `SUMS` lists."""
        import pyarrow
        from pyarrow import parquet

        path = self.folder / name
        data = read_bytes(path, path.stat().st_size)
        if self._sums is not None and hashlib.sha256(data).hexdigest() != self._sums.get(name):
            raise Refusal(f"{path} has been changed: its SHA-256 is not the one in {SUMS}; {REMEDY}")
        try:
            return parquet.read_table(io.BytesIO(data))
        except (pyarrow.ArrowException, OSError) as error:
            raise Refusal(f"{path} is damaged ({str(error).splitlines()[0]}): {REMEDY}") from None

    def _read_rows(self) -> dict[str, dict[str, Any]]:
        """Return the rows of the runs that succeeded, by name, with the columns that are used."""
        path, table = self.folder / LABELS, self._table(LABELS)
        missing = next((name for name in NEEDED if name not in table.schema.names), None)
        if missing:
            raise Refusal(f"{path} has no column {missing}: it is not the table of a data set; {REMEDY}")
        used = (*NEEDED, *REMEDIES, "first_index", "windows", "window_faults", "faults", "scenario", "speed", "ftf", "bpfo", "bpfi", "bsf")
        rows = [row for row in table.select([name for name in used if name in table.schema.names]).to_pylist() if row["status"] == DONE]
        for row in rows:
            if row["split"] not in SPLITS or not (row["samples"] or 0) > 0 or not (row["sampling_rate"] or 0) > 0:
                raise Refusal(f"{path} is damaged: the row of the run {row['run']} has no valid split, samples or rate; {REMEDY}")
            self._inside(str(row["file"]))
        return {str(row["run"]): row for row in rows}

    def _split(self, split: str) -> str:
        if not isinstance(split, str) or split not in self.splits:
            raise Refusal(f"{self.folder} has no split '{split}'{nearest(str(split), self.splits)}: it has {', '.join(self.splits)}")
        return split


def _warn(sentence: str) -> None:
    warnings.warn(sentence, UserWarning, stacklevel=3)


def _arrays(data: bytes, name: str) -> Mapping[str, Any]:
    """Return the arrays of a waveform file."""
    try:
        if name.endswith(".npz"):
            with np.load(io.BytesIO(data), allow_pickle=False) as content:
                return {key: content[key] for key in ("ax", "ay", "shaft_angle", *({INDEX} & set(content.files)))}
        from pyarrow import parquet

        table = parquet.read_table(io.BytesIO(data))
        return {key: table[key].to_numpy() for key in ("ax", "ay", "shaft_angle")}
    except (ValueError, KeyError, OSError, EOFError) as error:
        raise Refusal(f"{name} is not a waveform file ({error}): {REMEDY}") from None


def _orders(row: Mapping[str, Any]) -> Orders:
    """Return the orders of the bearing of a run, unknown at standstill and without lines."""
    shaft = abs(row.get("speed") or 0.0) / (2.0 * np.pi)
    lines = [row.get(name) for name in ("ftf", "bpfo", "bpfi", "bsf")]
    return Orders(*(float(line) / shaft for line in lines if line)) if shaft and all(lines) else UNKNOWN
