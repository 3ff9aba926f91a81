"""Measured recordings with known truth: a table of files, judged by the shipped detector, each as a whole."""

from __future__ import annotations

import csv
import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from dcrb_ros.bearing.kinematics import CHARACTERISTIC_FREQUENCIES, Orders
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.criteria import Criteria, DelayLimits
from dcrb_ros.exam.evaluation import OnDone, named
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.messages.received_diagnosis import decode_diagnosis
from dcrb_ros.messages.topics.diagnosis import encode_diagnosis
from dcrb_ros.runtime.processes import in_processes
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.numbers import sampling_rate
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.units import ACCELERATION_UNITS
from dcrb_ros.schema.verdicts import FAULT_CLASSES
from dcrb_ros.stream.diagnosis import Diagnosis

TABLE = "recordings.csv"
COLUMNS = ("name", "rig", "truth", "sampling_rate", "unit", "speed_rpm_documented", *CHARACTERISTIC_FREQUENCIES)
"""Columns that the table must have; `speed_rpm_from_lines` is optional."""
SPEEDS = {"lines": "speed_rpm_from_lines", "documented": "speed_rpm_documented"}
LONGEST = 60.0
"""Longest part of a recording that is judged [s]: the longest window of the detector."""
SHORTEST = 0.5
"""Shortest recording that is judged [s]."""
UNLIMITED = 1e6
"""Delays and silences do not count: there is one verdict per recording [s]."""
FOUND = 0.9
"""Share of the outer and inner-ring faults that must be named."""


@dataclass(frozen=True)
class MeasuredRecording:
    """A row of the table."""

    name: str
    rig: str
    truth: str
    rate: int
    """[Hz]"""
    unit: str
    speed: float
    """Speed of the shaft [Hz]."""
    orders: Orders
    file: Path

    def samples(self) -> Floats:
        """Return the acceleration, shape (samples,) [m/s^2].

        Raises:
            Refusal: the file is missing, is no NPZ file with one array ``a`` of numbers, or has values that are not finite.
        """
        try:
            with np.load(self.file, allow_pickle=False) as found:
                values = np.asarray(found["a"], np.float64)
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise Refusal(f"{self.file} cannot be read ({error}): it must be an NPZ file with one array 'a'") from None
        if values.ndim != 1 or not np.isfinite(values).all():
            raise Refusal(f"{self.file}: 'a' has shape {values.shape} or values that are not finite: it must be one row of numbers")
        if len(values) < SHORTEST * self.rate:
            raise Refusal(f"{self.file} has {len(values) / self.rate:.2f} s, but a verdict needs {SHORTEST:g} s: leave it out of the table")
        return values * ACCELERATION_UNITS[self.unit]


