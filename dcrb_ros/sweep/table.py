"""The table of labels: a row per run, in the order of the plan."""

from __future__ import annotations

import io
import itertools
import json
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from dcrb_ros.settings.files import fields_by_key
from dcrb_ros.sweep.label import DONE
from dcrb_ros.sweep.plan import Plan, Run
from dcrb_ros.sweep.store import Store
from dcrb_ros.sweep.sweep_file import SCENARIO, Sweep

LABELS = "labels.parquet"
ROWS = 1000
"""Rows that are held in memory at once [-]."""
TEXTS = ("run", "twin", "condition", "split", "case", "status", "reason", "file", "fault", "scenario", "sha256", "dcrb_ros", "model")
WHOLE = ("place", "seed", "row", "broken_bars", "sampling_rate", "first_index", "samples", "clipped", "windows")
DECIMAL = ("width", "depth", "azimuth", "onset", "speed", "load", "ftf", "bpfo", "bpfi", "bsf")
JSONS = ("faults", "configuration")
COLUMNS: Mapping[str, str] = {
    "run": "name of the run, a hash of all that its samples depend on",
    "place": "its place in the plan",
    "twin": "shared by the runs of one condition and seed, which differ in what is wrong only",
    "condition": "shared by the runs of one bearing at one speed and load; never in two splits",
    "split": "train, validation or test",
    "case": "the sweep's name for what is wrong",
    "fault": "healthy, outer_ring, inner_ring, roller, cage, sensor or compound",
    "width": "width of the largest notch [m]; none without",
    "depth": "its depth [m]",
    "row": "its row, 0 for all",
    "azimuth": "its azimuth [rad]",
    "broken_bars": "broken bars of the cages",
    "onset": "since when the first fault is there [s]; sample k of the file is taken at (first_index + k) / sampling_rate",
    "speed": "speed of the inner ring at the end [rad/s]",
    "load": "magnitude of the force on it at the end [N]",
    "ftf": "cage frequency at that speed [Hz]",
    "bpfo": "rollers passing a point of the outer raceway [Hz]",
    "bpfi": "rollers passing a point of the inner raceway [Hz]",
    "bsf": "spin of a roller against its cage [Hz]",
    "sampling_rate": "samples per second [Hz]",
    "first_index": "index of the first sample since the start of the simulation",
    "samples": "samples in the file",
    "windows": "windows cut from it",
    "clipped": "samples beyond the sensor's range",
    "seed": "seed of the noise",
    "scenario": "timeline of the run; empty for none",
    "status": "done; refused (no such bearing can be); failed (the model left its domain); error (tried again by the next call)",
    "reason": "why it is not done",
    "file": "where the waveform lies",
    "sha256": "hash of ax, ay and shaft_angle of every sample, as little-endian single floats",
    "faults": "every fault with its fields, as JSON",
    "dcrb_ros": "version",
    "model": "fingerprint of the model's sources",
    "configuration": "every parameter, as JSON",
}


@dataclass
class Tally:
    """What is in the data set."""

    classes: Counter[tuple[str, str]] = field(default_factory=Counter)
    """Runs that are done by split and fault."""
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
    """Return the parameters that differ between runs, each of which has a column, with their types."""
    keys = {key for axes in (sweep.vary, *sweep.cases.values()) for key in axes if key != SCENARIO}
    return {key: field.kind for key, field in fields_by_key().items() if key in keys}


def write_table(plan: Plan, store: Store) -> Tally:
    """Gather the labels of a plan in one table; return what is in it."""
    import pyarrow
    from pyarrow import parquet

    columns, tally, stream = varied(plan.sweep), Tally(), io.BytesIO()
    schema = _schema(columns)
    with parquet.ParquetWriter(stream, schema, compression="zstd") as writer:
        labels = _labels(plan.runs(), store)
        while rows := [_row(label, columns) for label in map(_counted(tally), itertools.islice(labels, ROWS))]:
            writer.write_table(pyarrow.Table.from_pylist(rows, schema=schema))
    store.write(LABELS, stream.getvalue())
    return tally


def _counted(tally: Tally) -> Any:
    def count(label: Mapping[str, Any]) -> Mapping[str, Any]:
        tally.add(label)
        return label

    return count


def _schema(columns: Mapping[str, type]) -> Any:
    import pyarrow

    kinds = {float: pyarrow.float64(), int: pyarrow.int64(), bool: pyarrow.bool_(), str: pyarrow.string()}
    named = (
        dict.fromkeys((*TEXTS, *JSONS), pyarrow.string())
        | dict.fromkeys(WHOLE, pyarrow.int64())
        | dict.fromkeys(DECIMAL, pyarrow.float64())
    )
    fields = [pyarrow.field(name, named[name], metadata={"meaning": meaning}) for name, meaning in COLUMNS.items()]
    return pyarrow.schema([*fields, *(pyarrow.field(key, kinds[kind]) for key, kind in columns.items())])


def _labels(runs: Iterator[Run], store: Store) -> Iterator[Mapping[str, Any]]:
    for run in runs:
        data = store.read(f"labels/{run.name}.json") or store.read(f"errors/{run.name}.json")
        if data is not None:
            yield json.loads(data)


def _row(label: Mapping[str, Any], columns: Mapping[str, type]) -> dict[str, Any]:
    row = {name: label.get(name) for name in COLUMNS}
    row |= {name: json.dumps(label[name]) for name in JSONS if name in label}
    return row | {key: label["configuration"][key] for key in columns}
