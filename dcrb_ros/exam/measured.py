"""Measured recordings with known truth: a table of files.

The shipped detector judges each as a whole. A detector in Python first receives a healthy signal of the same machine.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from dcrb_ros.bearing.frequencies import CHARACTERISTIC_FREQUENCIES, Orders
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.case import canonical
from dcrb_ros.exam.criteria import UNLIMITED, Criteria, DelayLimits
from dcrb_ros.exam.evaluation import Outcome, Scenario, ScenarioSet, Signal, bearing_scenario, named
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.led_signal import JudgedRecording, LedSignal, expectation, form_of, healthy_recording
from dcrb_ros.messages.received_diagnosis import decode_diagnosis
from dcrb_ros.messages.topics.diagnosis import encode_diagnosis
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.numbers import sampling_rate
from dcrb_ros.schema.refusal import Refusal, nearest, repeated
from dcrb_ros.schema.units import ACCELERATION_UNITS
from dcrb_ros.schema.verdicts import FAULT_CLASSES
from dcrb_ros.settings.files import fields_by_key
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.text.counts import counted
from dcrb_ros.text.tables import read_rows

TABLE = "recordings.csv"
OPTIONAL_COLUMNS = ("speed_rpm_from_lines", "machine", "bearing")
"""Columns that the table may have: the measured speed, the physical rig and the bearing of each recording; see `read_measured`."""
REPLICA_COLUMNS = ("seconds", "load", "pitch_diameter_mm", "gain")
"""Columns that a replica takes instead of drawn values; see `MeasuredRecording`."""
KNOWN, UNKNOWN = "known", "unknown"
"""Values of the column `gain`: whether all bearings of the machine are known to have been recorded with one gain."""
COLUMNS = ("name", "rig", "truth", "sampling_rate", "unit", "speed_rpm_documented", *CHARACTERISTIC_FREQUENCIES)
"""Columns that the table must have."""
SPEEDS = {"lines": "speed_rpm_from_lines", "documented": "speed_rpm_documented"}
LONGEST = 60.0
"""Longest part of a recording that is judged [s]: the longest window of the detector."""
SHORTEST = 0.5
"""Shortest recording that is judged [s]."""
LEAST_TURNS = 4.0
"""Shaft revolutions without which a recording is not judged [-]."""
SAME_LENGTH, SAME_TIME = 0.01, 0.01
"""Relative and absolute difference [s] up to which the length of a file is the one that the table states."""
LARGEST = float(np.finfo(np.float32).max)
"""Largest acceleration, the range of a message [m/s^2]."""
FOUND = 0.9
"""Share of the outer and inner-ring faults that must be named."""


@dataclass(frozen=True, kw_only=True)
class MeasuredRecording(JudgedRecording):
    """A row of the table."""

    unit: str
    file: Path
    bearing: str
    """Bearing on the machine; recordings of one bearing are not independent."""
    seconds: float = math.inf
    """Length according to the table [s]; infinite if it states none."""
    load: float | None = None
    """Radial load [N]; None if it is unknown."""
    pitch_radius: float | None = None
    """Radius of the pitch circle [m]; None if it is unknown."""

    def samples(self) -> Floats:
        """Return the acceleration, shape (samples,) [m/s^2].

        Raises:
            Refusal: the file is missing, is no NPZ file with one array ``a`` of numbers, or has values that are not finite or too large.
        """
        try:
            with self.file.open("rb") as stream, np.load(stream, allow_pickle=False) as arrays:
                given = arrays["a"]
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            reason = getattr(error, "strerror", None) or error
            raise Refusal(f"{self.file} cannot be read ({reason}): it must be an NPZ file with one array 'a'") from None
        if given.ndim != 1 or given.dtype.kind not in "iuf":
            shape = f"the shape {given.shape} and the type {given.dtype}"
            raise Refusal(f"{self.file}: 'a' has {shape}: give the numbers of one axis in one row")
        if not (finite := np.isfinite(given)).all():
            first = int(np.argmin(finite))
            raise Refusal(
                f"{self.file}: 'a' is not finite in {counted(int(np.count_nonzero(~finite)), 'place')}, first {given[first]} at {first}: "
                "give a part without them, or leave it out of the table"
            )
        values, seconds = np.asarray(given, np.float64), len(given) / self.rate
        if seconds < SHORTEST:
            raise Refusal(f"{self.file} has {seconds:.2f} s, but a verdict needs {SHORTEST:g} s: leave it out of the table")
        if math.isfinite(self.seconds) and not math.isclose(seconds, self.seconds, rel_tol=SAME_LENGTH, abs_tol=SAME_TIME):
            raise Refusal(
                f"{self.file} has {seconds:.4g} s at {self.rate} Hz, but the table states {self.seconds:.4g} s: correct seconds or "
                "sampling_rate"
            )
        if (values == values[0]).all():
            raise Refusal(f"{self.file}: 'a' is {values[0]:g} throughout: leave the recording of a dead channel out of the table")
        with np.errstate(over="ignore"):
            values = values * ACCELERATION_UNITS[self.unit]
        if np.abs(values).max() > LARGEST:
            raise Refusal(f"{self.file}: 'a' has values above {LARGEST:.1g} m/s^2, the range of a message: check the column unit")
        return values

    def longest_part(self, seconds: float = LONGEST) -> Floats:
        """Return the acceleration of the first ``seconds`` [m/s^2]; see `samples`."""
        return self.samples()[: round(seconds * self.rate)]


def read_measured(folder: Path, speed: str = "lines") -> list[MeasuredRecording]:
    """Return the recordings of a folder with a table ``recordings.csv`` and files ``recordings/NAME.npz``, which are not opened.

    A column ``machine`` names the physical rig. Without it, the machine is the rig without a number of kHz at its end that is the sampling
    rate: ``cwru12`` and ``cwru48`` are one machine recorded at 12 and 48 kHz. A column ``bearing`` names the bearing. Without it,
    recordings of a machine and a truth whose names agree up to the last underscore are of one bearing.

    Raises:
        Refusal: the table is missing, lacks a column, has an invalid value, or gives one machine two kinds of gain.
    """
    return read_table(folder / TABLE, speed)


def read_table(table: Path, speed: str = "lines") -> list[MeasuredRecording]:
    """Return the recordings of a table; see `read_measured`."""
    if speed not in SPEEDS:
        raise Refusal(f"the column of speeds '{speed}' is unknown: give {' or '.join(SPEEDS)}")
    rows = read_rows(table, tuple(dict.fromkeys((*COLUMNS, SPEEDS[speed]))), (*OPTIONAL_COLUMNS, *REPLICA_COLUMNS))
    if not rows:
        raise Refusal(f"{table} has no rows: list the recordings with {', '.join(COLUMNS)}")
    recordings = []
    for line, row in rows:
        try:
            recordings.append(_recording(row, table.parent / "recordings", SPEEDS[speed]))
        except Refusal as error:
            raise Refusal(f"{table}, line {line}: {error}") from None
    if (twice := repeated(recording.name for recording in recordings)) is not None:
        raise Refusal(f"{table} lists {twice} twice: give every recording once")
    for machine in dict.fromkeys(recording.machine for recording in recordings):
        names = {recording.gain_known: recording.name for recording in recordings if recording.machine == machine}
        if len(names) > 1:
            raise Refusal(
                f"{table}: gain is {KNOWN} for {names[True]} and {UNKNOWN} for {names[False]}, both of the machine {machine}: "
                f"give {KNOWN} for all its recordings or for none"
            )
    return recordings


def _recording(row: dict[str, str], folder: Path, speed: str) -> MeasuredRecording:
    """Return the recording of a row, whose file is in a folder and whose speed is in the column ``speed``."""
    _check_words(row, folder)
    numbers = {column: _number(row, column) for column in (*CHARACTERISTIC_FREQUENCIES, speed, "sampling_rate")}
    if not numbers["sampling_rate"].is_integer():
        raise Refusal(
            f"sampling_rate = {row['sampling_rate']} is not a whole number: resample the recording, for example to a multiple of 100 Hz"
        )
    rate, frequency = sampling_rate(numbers["sampling_rate"], "the row"), numbers[speed] / 60.0
    if frequency <= 0.0:
        raise Refusal(f"{speed} = {row[speed]} is not a speed: give it in rpm, above 0")
    if frequency >= 0.5 * rate:
        raise Refusal(
            f"{speed} = {row[speed]} is outside 0 .. {30.0 * rate:g} rpm, half a turn in each sample at {rate} Hz: check speed and "
            "sampling_rate"
        )
    seconds = _stated(row, "seconds", "s") or math.inf
    if seconds < SHORTEST:
        raise Refusal(f"seconds = {row['seconds']}, but a verdict needs {SHORTEST:g} s: leave {row['name']} out")
    name, rig = row["name"], row["rig"]
    machine = row.get("machine") or rig.removesuffix(f"{rate / 1000.0:g}") or rig
    bearing = row.get("bearing") or f"{row['truth']} {name.rpartition('_')[0] or name}"
    pitch = _stated(row, "pitch_diameter_mm", "mm", _range("bearing.pitch_radius", 2e3))
    return MeasuredRecording(
        name=name,
        rig=rig,
        machine=machine,
        truth=row["truth"],
        rate=rate,
        speed=frequency,
        orders=Orders.from_dict({order: numbers[order] for order in CHARACTERISTIC_FREQUENCIES}),
        gain_known=row.get("gain") == KNOWN,
        unit=row["unit"],
        file=folder / f"{name}.npz",
        bearing=f"{machine} {bearing}",
        seconds=seconds,
        load=_stated(row, "load", "N", _range("operating.load")),
        pitch_radius=None if pitch is None else 5e-4 * pitch,
    )


def _check_words(row: dict[str, str], folder: Path) -> None:
    """Refuse names and words that are unknown."""
    truth, unit, name, gain = row["truth"], row["unit"], row["name"], row.get("gain") or UNKNOWN
    if truth not in FAULT_CLASSES:
        known = f"{', '.join(FAULT_CLASSES)}{nearest(str(truth), FAULT_CLASSES)}"
        raise Refusal(f"truth = {truth or 'nothing'} is not a verdict: give one of {known}")
    if unit not in ACCELERATION_UNITS:
        raise Refusal(f"unit = {unit or 'nothing'} is unknown: give one of {', '.join(ACCELERATION_UNITS)}")
    if not name or name != Path(name).name or name in (".", ".."):
        raise Refusal(f"name = '{name}' is not the name of a file in {folder}: give it without a path")
    if not row["rig"]:
        raise Refusal("rig is empty, so that all recordings without one were of one machine: name the rig")
    if gain not in (KNOWN, UNKNOWN):
        raise Refusal(
            f"gain = {gain} is invalid: give {KNOWN} if all bearings of this rig were recorded with one gain, otherwise {UNKNOWN} or "
            "nothing"
        )


def _number(row: dict[str, str], column: str) -> float:
    """Return the number in a column."""
    value = _parsed(row[column])
    if not math.isfinite(value):
        raise Refusal(f"{column} = {row[column] or 'nothing'} is not a finite number: give one, or leave {row['name']} out")
    return value


def _parsed(text: str | None) -> float:
    """Return a text as a number; NaN for another text."""
    try:
        return float(text or "")
    except ValueError:
        return math.nan


def _range(key: str, factor: float = 1.0) -> tuple[float, float]:
    """Return the range above 0 of a parameter, in another unit by a ``factor``."""
    field = fields_by_key()[key]
    assert field.low is not None
    assert field.high is not None
    return max(0.0, factor * field.low), factor * field.high


def _stated(row: dict[str, str], column: str, unit: str, limits: tuple[float, float] = (0.0, math.inf)) -> float | None:
    """Return the number in an optional column, above 0 and within ``limits``; None if it is empty."""
    text = row.get(column)
    if not text:
        return None
    value = _parsed(text)
    if not (math.isfinite(value) and value > 0.0):
        raise Refusal(f"{column} = {text} is not a number above 0: give it in {unit}, or leave it empty")
    low, high = limits
    if not low <= value <= high:
        raise Refusal(f"{column} = {text} is outside {low:g} .. {high:g} {unit}: give it in {unit}, or leave it empty")
    return value


def diagnose(recording: MeasuredRecording, parameters: DetectorParameters, *, gain: float = 1.0, seconds: float = LONGEST) -> Diagnosis:
    """Return the diagnosis of the first ``seconds`` of a recording, judged once in a single window; ``gain`` scales the samples.

    Raises:
        Refusal: see `MeasuredRecording.samples`.
    """
    return diagnose_as_a_whole(gain * recording.longest_part(seconds), recording.rate, recording.speed, recording.orders, parameters)


def diagnose_as_a_whole(values: Floats, rate: int, frequency: float, orders: Orders, parameters: DetectorParameters) -> Diagnosis:
    """Return the diagnosis of a signal of shape (samples,) at a constant shaft ``frequency`` [Hz], judged once in a single window."""
    duration = len(values) / rate
    once = {"window": duration, "hop": duration, "least_window": SHORTEST, "confirm": 1, "least_turns": LEAST_TURNS}
    detector = FaultDetector(orders, rate, parameters.model_copy(update=once))
    angle = np.mod(2.0 * np.pi * frequency / rate * np.arange(len(values)), 2.0 * np.pi)
    diagnosis = detector.update(0, np.column_stack([values, values]), angle)
    if diagnosis is None:
        raise Refusal(f"{duration:.2f} s gave no diagnosis: give a longer recording")
    return diagnosis


@dataclass(frozen=True)
class WholeRecording:
    """A recording that is judged as a whole."""

    recording: MeasuredRecording
    longest: float
    """Longest part that is judged [s]."""

    def expectation(self) -> Expectation:
        """Return what is expected; the verdict is that of the last sample."""
        return expectation(self.recording, (len(self.recording.longest_part(self.longest)) - 1) / self.recording.rate)


@dataclass(frozen=True)
class ShippedOnce:
    """The shipped detector as a candidate that judges a measured recording once, in a single window."""

    name: str
    parameters: DetectorParameters
    parallel: bool = True

    def diagnose(self, whole: WholeRecording) -> Outcome:
        """Return its diagnosis; see `diagnose`."""
        diagnosis = diagnose(whole.recording, self.parameters, seconds=whole.longest)
        return Outcome([decode_diagnosis(encode_diagnosis(diagnosis))])


def whole_scenarios(recordings: Sequence[MeasuredRecording], speed: str, longest: float = LONGEST) -> ScenarioSet[WholeRecording]:
    """Return recordings of a table, each judged as a whole, up to ``longest`` [s]; ``speed`` names the column of their speeds."""
    _lengths(recordings)
    signals = [WholeRecording(recording, longest) for recording in recordings]
    scenarios = [bearing_scenario(named(s.recording.name, s.expectation), partial(_itself, s)) for s in signals]
    return _scenario_set(speed, [longest, "whole"], recordings, scenarios)


def led_scenarios(
    recordings: Sequence[MeasuredRecording], speed: str, longest: float = LONGEST
) -> ScenarioSet[LedSignal[MeasuredRecording]]:
    """Return recordings of a table, each after a healthy signal; see `led_recordings`. ``speed`` names the column of their speeds."""
    signals = led_recordings(recordings, longest)
    scenarios = [bearing_scenario(named(s.recording.name, s.expectation), partial(_itself, s)) for s in signals]
    task = [[dataclasses.astuple(s.form), s.lead.name if s.lead else ""] for s in signals]
    return _scenario_set(speed, [longest, canonical(task)], recordings, scenarios)


def led_recordings(recordings: Sequence[MeasuredRecording], longest: float) -> list[LedSignal[MeasuredRecording]]:
    """Return the beginnings of recordings, of each at most ``longest`` [s], after a healthy signal.

    A healthy recording follows its own end. A faulty one follows the end of the healthy one of the same machine and bearing type at the
    nearest speed, if there is one. All of a machine and bearing type have one form; see `form_of`.

    Raises:
        Refusal: see `MeasuredRecording.samples`, two recordings have the same samples, or a healthy one is too short to be divided.
    """
    seconds = _lengths(recordings)
    for one in recordings:
        if one.truth == "healthy" and seconds[one.name] < 2.0 * SHORTEST:
            raise Refusal(
                f"{one.file} has {seconds[one.name]:.2f} s, but a healthy recording needs {2.0 * SHORTEST:g} s, since one half follows the "
                "other: leave it out of the table"
            )
    return [LedSignal(one, healthy_recording(one, recordings), form_of(one, seconds, recordings, longest)) for one in recordings]


def _lengths(recordings: Sequence[MeasuredRecording]) -> dict[str, float]:
    """Return the length of each recording by its name [s]; refuse samples that two of them have."""
    seconds, of_samples = dict[str, float](), dict[str, str]()
    for one in recordings:
        samples = one.samples()
        seconds[one.name] = len(samples) / one.rate
        first = of_samples.setdefault(hashlib.sha256(samples.tobytes()).hexdigest(), one.name)
        if first != one.name:
            raise Refusal(f"{one.name} has the same samples as {first}, so it is no recording of its own: leave one out of the table")
    return seconds


def _scenario_set(
    speed: str, task: Sequence[float | str], recordings: Sequence[MeasuredRecording], scenarios: Sequence[Scenario[Signal]]
) -> ScenarioSet[Signal]:
    """Return the scenarios with a digest of the ``task``, the samples and everything in the table on which the verdicts depend."""
    rows = [
        [one.name, one.truth, one.rig, one.machine, one.unit, one.rate, one.speed, one.orders.as_dict(), one.gain_known]
        for one in recordings
    ]
    digest = hashlib.sha256(canonical([files_hash(recordings), *task, rows]).encode()).hexdigest()
    return ScenarioSet(f"measured, speed {speed}", measured_criteria(), scenarios, digest)


def _itself(signal: Signal) -> Signal:
    return signal


def measured_criteria() -> Criteria:
    """Return the criteria: no false alarm, and nine of ten faults of the rings named; when does not count."""
    delays = DelayLimits(**dict.fromkeys(DelayLimits.model_fields, UNLIMITED))
    return Criteria(delay=delays, found=FOUND, smallest_width=0.0, silence=UNLIMITED)


def files_hash(recordings: Sequence[MeasuredRecording]) -> str:
    """Return the SHA-256 of the names and contents of the files in their order."""
    digest = hashlib.sha256()
    for recording in recordings:
        digest.update(recording.name.encode())
        digest.update(recording.file.read_bytes())
    return digest.hexdigest()
