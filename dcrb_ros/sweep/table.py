"""The table of labels: one row per run, in the order of the plan."""

from __future__ import annotations

import io
import itertools
import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from dcrb_ros.schema.verdicts import FAULT_CLASSES
from dcrb_ros.sweep.label import DONE, TEMPERATURES
from dcrb_ros.sweep.plan import Plan, PlannedRun
from dcrb_ros.sweep.store import Store, StoreFailed
from dcrb_ros.sweep.verification import ERRORS, DamagedLabel, label_name, read_label
from dcrb_ros.sweep.windows import parquet_bytes

LABELS = "labels.parquet"
ROWS = 1000
"""Rows kept in memory at once [-]."""
COLUMNS: Mapping[str, tuple[type, str]] = {
    "run": (str, "name of the run, a hash of everything that its samples depend on"),
    "place": (int, "position of the run in the plan, from 0"),
    "twin": (str, "shared by the runs of one condition and seed, which differ in the fault only"),
    "condition": (str, "shared by the runs of one bearing at one speed and load; never in two splits"),
    "split": (str, "train, validation or test"),
    "case": (str, "name of the case in the sweep file"),
    "fault": (str, f"one of {', '.join(FAULT_CLASSES)}"),
    "width": (float, "width of the widest defect [m]; null without one"),
    "depth": (float, "depth of that defect [m]"),
    "reached_depth": (float, "largest depth that loaded rollers reach in that defect: they bridge a narrow one [m]"),
    "share": (float, "share of the rollers' length over which that defect extends [-]"),
    "row": (int, "row of that defect, 0 for all rows"),
    "azimuth": (float, "azimuth of that defect [rad]"),
    "broken_bars": (int, "number of broken cage bars"),
    "onset": (float, "onset of the first fault [s]; sample k of the file is taken at (first_index + k) / sampling_rate"),
    "speed": (float, "speed of the inner ring at the end of the run [rad/s]"),
    "load": (float, "magnitude of the load on the inner ring at the end of the run [N]"),
    **TEMPERATURES,
    "ftf": (float, "fundamental train frequency: rotation of the cage, at that speed [Hz]"),
    "bpfo": (float, "ball pass frequency of the outer ring: rollers passing a point of the outer raceway [Hz]"),
    "bpfi": (float, "ball pass frequency of the inner ring: rollers passing a point of the inner raceway [Hz]"),
    "bsf": (float, "ball spin frequency: spin of a roller relative to its cage [Hz]"),
    "sampling_rate": (int, "samples per second [Hz]"),
    "first_index": (int, "index of the first sample since the start of the simulation"),
    "samples": (int, "samples in the file"),
    "windows": (int, "number of windows of the run"),
    "window_faults": (dict, "faults of its windows, which differ where a fault begins or ends during the run, as JSON"),
    "clipped": (int, "samples clipped at the sensor's range"),
    "seed": (int, "seed of the noise"),
    "scenario": (str, "scenario of the run; empty if there is none"),
    "status": (str, "done; refused (invalid parameters); failed (the model left its domain); error (tried again by the next call)"),
    "reason": (str, "reason why the run is not done; empty if it is"),
    "file": (str, "path of the waveform in the data set"),
    "files": (dict, "all files of the run with their size [byte] and SHA-256, as JSON"),
    "sha256": (str, "hash of ax, ay and shaft_angle of every sample, as little-endian single floats"),
    "faults": (dict, "all faults with their fields, as JSON"),
    "dcrb_ros": (str, "version of dcrb_ros"),
    "model": (str, "fingerprint of the model's source code"),
    "configuration": (dict, "all parameters, as JSON"),
}
"""Columns of the labels: type and meaning; a ``dict`` is written as JSON."""


