"""Signals of measured rigs and of simulated machines with the same kinds of defects, and their statistics."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from drawn_machines import TRUTHS, Machine, drawn_machines
from line_ratio import kurtogram_ratio, line_ratio
from scipy import signal
from signal_statistics import SignalStatistics, signal_statistics

from dcrb_ros.bearing.frequencies import Orders, characteristic_orders
from dcrb_ros.diagnosis.detection import detect
from dcrb_ros.exam.measured import read_measured
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.run import SimulationResult, simulate
from dcrb_ros.text.writing import write_whole
from dcrb_ros.validation.realism import lines_of, squared_envelope

RIGS = {"CWRU": ("cwru12", 9), "HIT": ("hitself", 9), "MFPT": ("mfpt", 8)}
"""Rig of the recordings and rolling elements, by name."""
HEALTHY = {"CWRU": ("cw48_N_0",), "HIT": ("hitself_Normal_600", "hitself_Normal_900", "hitself_Normal_1200")}
"""The healthy recordings of a rig with the same bearing; those of HIT have three speeds."""
SETTLING, DURATION = 0.2, 3.0
"""Simulated time before the statistics, and of them [s]."""
SPALL = {"width": 0.5e-3, "depth": 1e-4, "share": 1.0, "azimuth": 0.0}
DEFECTS: dict[str, dict[str, dict[str, Any]]] = {
    "6205": {
        "healthy": {},
        "outer": {"outer_1": SPALL},
        "inner": {"inner_1": SPALL},
        "ball": {"roller_1": {"width": 0.5e-3, "depth": 1e-4}},
    },
    "axle box": {"healthy": {}, "outer": {"outer_1": {**SPALL, "width": 0.8e-3, "depth": 6e-5, "share": 0.35}}},
}
"""Faults by bearing and kind."""
BENCHES = {"6205": "ball_bearing_6205", "axle box": "healthy"}
"""Configuration of each bearing; the one in an axle box has the load of its configuration."""
DRAWN: dict[str, tuple[str, ...]] = {"equal": ("impacts", "background"), "drawn": ()}
"""Parts without which machines are drawn."""


class Case(NamedTuple):
    """A signal of one axis, and the orders and speed that locate its lines."""

    name: str
    values: Floats
    rate: float
    shaft: float
    """[Hz]"""
    orders: Orders
    elements: int

    def statistics(self, kind: str) -> SignalStatistics:
        """Return the statistics of the lines of a kind of defect, of BPFO if the bearing is healthy."""
        return signal_statistics(self.values, self.rate, self.shaft, self.orders, self.elements, order_of(self.orders, kind))

    def ratio(self, kind: str) -> float:
        """Return R of the lines of a kind of defect in the envelope of 2 to 20 kHz [-]."""
        squared, rate = squared_envelope(self.values, self.rate)
        return line_ratio(squared, rate, lines_of(squared, rate).fitted(order_of(self.orders, kind) * self.shaft), self.shaft)

    def kurtogram_ratio(self, kind: str) -> float:
        """Return R of the lines of a kind of defect in the bands of the kurtogram [-]."""
        squared, rate = squared_envelope(self.values, self.rate)
        frequency = lines_of(squared, rate).fitted(order_of(self.orders, kind) * self.shaft)
        return kurtogram_ratio(self.values - self.values.mean(), self.rate, frequency, self.shaft)


class Row(NamedTuple):
    """The statistics of one signal."""

    name: str
    statistics: SignalStatistics
    ratio_growth: float
    """R over that of the healthy bearing of the same machine [-]; NaN without one."""
    kurtogram_growth: float
    """The same in the bands of the kurtogram [-]."""
    verdict: str
    """Verdict of the shipped detector on a simulated healthy bearing, at the sensor; otherwise empty."""


def order_of(orders: Orders, kind: str) -> float:
    """Return the order of the impacts of a kind of defect [-]."""
    return {"outer": orders.bpfo, "inner": orders.bpfi, "ball": 2.0 * orders.bsf, "healthy": orders.bpfo}[kind]


def recordings(folder: Path) -> dict[str, tuple[Case, str, str]]:
    """Return the cases of the recordings of a folder by name, each with its rig and truth."""
    found, elements = {}, dict(RIGS.values())
    for row in read_measured(folder):
        values = row.samples()
        case = Case(row.name, values - values.mean(), float(row.rate), row.speed, row.orders, elements.get(row.rig, 9))
        found[row.name] = case, row.rig, row.truth
    return found


def at_rate_of(case: Case, other: Case) -> Case:
    """Return a case decimated to the sampling rate of another one."""
    factor = round(case.rate / other.rate)
    return case if factor == 1 else case._replace(values=signal.resample_poly(case.values, 1, factor), rate=case.rate / factor)


def measured_rows(folder: Path, rig: str, kind: str) -> list[Row]:
    """Return the statistics of the recordings of a rig with a kind of defect."""
    cases, rows = recordings(folder), []
    for case, its, truth in cases.values():
        if truth == TRUTHS[kind] and (case.name in HEALTHY.get(rig, ()) if kind == "healthy" else its == RIGS[rig][0]):
            rows.append(row_of(case, None if kind == "healthy" else healthy_of(rig, case, cases), kind))
    return rows


def healthy_of(rig: str, case: Case, cases: Mapping[str, tuple[Case, str, str]]) -> Case | None:
    """Return the healthy recording of a rig for a faulty one, of the same speed if there are several."""
    names = HEALTHY.get(rig, ())
    alike = [name for name in names if len(names) == 1 or name.split("_")[-1] == case.name.split("_")[-1]]
    return at_rate_of(cases[alike[0]][0], case) if alike else None


def row_of(case: Case, healthy: Case | None, kind: str, verdict: str = "") -> Row:
    """Return the statistics of a signal, and the growth of its lines over those of the healthy bearing of the machine."""
    found = case.statistics(kind)
    ratio, kurtogram = (healthy.ratio(kind), healthy.kurtogram_ratio(kind)) if healthy is not None else (float("nan"), float("nan"))
    return Row(case.name, found, found.ratio / ratio, found.kurtogram_ratio / kurtogram, verdict)


def machines_of(bearing: str, drawing: str, machines: int) -> list[Machine]:
    """Return simulated machines at the speed and sampling rate of a bench; ``drawing`` is a key of `DRAWN`."""
    bench = load_configuration(BENCHES[bearing])
    return drawn_machines(
        BENCHES[bearing],
        characteristic_orders(bench.bearing),
        bench.sensor.sampling_rate,
        (bench.operating.speed * 30.0 / np.pi,),
        machines,
        load=None if bearing == "6205" else bench.operating.load,
        without=DRAWN[drawing],
    )


def run_of(bearing: str, machine: Machine, kind: str) -> SimulationResult:
    """Return the run of a simulated machine with a defect of `DEFECTS`, with its settling time."""
    faults = {f"faults.{name}.{key}": value for name, fault in DEFECTS[bearing][kind].items() for key, value in fault.items()}
    return simulate(BENCHES[bearing], SETTLING + DURATION, settings={**machine[kind, 0], **faults})


def case_of(run: SimulationResult, name: str, *, ring: bool) -> Case:
    """Return the acceleration in Y of a run after its settling time, at the outer ring or at the sensor."""
    values = (run.clean if ring else run.acceleration)[round(SETTLING * run.sampling_rate) :, 1].astype(np.float64)
    shaft = run.configuration.operating.speed / (2.0 * np.pi)
    return Case(name, values, float(run.sampling_rate), shaft, run.orders, run.configuration.bearing.rollers_per_row)


def simulated_rows(bearing: str, machine: Machine, name: str) -> Iterator[tuple[str, str, Row]]:
    """Yield the place (ring or sensor), the kind of defect and the statistics of a simulated machine."""
    healthy: dict[str, Case] = {}
    for kind in DEFECTS[bearing]:
        run = run_of(bearing, machine, kind)
        verdict = detect(run).verdict if kind == "healthy" else ""
        for place in ("ring", "sensor"):
            case = case_of(run, f"{bearing} {kind} {name}", ring=place == "ring")
            yield place, kind, row_of(case, healthy.get(place), kind, verdict if place == "sensor" else "")
            if kind == "healthy":
                healthy[place] = case


def write_rows(path: Path, rows: Mapping[str, list[Row]]) -> None:
    """Write rows by group as JSON."""
    write_whole(path, json.dumps({group: [[*row[:1], list(row.statistics), *row[2:]] for row in its] for group, its in rows.items()}))


def read_rows(path: Path) -> dict[str, list[Row]]:
    """Return the rows that `write_rows` wrote."""
    groups = json.loads(path.read_text(encoding="utf-8"))
    return {group: [Row(name, SignalStatistics(*values), *rest) for name, values, *rest in rows] for group, rows in groups.items()}
