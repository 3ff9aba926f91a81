"""The rigs of the experiment: measured windows, and sweeps that simulate their bearings."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy import signal

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.diagnosis.features.extraction import FeatureTable, extract_features
from dcrb_ros.exam.measured import MeasuredRecording, read_measured
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.loader import sweep_of
from dcrb_ros.sweep.local_workers import local_workers
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.store import Store

WINDOW = 1.0
"""Length of a window [s]; measured windows do not overlap."""
CLASSES = ("healthy", "outer_ring", "inner_ring", "roller")
LEAST_RATE = 0.9
"""Least sampling rate of another rig's recordings, relative to that of the rig with which they are compared [-]: MFPT has 0.95 times
that of Harbin, and Case Western Reserve a quarter."""
STEP = 4.9e-6
"""Longest time step of the ball bearings [s]."""
BALL_6205 = {"rollers_per_row": 9, "roller_radius": 0.00397, "pitch_radius": 0.01952, "gap": 6e-6}
NICE = {"rollers_per_row": 8, "roller_radius": 0.0029845, "pitch_radius": 0.0158115, "gap": 6e-6}


class Rig(NamedTuple):
    """A measured rig, with the known data of its bearing and operation."""

    name: str
    recordings: str
    """Rig of its faulty recordings in ``recordings.csv``."""
    healthy: tuple[str, ...]
    """Its healthy recordings; the first half calibrates, the second half is tested."""
    rate: int
    """[Hz]"""
    bearing: Mapping[str, float]
    speed: tuple[float, float]
    """Range of the speed [rad/s]."""
    load: tuple[float, float]
    """Range of the load [N]: of CWRU and HIT a guess, of MFPT as stated by the publisher."""


RPM = math.pi / 30.0
RIGS = (
    Rig("cwru", "cwru12", ("cw48_N_0",), 12000, BALL_6205, (1740.0 * RPM, 1800.0 * RPM), (100.0, 600.0)),
    Rig(
        "hit",
        "hitself",
        ("hitself_Normal_600", "hitself_Normal_900", "hitself_Normal_1200"),
        51200,
        BALL_6205,
        (590.0 * RPM, 1210.0 * RPM),
        (100.0, 1000.0),
    ),
    Rig("mfpt", "mfpt", (), 48828, NICE, (1480.0 * RPM, 1510.0 * RPM), (110.0, 1340.0)),
)


@dataclass(frozen=True, eq=False)
class Windows:
    """Features of windows with their classes."""

    names: tuple[str, ...]
    values: Floats
    """Shape (windows, features)."""
    truth: list[str] = field(default_factory=list)
    recording: list[str] = field(default_factory=list)

    @staticmethod
    def of(parts: list[tuple[FeatureTable, str, str]]) -> Windows:
        """Return the windows of tables with their class and recording; windows without features are left out."""
        values = [table.values[np.isfinite(table.values).all(axis=1)] for table, _, _ in parts]
        named = [(fault, name) for sound, (_, fault, name) in zip(values, parts, strict=True) for _ in sound]
        return Windows(parts[0][0].names, np.concatenate(values), [fault for fault, _ in named], [name for _, name in named])


def features(values: Floats, rate: int, angle: Floats, orders: Orders) -> FeatureTable:
    """Return the features of the windows of one axis."""
    return extract_features(values, rate, shaft_angle=angle, bearing=orders, window=WINDOW, hop=WINDOW, axes=["y"])


class Measured(NamedTuple):
    """A measured recording, or a run that stands beside measured ones."""

    name: str
    truth: str
    values: Floats
    """[m/s^2], where the unit is trusted."""
    rate: int
    angle: Floats
    """From the constant speed that the lines of the shaft show [rad]."""
    orders: Orders

    def part(self, begin: float, end: float) -> Measured:
        """Return the recording between two shares of its length."""
        first, last = (round(share * len(self.values)) for share in (begin, end))
        return self._replace(values=self.values[first:last], angle=self.angle[first:last] - self.angle[first])

    def waveform(self) -> Waveform:
        """Return it as a waveform, for the calibration."""
        return Waveform.from_arrays(self.values, self.rate, bearing=self.orders, shaft_angle=self.angle)


def measured(folder: Path, rig: Rig) -> tuple[list[Measured], list[Measured]]:
    """Return the halves of the healthy recordings of a rig that calibrate, and all that is tested."""
    calibrating, tested = [], []
    for row in read_measured(folder):
        if row.name in rig.healthy:
            whole = recording(row, rig.rate)
            calibrating.append(whole.part(0.0, 0.5))
            tested.append(whole.part(0.5, 1.0))
        elif row.rig == rig.recordings and row.truth != "healthy":
            tested.append(recording(row, rig.rate))
    return calibrating, tested


def recording(row: MeasuredRecording, rate: int) -> Measured:
    """Return a recording, resampled to a sampling rate [Hz]."""
    values = signal.resample_poly(row.samples(), rate, row.rate) if row.rate != rate else row.samples()
    angle = 2.0 * np.pi * row.speed * np.arange(len(values)) / rate
    return Measured(row.name, row.truth, values - values.mean(), rate, angle, row.orders)


def measured_elsewhere(folder: Path, rig: Rig) -> Windows:
    """Return the windows of the other rigs at the sampling rate of a rig; a rig of less than 0.9 times its rate is left out."""
    others = [other._replace(rate=rig.rate) for other in RIGS if other.name != rig.name and other.rate >= LEAST_RATE * rig.rate]
    return measured_windows([part for other in others for part in measured(folder, other)[1]])


def measured_windows(recordings: list[Measured]) -> Windows:
    """Return the windows of some recordings."""
    return Windows.of([(features(rec.values, rec.rate, rec.angle, rec.orders), rec.truth, rec.name) for rec in recordings])


def settings_of(rig: Rig) -> dict[str, Any]:
    """Return the parameters of a rig's bearing."""
    radius, pitch, gap = (float(rig.bearing[name]) for name in ("roller_radius", "pitch_radius", "gap"))
    preview = next(rate for rate in range(200, 9, -1) if rig.rate % rate == 0)
    return {
        "bearing.rollers_per_row": int(rig.bearing["rollers_per_row"]),
        "bearing.roller_radius": radius,
        "bearing.pitch_radius": pitch,
        "bearing.inner_raceway_radius": pitch - radius - 0.5 * gap,
        "bearing.outer_raceway_radius": pitch + radius + 0.5 * gap,
        "operating.speed": sum(rig.speed) / 2.0,
        "sensor.sampling_rate": rig.rate,
        "sensor.range": 1e4,
        "simulation.step": 1.0 / (rig.rate * math.ceil(1.0 / (STEP * rig.rate))),
        "publishing.preview_rate": preview,
    }


