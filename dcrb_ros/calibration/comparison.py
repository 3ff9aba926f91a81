"""Distances between two recordings: levels in third octaves, squared envelope spectra, kurtosis by band, features."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from dcrb_ros.bearing.waveform import Signal, Waveform
from dcrb_ros.calibration.healthy_recording import longest_stretch, unit_of
from dcrb_ros.calibration.spectra import power_density, third_octaves
from dcrb_ros.diagnosis.demodulation import NYQUIST_SHARE
from dcrb_ros.diagnosis.features.envelope_lines import WIDE, envelope_order_spectrum
from dcrb_ros.diagnosis.features.extraction import extract_features
from dcrb_ros.diagnosis.order_tracking import LEAST_TURNS, forward_turns, unwrapped_turns
from dcrb_ros.schema.arguments import checked_arguments, texts
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

LEAST = 0.5
"""Shortest signal that is compared [s]."""
LEAST_RATE = 71
"""Lowest sampling rate at which a third octave is below half of it [Hz]."""
HIGHEST_ORDER = 24.0
"""Orders up to which envelope spectra are compared [-]."""
ORDER_STEP = 0.05
"""Resolution of the compared envelope spectra [orders]."""
FAMILIES = ("statistics", "band_levels", "kurtogram", "envelope_lines", "cepstrum")
"""Families of features that are compared."""
WINDOW = 1.0
"""Window of the features [s]."""
STEPS = 4
"""Steps of a comparison that report progress [-]: reading, two axes, features."""


@dataclass(frozen=True, eq=False)
class AxisComparison:
    """Two recordings in one axis; the second relative to the first."""

    axis: str
    frequency: Floats
    """Middles of the third octaves that both have, shape (bands,) [Hz]."""
    levels: tuple[Floats, Floats]
    """Levels over 1 (m/s^2)^2 in them [dB]."""
    octaves: Floats
    """Middles of the octaves, shape (octaves,), empty below a sampling rate of 393 Hz [Hz]."""
    kurtosis: tuple[Floats, Floats]
    """Kurtosis in each octave, 3 for noise, NaN without a signal [-]."""
    orders: Floats
    """Orders of the envelope spectra, empty without a speed [-]."""
    envelopes: tuple[Floats, Floats]
    """Amplitude of the squared envelope from 0.04 to 0.4 of the lower sampling rate over its mean [-]."""

    @property
    def difference(self) -> Floats:
        """Level of the second over the first in third octaves, shape (bands,) [dB]."""
        return np.asarray(self.levels[1] - self.levels[0], np.float64)

    @property
    def level_distance(self) -> float:
        """Root mean square of `difference` [dB]."""
        return float(np.sqrt(np.mean(self.difference**2)))

    @property
    def shape_distance(self) -> float:
        """The same without the mean difference, which is one of gains [dB]."""
        return float(np.std(self.difference))

    @property
    def envelope_distance(self) -> float:
        """Distance of the envelope spectra over their own size, 0 for equal ones, 1 for ones without a common line; NaN without a speed."""
        if not len(self.orders):
            return math.nan
        first, two = self.envelopes
        return float(np.sqrt(np.sum((first - two) ** 2) / np.sum(first**2 + two**2)))

    @property
    def kurtosis_distance(self) -> float:
        """Root mean square over the octaves of the difference of the logarithms of the kurtosis [-].

        Octaves without a signal in either recording are left out; NaN if none is left.
        """
        ratio = self.kurtosis[1] / self.kurtosis[0]
        ratio = ratio[np.isfinite(ratio)]
        return float(np.sqrt(np.mean(np.log(ratio) ** 2))) if len(ratio) else math.nan


@dataclass(frozen=True, eq=False, repr=False)
class RecordingComparison:
    """Distances between two recordings: spectra, kurtosis and features."""

    names: tuple[str, str]
    axes: tuple[AxisComparison, ...]
    features: dict[str, tuple[float, float]]
    """Median of each feature over windows of a second in either recording, by its name; empty without a speed."""
    remarks: tuple[str, ...]

    def __repr__(self) -> str:
        parts = [f"{axis.axis} {axis.level_distance:.1f} dB" for axis in self.axes]
        return f"<RecordingComparison of {self.names[0]} and {self.names[1]}: {', '.join(parts)} apart in third octaves>"

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers, lists and texts, for JSON; unknown values are None."""
        return {
            "recordings": list(self.names),
            "axes": {axis.axis: _as_dict(axis) for axis in self.axes},
            "features": {name: [_number(value) for value in values] for name, values in self.features.items()},
            "remarks": list(self.remarks),
        }


