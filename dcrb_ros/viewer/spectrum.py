"""The squared envelope spectra of a recording, computed by the fault detector window by window, and the fault lines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.messages.points import decode_spectrum, index_at
from dcrb_ros.messages.statuses import ERROR
from dcrb_ros.messages.topics.diagnosis import LEVELS
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.viewer.content import Series, TimedWaveform, Times, Verdict

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.parameters import DetectorParameters

HIGHEST_ORDER = 31.0
"""Highest order shown: four harmonics of BPFO and three of BPFI of the default bearing, and lines of FTF that can be distinguished [-]."""
ORDER_STEP = 0.025
"""Spacing of the orders shown [-]."""
FINE_ORDERS = 2
"""Number of orders evaluated for each order shown, of which the largest level is taken so that no line is missed [-]."""
SHORTEST_HOP, SHORTEST_WINDOW = 0.25, 0.5
"""Shortest time between two spectra, and shortest window [s]."""
SPECTRA_WANTED = 20
"""Number of spectra of a recording [-]; a long recording has more, from consecutive windows without overlap."""


@dataclass(frozen=True)
class Spectra:
    """Squared envelope spectra over time, as levels over the background."""

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


def diagnoses(
    waveform: TimedWaveform,
    orders: Orders,
    temperatures: TemperatureReadings | None = None,
    heat_time_lapse: float = 1.0,
    bearing: Bearing | None = None,
) -> list[Diagnosis]:
    """Return the diagnoses of the waveform, and of ``temperatures``, by the shipped detector; a short waveform is a single window.

    Its parameters are the default ones, but for the ``heat_time_lapse`` of the bench [-]. As by `dcrb_ros.detect`, it has the geometry of
    the ``bearing``, if there is one, and a short signal on which it gives no verdict is judged again.
    """
    from dcrb_ros.diagnosis.detection import SHORT, brief
    from dcrb_ros.diagnosis.parameters import DetectorParameters

    usual = DetectorParameters()
    seconds = len(waveform.time_ns) / waveform.rate
    window = min(usual.window, seconds)
    if window < SHORTEST_WINDOW:
        return []
    hop = min(window, max(SHORTEST_HOP, seconds / SPECTRA_WANTED))
    parameters = usual.model_copy(update={"window": window, "hop": hop, "heat_time_lapse": heat_time_lapse})
    readings = temperatures or TemperatureReadings.none()
    judgements = _judgements(waveform, orders, readings, parameters, bearing)
    if seconds >= SHORT and all(diagnosis.verdict == "waiting" for diagnosis in judgements):
        judgements = _judgements(waveform, orders, readings, brief(parameters), bearing)
    return judgements


def _judgements(
    waveform: TimedWaveform, orders: Orders, readings: TemperatureReadings, parameters: DetectorParameters, bearing: Bearing | None
) -> list[Diagnosis]:
    """Return the diagnoses of the waveform by a detector with these parameters."""
    from dcrb_ros.diagnosis.thermal_detector import TemperatureFeed, ThermalFaultDetector

    detector, feed, judgements = ThermalFaultDetector(orders, waveform.rate, parameters), TemperatureFeed(readings), []
    detector.take_bearing(bearing)
    for piece in pieces(waveform, round(parameters.hop * waveform.rate)):
        index = index_at(int(waveform.time_ns[piece.start]), waveform.rate)
        diagnosis = detector.update(index, waveform.acceleration[piece], waveform.shaft_angle[piece])
        feed.give(detector.take_temperature, 1e-9 * float(waveform.time_ns[piece.stop - 1]))
        if diagnosis is not None:
            judgements.append(diagnosis)
    return judgements


def pieces(waveform: TimedWaveform, length: int) -> Iterator[slice]:
    """Yield slices of at most ``length`` samples that do not span gaps in the waveform."""
    steps = np.diff(waveform.time_ns)
    gaps = np.flatnonzero((steps > 1_500_000_000 // waveform.rate) | (steps <= 0)) + 1
    borders = [0, *gaps.tolist(), len(waveform.time_ns)]
    for first, last in pairwise(borders):
        for start in range(first, last, length):
            yield slice(start, min(start + length, last))


def spectra_in(messages: Iterable[bytes]) -> tuple[Diagnosis, ...]:
    """Return the envelope spectra in messages as diagnoses without a verdict."""
    decoded = (decode_spectrum(data) for data in messages)
    return tuple(
        Diagnosis(0, time_ns * 1e-9, "waiting", "", shaft_frequency=frequency, spectrum=(orders, amplitude))
        for time_ns, orders, amplitude, frequency in decoded
    )


def envelope_spectra(judgements: Sequence[Diagnosis]) -> Spectra | None:
    """Return the spectra of the diagnoses interpolated to common orders; ``None`` if no diagnosis has one that reaches a shown order."""
    seen = [diagnosis for diagnosis in judgements if len(diagnosis.spectrum[0]) and diagnosis.spectrum[0][-1] >= ORDER_STEP]
    if not seen:
        return None
    count = int(min(HIGHEST_ORDER, *(diagnosis.spectrum[0][-1] for diagnosis in seen)) / ORDER_STEP)
    fine = np.arange(1, FINE_ORDERS * count + 1, dtype=np.float64) * (ORDER_STEP / FINE_ORDERS)
    amplitude: Floats = np.array([np.interp(fine, *diagnosis.spectrum) for diagnosis in seen])
    return Spectra(
        time_ns=np.array([round(diagnosis.time * 1e9) for diagnosis in seen], np.int64),
        orders=fine[FINE_ORDERS - 1 :: FINE_ORDERS],
        level=over_background(amplitude.reshape(len(seen), count, FINE_ORDERS).max(axis=2)),
        shaft_frequency=np.array([diagnosis.shaft_frequency for diagnosis in seen]),
    )


def over_background(amplitude: Floats) -> Floats:
    """Return the level of each amplitude over the median within one order to either side, shape (windows, orders) [dB]."""
    from scipy.ndimage import median_filter

    # Row by row: scipy's filter is ten times slower on a two-dimensional array.
    floor = np.array([median_filter(row, size=2 * round(1.0 / ORDER_STEP) + 1, mode="nearest") for row in amplitude])
    smallest = np.finfo(np.float64).tiny
    return np.asarray(20.0 * np.log10(np.maximum(amplitude, smallest) / np.maximum(floor, smallest)), np.float64)


def indicators_of(judgements: Sequence[Diagnosis]) -> Series | None:
    """Return the levels at the fault orders over time [dB]."""
    seen = [diagnosis for diagnosis in judgements if len(diagnosis.spectrum[0])]
    if not seen:
        return None
    names = tuple(seen[0].levels)
    times = np.array([round(diagnosis.time * 1e9) for diagnosis in seen], np.int64)
    return Series(times, names, np.array([[diagnosis.levels[name] for name in names] for diagnosis in seen]))


def verdicts_of(judgements: Sequence[Diagnosis]) -> tuple[Verdict, ...]:
    """Return the verdicts of the diagnoses."""
    return tuple(Verdict(d.time_ns, d.verdict, LEVELS.get(d.verdict, ERROR), {"reason": d.reason}, d.scores) for d in judgements)