def read_measured(folder: Path, speed: str = "lines") -> list[MeasuredRecording]:
    """Return the recordings of a folder with a table ``recordings.csv`` and files ``recordings/NAME.npz``.

    Raises:
        Refusal: the table is missing, lacks a column, or has an invalid value.
    """
    table = folder / TABLE
    try:
        with table.open(encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise Refusal(f"{table} cannot be read ({error}): give a folder with this table of files and truth") from None
    if not rows:
        raise Refusal(f"{table} has no rows: list the recordings with {', '.join(COLUMNS)}")
    missing = [column for column in (*COLUMNS, SPEEDS[speed]) if column not in rows[0]]
    if missing:
        raise Refusal(f"{table} lacks the columns {', '.join(missing)}: it needs {', '.join(COLUMNS)}")
    found = [_row(table, number, row, SPEEDS[speed]) for number, row in enumerate(rows, 2)]
    names = [one.name for one in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise Refusal(f"{table} lists {twice} twice: give every recording once")
    return found


def _row(table: Path, line: int, row: dict[str, str], speed: str) -> MeasuredRecording:
    try:
        orders = Orders.from_dict({name: float(row[name]) for name in CHARACTERISTIC_FREQUENCIES})
        frequency = float(row[speed]) / 60.0
        rate = sampling_rate(float(row["sampling_rate"]), str(table))
    except (TypeError, ValueError, Refusal) as error:
        raise Refusal(f"{table}, line {line}: {error}") from None
    if not (math.isfinite(frequency) and frequency > 0.0):
        raise Refusal(f"{table}, line {line}: {speed} = {row[speed]} is not a speed: give it in rpm, above 0")
    if row["truth"] not in FAULT_CLASSES:
        known = f"{', '.join(FAULT_CLASSES)}{nearest(str(row['truth']), FAULT_CLASSES)}"
        raise Refusal(f"{table}, line {line}: truth = {row['truth']} is not a verdict: give one of {known}")
    if row["unit"] not in ACCELERATION_UNITS:
        raise Refusal(f"{table}, line {line}: unit = {row['unit']} is unknown: give one of {', '.join(ACCELERATION_UNITS)}")
    name = row["name"]
    return MeasuredRecording(
        name, row["rig"], row["truth"], rate, row["unit"], frequency, orders, table.parent / "recordings" / f"{name}.npz"
    )


def diagnose(recording: MeasuredRecording, parameters: DetectorParameters, *, gain: float = 1.0, seconds: float = LONGEST) -> Diagnosis:
    """Return the diagnosis of the first ``seconds`` of a recording, judged once in a single window; ``gain`` scales the samples.

    Raises:
        Refusal: see `MeasuredRecording.samples`.
    """
    values = gain * recording.samples()[: round(seconds * recording.rate)]
    return diagnose_as_a_whole(values, recording.rate, recording.speed, recording.orders, parameters)


def diagnose_as_a_whole(values: Floats, rate: int, frequency: float, orders: Orders, parameters: DetectorParameters) -> Diagnosis:
    """Return the diagnosis of a signal of shape (samples,) at a constant shaft ``frequency`` [Hz], judged once in a single window."""
    duration = len(values) / rate
    once = {"window": duration, "hop": duration, "least_window": SHORTEST, "confirm": 1, "least_turns": 4.0}
    detector = FaultDetector(orders, rate, parameters.model_copy(update=once))
    angle = np.mod(2.0 * np.pi * frequency / rate * np.arange(len(values)), 2.0 * np.pi)
    found = detector.update(0, np.column_stack([values, values]), angle)
    if found is None:
        raise Refusal(f"{duration:.2f} s gave no diagnosis: give a longer recording")
    return found


def evaluate_measured(folder: Path, parameters: DetectorParameters, speed: str, name: str, workers: int, on_done: OnDone) -> Report:
    """Return the report of the recordings of a folder; ball faults enter the statistics, but are not required."""
    recordings = read_measured(folder, speed)
    calls = {one.name: partial(named, one.name, partial(diagnose, one, parameters)) for one in recordings}
    diagnoses: dict[str, Diagnosis] = {}
    for one, diagnosis in in_processes(calls, min(workers, len(calls))):
        diagnoses[one] = diagnosis
        on_done(one)
    criteria = measured_criteria()
    results = tuple(
        score_scenario(expectation(one, diagnoses[one.name].time), [decode_diagnosis(encode_diagnosis(diagnoses[one.name]))], criteria)
        for one in recordings
    )
    return Report(f"measured, speed {speed}", name, criteria, files_hash(recordings), results)


def measured_criteria() -> Criteria:
    """Return the criteria: no false alarm, and nine of ten faults of the rings named; when does not count."""
    delays = DelayLimits(**dict.fromkeys(DelayLimits.model_fields, UNLIMITED))
    return Criteria(delay=delays, found=FOUND, smallest_width=0.0, silence=UNLIMITED)


def expectation(one: MeasuredRecording, end: float, onset: float = 0.0) -> Expectation:
    """Return what is expected of a recording that begins at ``onset`` and ends at ``end`` [s]; ball faults are not required."""
    # Envelope analysis cannot name most ball faults (Smith and Randall 2015), so they enter the statistics only.
    return Expectation(one.name, one.truth, end, onset, tags={"rig": one.rig}, required=one.truth != "roller")


def files_hash(recordings: Sequence[MeasuredRecording]) -> str:
    """Return the SHA-256 of the names and contents of the files in their order."""
    digest = hashlib.sha256()
    for one in recordings:
        digest.update(one.name.encode())
        digest.update(one.file.read_bytes())
    return digest.hexdigest()
