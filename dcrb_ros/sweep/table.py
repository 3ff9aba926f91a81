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
from dcrb_ros.settings.files import fields_by_key
from dcrb_ros.sweep.label import DONE
from dcrb_ros.sweep.plan import Plan, PlannedRun
from dcrb_ros.sweep.store import Store, StoreFailed
from dcrb_ros.sweep.sweep_file import SCENARIO, Sweep
from dcrb_ros.sweep.temperatures import TEMPERATURES
from dcrb_ros.sweep.verification import ERRORS, DamagedLabel, label_name, read_label

LABELS = "labels.parquet"
ROWS = 1000
"""Rows kept in memory at once [-]."""
TEXTS = ("run", "twin", "condition", "split", "case", "status", "reason", "file", "fault", "scenario", "sha256", "dcrb_ros", "model")
WHOLE = ("place", "seed", "row", "broken_bars", "sampling_rate", "first_index", "samples", "clipped", "windows")
DECIMAL = ("width", "depth", "azimuth", "onset", "speed", "load", *TEMPERATURES, "ftf", "bpfo", "bpfi", "bsf")
JSONS = ("faults", "files", "configuration")
COLUMNS: Mapping[str, str] = {
    "run": "name of the run, a hash of everything that its samples depend on",
    "place": "position of the run in the plan, from 0",
    "twin": "shared by the runs of one condition and seed, which differ in the fault only",
    "condition": "shared by the runs of one bearing at one speed and load; never in two splits",
    "split": "train, validation or test",
    "case": "name of the case in the sweep file",
    "fault": f"one of {', '.join(FAULT_CLASSES)}",
    "width": "width of the widest defect [m]; null without one",
    "depth": "depth of that defect [m]",
    "row": "row of that defect, 0 for all rows",
    "azimuth": "azimuth of that defect [rad]",
    "broken_bars": "number of broken cage bars",
    "onset": "onset of the first fault [s]; sample k of the file is taken at (first_index + k) / sampling_rate",
    "speed": "speed of the inner ring at the end of the run [rad/s]",
    "load": "magnitude of the load on the inner ring at the end of the run [N]",
    **TEMPERATURES,
    "ftf": "fundamental train frequency: rotation of the cage, at that speed [Hz]",
    "bpfo": "ball pass frequency of the outer ring: rollers passing a point of the outer raceway [Hz]",
    "bpfi": "ball pass frequency of the inner ring: rollers passing a point of the inner raceway [Hz]",
    "bsf": "ball spin frequency: spin of a roller relative to its cage [Hz]",
    "sampling_rate": "samples per second [Hz]",
    "first_index": "index of the first sample since the start of the simulation",
    "samples": "samples in the file",
    "windows": "number of windows of the run",
    "clipped": "samples clipped at the sensor's range",
    "seed": "seed of the noise",
    "scenario": "scenario of the run; empty if there is none",
    "status": "done; refused (invalid parameters); failed (the model left its domain); error (tried again by the next call)",
    "reason": "reason why the run is not done; empty if it is",
    "file": "path of the waveform in the data set",
    "files": "all files of the run with their size [byte] and SHA-256, as JSON",
    "sha256": "hash of ax, ay and shaft_angle of every sample, as little-endian single floats",
    "faults": "all faults with their fields, as JSON",
    "dcrb_ros": "version of dcrb_ros",
    "model": "fingerprint of the model's source code",
    "configuration": "all parameters, as JSON",
}


@dataclass
class Tally:
    """Counts of the runs in a data set."""

    classes: Counter[tuple[str, str]] = field(default_factory=Counter)
    """Finished runs by split and fault."""
    statuses: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    """Recorded time [s]."""
    conditions: dict[str, set[str]] = field(default_factory=dict)
    """Conditions by split."""

    def add(self, label: Mapping[str, Any]) -> None:
        """Count a run."""
        self.statuses[label["status"]] += 1
        if label["status"] == DONE:
            self.classes[label["split"], label["fault"]] += 1
            self.conditions.setdefault(label["split"], set()).add(label["condition"])
            self.seconds += label["samples"] / label["sampling_rate"]
        elif label["reason"] in self.reasons or len(self.reasons) < ROWS:
            self.reasons[label["reason"]] += 1


def varied(sweep: Sweep) -> dict[str, type]:
    """Return the varied parameters, each of which has a column, with their types."""
    keys = {key for axes in (sweep.vary, *sweep.cases.values()) for key in axes if key != SCENARIO}
    return {key: field.kind for key, field in fields_by_key().items() if key in keys}


def write_table(plan: Plan, store: Store) -> Tally:
    """Write the labels of a plan's runs to one table; return their counts.

    Raises:
        StoreFailed: a run has no label, or a damaged one.
    """
    import pyarrow
    from pyarrow import parquet

    columns, tally, stream = varied(plan.sweep), Tally(), io.BytesIO()
    schema = _schema(columns, plan.truth)
    with parquet.ParquetWriter(stream, schema, compression="zstd") as writer:
        labels = _labels(plan.runs(), store)
        while rows := [_row(label, columns, plan.truth) for label in map(_counted(tally), itertools.islice(labels, ROWS))]:
            writer.write_table(pyarrow.Table.from_pylist(rows, schema=schema))
    store.write(LABELS, stream.getvalue())
    return tally


def table_of(labels: Iterable[Mapping[str, Any]], truth: Mapping[str, tuple[type, str]]) -> bytes:
    """Return labels as the bytes of a table with the columns of a sweep's; ``truth`` holds further columns with type and meaning."""
    import pyarrow
    from pyarrow import parquet

    stream = io.BytesIO()
    parquet.write_table(pyarrow.Table.from_pylist([_row(label, {}, truth) for label in labels], schema=_schema({}, truth)), stream)
    return stream.getvalue()


def _counted(tally: Tally) -> Any:
    def count(label: Mapping[str, Any]) -> Mapping[str, Any]:
        tally.add(label)
        return label

    return count


def _schema(columns: Mapping[str, type], truth: Mapping[str, tuple[type, str]]) -> Any:
    import pyarrow

    kinds = {float: pyarrow.float64(), int: pyarrow.int64(), bool: pyarrow.bool_(), str: pyarrow.string()}
    named = (
        dict.fromkeys((*TEXTS, *JSONS), pyarrow.string())
        | dict.fromkeys(WHOLE, pyarrow.int64())
        | dict.fromkeys(DECIMAL, pyarrow.float64())
    )
    fields = [pyarrow.field(name, named[name], metadata={"meaning": meaning}) for name, meaning in COLUMNS.items()]
    fields += [pyarrow.field(name, kinds[kind], metadata={"meaning": meaning}) for name, (kind, meaning) in truth.items()]
    return pyarrow.schema([*fields, *(pyarrow.field(key, kinds[kind]) for key, kind in columns.items())])


def _labels(runs: Iterator[PlannedRun], store: Store) -> Iterator[Mapping[str, Any]]:
    for run in runs:
        try:
            label = read_label(store, run.name) or read_label(store, run.name, ERRORS)
        except DamagedLabel as damaged:
            raise StoreFailed(f"{damaged}: run the same command again to simulate this run again") from None
        if label is None:
            raise StoreFailed(f"{store.path(label_name(run.name))} is missing: run the same command again to simulate this run again")
        yield label


def _row(label: Mapping[str, Any], columns: Mapping[str, type], truth: Iterable[str]) -> dict[str, Any]:
    row = {name: label.get(name) for name in (*COLUMNS, *truth)}
    row |= {name: json.dumps(label[name]) for name in JSONS if name in label}
    return row | {key: label["configuration"][key] for key in columns}