def conditions(rig: Rig) -> dict[str, dict[str, Any]]:
    """Return the ranges of speed, load and bearing of a rig's machines."""
    return {
        "operating.speed": dict(zip(("low", "high"), rig.speed, strict=True)),
        "operating.load": {**dict(zip(("low", "high"), rig.load, strict=True)), "scale": "log"},
        "operating.speed_fluctuation": {"low": 3e-4, "high": 3e-3, "scale": "log"},
        "surfaces.seed": {"low": 1, "high": 2_000_000_000},
        "surfaces.waviness": {"low": 1e-8, "high": 1e-7, "scale": "log"},
        "surfaces.run_out": {"low": 5e-7, "high": 5e-6, "scale": "log"},
    }


def defects(kind: str) -> dict[str, Any]:
    """Return the settings of a kind of defect, ``outer``, ``inner`` or ``ball``, with ranges of its size; none of ``healthy``."""
    depth = {"low": 1e-5, "high": 1e-4, "scale": "log"}
    if kind == "ball":
        ball = {"width": {"low": 1.5e-4, "high": 8e-4, "scale": "log"}, "depth": depth}
        return {f"faults.roller_1.{key}": value for key, value in ball.items()}
    spall = {
        "width": {"low": 1.5e-4, "high": 1.5e-3, "scale": "log"},
        "depth": depth,
        "kind": "spall",
        "share": {"low": 0.3, "high": 1.0},
        "azimuth": {"low": -1.0, "high": 1.0},
    }
    return {f"faults.{kind}_1.{key}": value for key, value in spall.items()} if kind != "healthy" else {}


def sweep_tree(rig: Rig, base: str, fixed: Mapping[str, Any], vary: Mapping[str, Any], machines: int, seconds: float) -> dict[str, Any]:
    """Return a sweep over machines of a rig, each healthy and with a defect of each component."""
    varied = conditions(rig) | dict(vary)
    return {
        "base": base,
        "set": {key: value for key, value in fixed.items() if key not in varied},
        "design": "latin_hypercube",
        "points": machines,
        "vary": varied,
        "cases": {kind: defects(kind) for kind in ("healthy", "outer", "inner", "ball")},
        "branch_at": 0.3,
        "settle": 0.15,
        "duration": seconds,
        "split": {"train": 1.0, "validation": 0.0, "test": 0.0},
    }


def simulated_windows(tree: Mapping[str, Any], folder: Path, workers: int) -> Windows:
    """Return the windows of a sweep, which is simulated or continued in a folder."""
    plan = Plan(sweep_of(tree, "sim_to_real"))
    with open_data_set(plan, Store(str(folder))) as data_set, local_workers(workers, "auto") as here:
        tally = data_set.make(here, lambda outcomes: print(dict(outcomes), end=" ", flush=True))
    print(dict(tally.statuses), dict(tally.reasons))
    runs = runs_of(folder)
    return Windows.of([(features(run.values - run.values.mean(), run.rate, run.angle, run.orders), run.truth, run.name) for run in runs])


def runs_of(folder: Path) -> Iterator[Measured]:
    """Yield the runs of a finished sweep, each with its condition as its name."""
    table = pd.read_parquet(folder / "labels.parquet")
    for _, row in table[table["status"] == "done"].iterrows():
        with np.load(folder / row["file"]) as content:
            values, angle, rate = content["ay"].astype(np.float64), content["shaft_angle"], int(content["sampling_rate"])
        shaft = abs(row["speed"]) / (2.0 * np.pi)
        orders = Orders(*(float(row[name]) / shaft for name in ("ftf", "bpfo", "bpfi", "bsf")))
        yield Measured(str(row["condition"]), str(row["fault"]), values, rate, np.unwrap(angle), orders)


def saved(windows: Windows, path: Path) -> Windows:
    """Write windows to a file and return them."""
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, values=windows.values, about=json.dumps([windows.names, windows.truth, windows.recording]))
    return windows