@dataclass
class Tally:
    """Counts of the runs in a data set."""

    classes: Counter[tuple[str, str]] = field(default_factory=Counter)
    """Finished runs by split and fault; 0 for a fault that only windows have."""
    statuses: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    """Recorded time [s]."""
    units: dict[str, set[str]] = field(default_factory=dict)
    """Units that are divided into splits, by split."""

    def counted(self, label: Mapping[str, Any], unit: str) -> Mapping[str, Any]:
        """Count a run and return its label; ``unit`` is the key with the name of its unit."""
        self.statuses[label["status"]] += 1
        if label["status"] == DONE:
            self.classes[label["split"], label["fault"]] += 1
            self.classes.update({(label["split"], fault): 0 for fault in label.get("window_faults", ())})
            self.units.setdefault(label["split"], set()).add(label[unit])
            self.seconds += label["samples"] / label["sampling_rate"]
        elif label["reason"] in self.reasons or len(self.reasons) < ROWS:
            self.reasons[label["reason"]] += 1
        return label


def write_table(plan: Plan, store: Store) -> Tally:
    """Write the labels of a plan's runs to one table; return their counts.

    Raises:
        StoreFailed: a run has no label, or a damaged one.
    """
    import pyarrow
    from pyarrow import parquet

    columns, tally, stream = plan.sweep.varied, Tally(), io.BytesIO()
    schema = parquet_schema({**COLUMNS, **plan.truth}, columns)
    with parquet.ParquetWriter(stream, schema, compression="zstd") as writer:
        labels = _labels(plan.runs(), store)
        while rows := [
            _row(tally.counted(label, plan.unit_column), plan.truth) | _varied(label, run, columns)
            for run, label in itertools.islice(labels, ROWS)
        ]:
            writer.write_table(pyarrow.Table.from_pylist(rows, schema=schema))
    store.write(LABELS, stream.getvalue())
    return tally


def table_of(labels: Iterable[Mapping[str, Any]], truth: Mapping[str, tuple[type, str]]) -> bytes:
    """Return labels as the bytes of a table with the columns of a sweep's; ``truth`` holds further columns with type and meaning."""
    import pyarrow

    rows = [_row(label, truth) for label in labels]
    return parquet_bytes(pyarrow.Table.from_pylist(rows, schema=parquet_schema({**COLUMNS, **truth})))


def parquet_schema(columns: Mapping[str, tuple[type, str]], plain: Mapping[str, type] | None = None) -> Any:
    """Return the schema of a Parquet file: ``columns`` with type and meaning, and ``plain`` ones with their type only."""
    import pyarrow

    kinds = {float: pyarrow.float64(), int: pyarrow.int64(), bool: pyarrow.bool_(), str: pyarrow.string(), dict: pyarrow.string()}
    fields = [pyarrow.field(name, kinds[kind], metadata={"meaning": meaning}) for name, (kind, meaning) in columns.items()]
    return pyarrow.schema([*fields, *(pyarrow.field(key, kinds[kind]) for key, kind in (plain or {}).items())])


def _labels(runs: Iterator[PlannedRun], store: Store) -> Iterator[tuple[PlannedRun, Mapping[str, Any]]]:
    for run in runs:
        try:
            label = read_label(store, run.name) or read_label(store, run.name, ERRORS)
        except DamagedLabel as damaged:
            raise StoreFailed(f"{damaged}: run the same command again to simulate this run again") from None
        if label is None:
            raise StoreFailed(f"{store.path(label_name(run.name))} is missing: run the same command again to simulate this run again")
        yield run, label


def _row(label: Mapping[str, Any], truth: Iterable[str]) -> dict[str, Any]:
    row = {name: label.get(name) for name in (*COLUMNS, *truth)}
    return row | {name: json.dumps(label[name]) for name, (kind, _) in COLUMNS.items() if kind is dict and name in label}


def _varied(label: Mapping[str, Any], run: PlannedRun, columns: Iterable[str]) -> dict[str, Any]:
    """Return the varied parameters of a run as planned, since its configuration has 0 km/h in place of a speed in km/h."""
    values = {**label["configuration"], **run.changes}
    return {key: values.get(key) for key in columns}
