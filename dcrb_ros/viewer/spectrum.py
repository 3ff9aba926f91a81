"""What the fault detector sees in a recording, window by window, and the lines at which faults show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.messages.statuses import ERROR
from dcrb_ros.messages.topics.diagnosis import LEVELS
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.viewer.content import Series, Times, Verdict, Waveform

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.detector import Diagnosis

ORDER_STEP = 0.025
"""Distance of the orders at which spectra are shown [-]."""
FINER = 2
"""Orders looked at for each one shown, which is the largest of them, so that no line is lost."""
SHORTEST_HOP, SHORTEST_WINDOW = 0.25, 0.5
"""Time between two spectra and length of the window at least [s]."""
SPECTRA_WANTED = 20
"""Spectra that a recording is cut into; of a long one there are more, and windows follow each other without overlap."""


@dataclass(frozen=True)
class Spectra:
    """Envelope spectra over time, as levels over the background."""

    time_ns: Times
    """End of each window [ns]."""
    orders: Floats
    """Multiples of the shaft frequency [-]."""
    level: Floats
    """Level over the background, shape (windows, orders) [dB]."""
    shaft_frequency: Floats
    """Mean shaft frequency of each window [Hz]."""

    @property
    def highest_order(self) -> float:
        """Highest order shown [-]."""
        return float(self.orders[-1])


@dataclass(frozen=True)
class Comb:
    """A fault and the lines at which it shows."""

    name: str
    orders: tuple[float, ...]
    """Its harmonics as multiples of the shaft frequency [-]."""


def fault_combs(orders: Orders, highest: float) -> list[Comb]:
    """Return the harmonics of BPFO, BPFI, 2BSF and FTF below the ``highest`` order; of FTF the first four."""
    bases = {"BPFO": orders.bpfo, "BPFI": orders.bpfi, "2BSF": 2.0 * orders.bsf, "FTF": orders.ftf}
    combs = []
    for name, base in bases.items():
        most = 4 if name == "FTF" else int(highest / base)
        combs.append(Comb(name, tuple(base * k for k in range(1, most + 1) if base * k < highest)))
    return combs


def diagnoses(waveform: Waveform, orders: Orders) -> list[Diagnosis]:
    """Return what the fault detector with its default parameters says of the waveform; a short one makes one window."""
    from dcrb_ros.diagnosis.detector import FaultDetector
    from dcrb_ros.diagnosis.parameters import DetectorParameters

    usual = DetectorParameters()
    seconds = len(waveform.time_ns) / waveform.rate
    window = min(usual.window, seconds)
    if window < SHORTEST_WINDOW:
        return []
    hop = min(window, max(SHORTEST_HOP, seconds / SPECTRA_WANTED))
    detector = FaultDetector(orders, waveform.rate, usual.model_copy(update={"window": window, "hop": hop}))
    found = []
    for piece in pieces(waveform, round(hop * waveform.rate)):
        index = (int(waveform.time_ns[piece.start]) * waveform.rate + 500_000_000) // 1_000_000_000
        diagnosis = detector.update(index, waveform.acceleration[piece], waveform.shaft_angle[piece])
        if diagnosis is not None:
            found.append(diagnosis)
    return found


def pieces(waveform: Waveform, length: int) -> Iterator[slice]:
    """Yield slices of ``length`` samples at most, none across a gap in the waveform."""
    gaps = np.flatnonzero(np.diff(waveform.time_ns) > 1_500_000_000 // waveform.rate) + 1
    borders = [0, *gaps.tolist(), len(waveform.time_ns)]
    for first, last in pairwise(borders):
        for start in range(first, last, length):
            yield slice(start, min(start + length, last))


def envelope_spectra(found: Sequence[Diagnosis]) -> Spectra | None:
    """Return the spectra of the diagnoses that have one, on common orders; ``None`` when there is none."""
    seen = [diagnosis for diagnosis in found if len(diagnosis.spectrum[0])]
    if not seen:
        return None
    count = int(min(diagnosis.spectrum[0][-1] for diagnosis in seen) / ORDER_STEP)
    fine = np.arange(1, FINER * count + 1, dtype=np.float64) * (ORDER_STEP / FINER)
    amplitude: Floats = np.array([np.interp(fine, *diagnosis.spectrum) for diagnosis in seen])
    return Spectra(
        time_ns=np.array([round(diagnosis.time * 1e9) for diagnosis in seen], np.int64),
        orders=fine[FINER - 1 :: FINER],
        level=over_background(amplitude.reshape(len(seen), count, FINER).max(axis=2)),
        shaft_frequency=np.array([diagnosis.shaft_frequency for diagnosis in seen]),
    )


def over_background(amplitude: Floats) -> Floats:
    """Return the level of each amplitude over the median within an order on either side, shape (windows, orders) [dB]."""
    from scipy.ndimage import median_filter

    # Row by row: over more dimensions than one the filter begins anew at every place, and takes ten times as long.
    floor = np.array([median_filter(row, size=2 * round(1.0 / ORDER_STEP) + 1, mode="nearest") for row in amplitude])
    smallest = np.finfo(np.float64).tiny
    return np.asarray(20.0 * np.log10(np.maximum(amplitude, smallest) / np.maximum(floor, smallest)), np.float64)


def indicators_of(found: Sequence[Diagnosis]) -> Series | None:
    """Return the levels at the fault orders over time [dB]."""
    seen = [diagnosis for diagnosis in found if len(diagnosis.spectrum[0])]
    if not seen:
        return None
    names = tuple(seen[0].levels)
    times = np.array([round(diagnosis.time * 1e9) for diagnosis in seen], np.int64)
    return Series(times, names, np.array([[diagnosis.levels[name] for name in names] for diagnosis in seen]))


def verdicts_of(found: Sequence[Diagnosis]) -> tuple[Verdict, ...]:
    """Return the verdicts of the diagnoses."""
    return tuple(Verdict(round(d.time * 1e9), d.verdict, LEVELS.get(d.verdict, ERROR), {"reason": d.reason}) for d in found)
