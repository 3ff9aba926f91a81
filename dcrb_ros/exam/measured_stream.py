"""Measured recordings as a stream for detectors in Python, which learn what healthy is before the recording under evaluation begins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from math import gcd, isclose
from pathlib import Path

import numpy as np

from dcrb_ros.bearing.waveform import Piece
from dcrb_ros.exam.detector_run import run_on_pieces
from dcrb_ros.exam.evaluation import OnDone, named
from dcrb_ros.exam.measured import LONGEST, MeasuredRecording, expectation, files_hash, measured_criteria, read_measured
from dcrb_ros.exam.plugin import load_plugin
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.runtime.processes import in_processes
from dcrb_ros.schema.arrays import Floats

LEAD = 5.0
"""Longest part of a healthy recording before the one under evaluation [s]."""
PIECE = 0.05
"""Length of a block [s]."""
SAME_BEARING = 1e-3
"""Largest relative difference between the orders of one bearing in two rows of the table [-]."""


def healthy_lead(one: MeasuredRecording, recordings: Sequence[MeasuredRecording]) -> MeasuredRecording | None:
    """Return the healthy recording of the same bearing at the nearest speed, but not ``one`` itself; None if there is none.

    The same bearing has the same orders. A higher sampling rate is reduced, so that rates may differ; a lower one cannot be used.
    """
    candidates = [
        other
        for other in recordings
        if other.truth == "healthy" and other.name != one.name and other.rate >= one.rate and _same_bearing(other, one)
    ]
    return min(candidates, key=lambda other: (abs(other.speed - one.speed), other.name), default=None)


def _same_bearing(first: MeasuredRecording, second: MeasuredRecording) -> bool:
    pairs = zip(first.orders.as_dict().values(), second.orders.as_dict().values(), strict=True)
    return all(isclose(a, b, rel_tol=SAME_BEARING) for a, b in pairs)


def stream(one: MeasuredRecording, lead: MeasuredRecording | None) -> tuple[list[Piece], float]:
    """Return the blocks of the healthy lead and of a recording after it, and the time at which the latter begins [s].

    The shaft turns on without a jump, at the speed of each.
    """
    signal = one.samples()[: round(LONGEST * one.rate)]
    before = np.zeros(0) if lead is None else _resampled(lead, one.rate)
    values = np.concatenate([before, signal])
    frequency = np.concatenate([np.full(len(before), lead.speed if lead else 0.0), np.full(len(signal), one.speed)])
    angle = np.mod(np.cumsum(frequency) * (2.0 * np.pi / one.rate), 2.0 * np.pi)
    return list(_pieces(values, angle, one.rate)), len(before) / one.rate


def _resampled(lead: MeasuredRecording, rate: int) -> Floats:
    from scipy.signal import resample_poly

    signal = lead.samples()[: round(LEAD * lead.rate)]
    common = gcd(lead.rate, rate)
    return np.asarray(signal if lead.rate == rate else resample_poly(signal, rate // common, lead.rate // common), np.float64)


def _pieces(values: Floats, angle: Floats, rate: int) -> Iterator[Piece]:
    length = max(1, int(PIECE * rate))
    for begin in range(0, len(values), length):
        part = values[begin : begin + length].astype(np.float32)
        yield Piece(begin, np.column_stack([part, part]), angle[begin : begin + length].astype(np.float32), 0.0)


def diagnose_stream(one: MeasuredRecording, lead: MeasuredRecording | None, given: str) -> list[ReceivedDiagnosis]:
    """Return the diagnoses of a recording and its healthy lead by a detector in the form of `load_plugin`."""
    pieces, _ = stream(one, lead)
    return run_on_pieces(load_plugin(given), pieces, one.orders, one.rate)


def evaluate_measured_stream(folder: Path, given: str, speed: str, name: str, workers: int, on_done: OnDone) -> Report:
    """Return the report of the recordings of a folder by a detector in Python.

    Each recording follows a healthy one of the same bearing where the table has one. The last verdict counts, whenever it comes, and an
    alarm in the healthy lead is a false one.
    """
    recordings = read_measured(folder, speed)
    leads = {one.name: healthy_lead(one, recordings) for one in recordings}
    calls = {one.name: partial(named, one.name, partial(diagnose_stream, one, leads[one.name], given)) for one in recordings}
    diagnoses: dict[str, list[ReceivedDiagnosis]] = {}
    for done, found in in_processes(calls, min(workers, len(calls))):
        diagnoses[done] = found
        on_done(done)
    criteria = measured_criteria()
    results = []
    for one in recordings:
        pieces, onset = stream(one, leads[one.name])
        end = (pieces[-1].first_index + len(pieces[-1].shaft_angle)) / one.rate
        results.append(score_scenario(expectation(one, end, onset), diagnoses[one.name], criteria))
    return Report(f"measured, speed {speed}", name, criteria, files_hash(recordings), tuple(results))