def _as_dict(axis: AxisComparison) -> dict[str, Any]:
    return {
        "level_distance_db": axis.level_distance,
        "shape_distance_db": axis.shape_distance,
        "envelope_distance": _number(axis.envelope_distance),
        "kurtosis_distance": _number(axis.kurtosis_distance),
        "third_octaves_hz": axis.frequency.round(2).tolist(),
        "levels_db": [levels.round(3).tolist() for levels in axis.levels],
        "octaves_hz": axis.octaves.round(2).tolist(),
        "kurtosis": [values.round(4).tolist() for values in axis.kurtosis],
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


@checked_arguments(names=texts)
def compare(
    first: Signal, second: Signal, *, names: tuple[str, str] = ("A", "B"), progress: Callable[[str], None] = lambda step: None
) -> RecordingComparison:
    """Return the distances between two recordings, of any rates, speeds and bearings.

    Parameters
    ----------
    first, second
        A `Recording`, `SimulationResult` or `Waveform` each.
    names
        Their names.
    progress
        Called with the description of each of the `STEPS` steps, or one less with one axis, as it begins.

    Returns
    -------
    RecordingComparison
        By axis the levels in third octaves, the kurtosis by octave and the squared envelope spectra with their distances; the features.

    Raises
    ------
    Refusal
        A recording that is empty, constant, shorter than half a second or sampled below 71 Hz; other than two names.

    Examples
    --------
    >>> import dcrb_ros
    >>> healthy, faulty = dcrb_ros.simulate("healthy", 2.0), dcrb_ros.simulate("outer_ring_defect", 2.0)
    >>> dcrb_ros.compare(healthy, faulty).axes[1].level_distance > 5.0
    True
    """
    if isinstance(names, str) or len(names) != 2:
        raise Refusal(f"names = {names!r} are not those of two recordings: give a pair such as ('A', 'B')")
    progress("reading the recordings")
    waveforms = [_checked(signal, name) for signal, name in zip((first, second), names, strict=True)]
    single = any(np.array_equal(waveform.acceleration[:, 0], waveform.acceleration[:, 1]) for waveform in waveforms)
    remarks = []
    if single:
        remarks.append("a recording has one axis: Y of the other one is compared with it")
    if not all(waveform.tracked for waveform in waveforms):
        remarks.append("a recording has no speed: envelope spectra over orders, fault lines and features are left out")
    if "relative" in (unit_of(first), unit_of(second)):
        remarks.append("a recording has relative units: its levels can be compared only without their mean")
    rates = {waveform.sampling_rate for waveform in waveforms}
    if len(rates) > 1:
        remarks.append(f"the sampling rates are {' and '.join(map(str, sorted(rates)))} Hz: only bands that both have are compared")
    axes = []
    for axis in ("y",) if single else ("x", "y"):
        progress(f"comparing axis {axis}")
        axes.append(_axis(waveforms, axis))
    progress("comparing features")
    features = _features(waveforms, remarks)
    return RecordingComparison((names[0], names[1]), tuple(axes), features, tuple(remarks))


def _checked(signal: Signal, name: str) -> Waveform:
    if not isinstance(signal, Signal):
        raise Refusal(f"{name} is not a recording: give a Recording, a SimulationResult or a Waveform")
    waveform = longest_stretch(signal.waveform())
    if waveform.duration < LEAST:
        raise Refusal(f"{name} is too short to be compared: {waveform.duration:.3g} s without a gap, and {LEAST:g} s are needed")
    if waveform.sampling_rate < LEAST_RATE:
        rate = waveform.sampling_rate
        raise Refusal(f"{name} has a sampling rate of {rate} Hz, and third octaves need {LEAST_RATE} Hz: give one with a higher rate")
    if not np.isfinite(waveform.acceleration).all() or np.ptp(waveform.acceleration, axis=0).min() == 0.0:
        raise Refusal(f"{name} is empty: an axis is constant or has samples that are not numbers")
    return waveform


def _axis(waveforms: list[Waveform], axis: str) -> AxisComparison:
    column = "xy".index(axis)
    signals = [
        waveform.acceleration[:, column].astype(np.float64) - float(waveform.acceleration[:, column].mean()) for waveform in waveforms
    ]
    rates = [waveform.sampling_rate for waveform in waveforms]
    bands = [third_octaves(power_density(signal, rate), rate) for signal, rate in zip(signals, rates, strict=True)]
    common = min(len(bands[0][0]), len(bands[1][0]))
    kurtoses = [octave_kurtosis(signal, rate) for signal, rate in zip(signals, rates, strict=True)]
    octaves = min(len(kurtoses[0][0]), len(kurtoses[1][0]))
    orders, envelopes = _envelopes(waveforms, signals)
    return AxisComparison(
        axis,
        bands[0][0][:common],
        (bands[0][1][:common], bands[1][1][:common]),
        kurtoses[0][0][:octaves],
        (kurtoses[0][1][:octaves], kurtoses[1][1][:octaves]),
        orders,
        envelopes,
    )


def octave_kurtosis(signal: Floats, rate: int) -> tuple[Floats, Floats]:
    """Return the middles of the octaves from 125 Hz [Hz] and the kurtosis in each, NaN without a signal, shapes (octaves,) [-]."""
    from scipy.signal import butter, sosfilt

    middles, values = [], []
    middle, least = 125.0, np.finfo(np.float64).eps ** 2 * float(np.mean(signal**2))  # of rounding
    while middle * math.sqrt(2.0) <= NYQUIST_SHARE * rate:
        edges = [middle / math.sqrt(2.0), middle * math.sqrt(2.0)]
        filtered = sosfilt(butter(3, edges, "bandpass", fs=rate, output="sos"), signal)[rate // 20 :]
        power = filtered**2
        middles.append(middle)
        mean = float(np.mean(power))
        values.append(float(np.mean((power / mean) ** 2)) if mean > least else math.nan)
        middle *= 2.0
    return np.array(middles), np.array(values)


def _envelopes(waveforms: list[Waveform], signals: list[Floats]) -> tuple[Floats, tuple[Floats, Floats]]:
    """Return squared envelope spectra on the same orders."""
    nothing = np.zeros(0)
    if not all(waveform.tracked for waveform in waveforms):
        return nothing, (nothing, nothing)
    lowest = min(waveform.sampling_rate for waveform in waveforms)
    orders, envelopes = np.arange(ORDER_STEP, HIGHEST_ORDER, ORDER_STEP), []
    for waveform, signal in zip(waveforms, signals, strict=True):
        forward = forward_turns(unwrapped_turns(waveform.shaft_angle))
        if forward[-1] < LEAST_TURNS:
            return nothing, (nothing, nothing)
        spectrum = envelope_order_spectrum(signal, forward, waveform.sampling_rate, WIDE[0] * lowest, WIDE[1] * lowest)
        # Recordings of different lengths have lines of different widths; the largest amplitude in a cell is that of its line.
        cells = np.searchsorted(spectrum.orders, np.append(orders - 0.5 * ORDER_STEP, orders[-1] + 0.5 * ORDER_STEP))
        amplitude = np.array([float(spectrum.amplitude[begin : max(end, begin + 1)].max()) for begin, end in pairwise(cells)])
        envelopes.append(amplitude / max(spectrum.mean, np.finfo(np.float64).tiny))
    return orders, (envelopes[0], envelopes[1])


def _features(waveforms: list[Waveform], remarks: list[str]) -> dict[str, tuple[float, float]]:
    """Return the median of each feature that both have."""
    if not all(waveform.tracked for waveform in waveforms):
        return {}
    if any(math.isnan(waveform.orders.bpfo) for waveform in waveforms):
        remarks.append("a recording has no bearing: fault lines and features are left out")
        return {}
    try:
        tables = [extract_features(waveform, window=WINDOW, hop=WINDOW, families=FAMILIES) for waveform in waveforms]
    except Refusal as refusal:
        remarks.append(f"features are left out: {refusal}")
        return {}
    medians = [dict(zip(table.names, np.median(table.values, axis=0).tolist(), strict=True)) for table in tables]
    return {name: (medians[0][name], medians[1][name]) for name in tables[0].names if name in medians[1]}
