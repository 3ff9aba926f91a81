"""Statistics that measured bearings have in common, computed alike from simulated and measured signals."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import fft

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.demodulation import NYQUIST_SHARE, Band, Demodulator
from dcrb_ros.diagnosis.envelope_spectrum import DEFAULT_BAND
from dcrb_ros.schema.arrays import Floats

LARGEST_DEPARTURE = 0.022
"""Departure of BPFO from its kinematic order within which it is sought [-]: 2 % were measured, and the slip of a film is less."""
FITTED_HARMONICS = np.array([1.0, 2.0, 3.0])
CAGE_LINES = np.arange(1.0, 7.0)
"""Harmonics of FTF up to nearly BPFO of a bearing with eight balls."""
WINDOW, HOP = 0.5, 0.125
"""Length and distance of the windows in which BPFO is followed [s]."""
HIGH_PERCENTILE = 99.5
RESOLUTION = np.arange(-2, 3)
"""Bins within the resolution of a line, in a spectrum padded to twice its length."""
LOW = 200.0
"""Frequency below which a machine's own motion lies [Hz]."""


class Statistics(NamedTuple):
    """Quantities of one axis that are compared between simulated and measured signals."""

    rms: float
    """Standard deviation, in the signal's unit."""
    peak: float
    """Largest magnitude about the mean, in the signal's unit."""
    kurtosis: float
    """Fourth moment over the square of the second [-]: 3 for noise."""
    bpfo_depth: float
    """Amplitude of the line at BPFO over the mean squared envelope [-]."""
    cage_depth: float
    """The same, median of the harmonics of FTF below BPFO."""
    sidebands: float
    """Mean amplitude of the lines one shaft frequency beside BPFO over that of BPFO [-]."""
    departure: float
    """Relative departure of BPFO from its kinematic order [-]."""
    wander: float
    """Relative standard deviation of BPFO between windows of half a second [-]."""
    crest: float
    """Level of the 99.5th percentile of the envelope over its median [dB]."""
    harmonics: tuple[float, float]
    """Depths of the first and the eighth harmonic of BPFO [-]."""
    low: float
    """Power below 200 Hz over all power [dB]."""


class Lines(NamedTuple):
    """The spectrum of a squared envelope."""

    spacing: float
    """[Hz]"""
    depth: Floats
    """Amplitudes over the mean [-]."""

    def at(self, frequency: npt.ArrayLike) -> Floats:
        """Return the largest depth within the resolution at frequencies [Hz]; shape of ``frequency``."""
        middle = np.rint(np.asarray(frequency) / self.spacing).astype(np.int64)
        return np.asarray(self.depth[np.clip(middle[..., None] + RESOLUTION, 0, len(self.depth) - 1)].max(axis=-1), np.float64)

    def fitted(self, frequency: float) -> float:
        """Return the frequency [Hz] near a given one whose first harmonics have the largest product."""
        tried = frequency * (1.0 + LARGEST_DEPARTURE * np.linspace(-1.0, 1.0, 441))
        axis = self.spacing * np.arange(len(self.depth))
        depths = np.interp(np.multiply.outer(FITTED_HARMONICS, tried), axis, self.depth)
        return float(tried[np.argmax(np.log(np.maximum(depths, 1e-12)).sum(axis=0))])


def wide_band(rate: float) -> Band:
    """Return the band from 2 to 20 kHz, or to 0.45 of the sampling rate [Hz] if that is less."""
    return Band(DEFAULT_BAND[0], min(DEFAULT_BAND[1], NYQUIST_SHARE * rate))


def squared_envelope(signal: Floats, rate: float, band: Band | None = None) -> tuple[Floats, float]:
    """Return the squared envelope of a band, by default `wide_band`, and its own sampling rate [Hz]."""
    band = wide_band(rate) if band is None else band
    ((positions, squared),) = Demodulator((band,), round(rate), len(signal)).squared_envelopes(signal[:, None])
    return squared[positions < len(signal)], rate / float(positions[1])  # without the zeros behind the signal


def lines_of(squared: Floats, rate: float) -> Lines:
    """Return the lines of a squared envelope at a rate [Hz], with a Hann window and zero-padding to twice the length."""
    length, window = 2 * len(squared), np.hanning(len(squared))
    mean = float(squared.mean())
    amplitude = np.abs(fft.rfft((squared - mean) * window, length)) * (2.0 / float(window.sum()) / max(mean, 1e-30))
    return Lines(rate / length, np.asarray(amplitude, np.float64))


def wander(squared: Floats, rate: float, frequency: float) -> float:
    """Return the relative standard deviation [-] of the frequency of a line between windows, from the turn of its phase.

    The second harmonic counts if it is stronger than the first, as with two rows half a pitch apart.
    """
    lines = lines_of(squared, rate)
    order = 1.0 if lines.at(frequency) >= lines.at(2.0 * frequency) else 2.0
    count, hop = round(WINDOW * rate), round(HOP * rate)
    turning = np.exp(-2j * np.pi * order * frequency / rate * np.arange(len(squared)))
    carrier, window = (squared - squared.mean()) * turning, np.hanning(count)
    starts = range(0, len(squared) - count + 1, hop)
    if len(starts) < 3:
        return float("nan")
    phases = np.unwrap([np.angle((carrier[start : start + count] * window).sum()) for start in starts])
    return float(np.std(np.diff(phases)) / (2.0 * np.pi * order * frequency * hop / rate))


def statistics(
    signal: npt.NDArray[np.floating], rate: float, shaft_frequency: float, orders: Orders, order: float | None = None
) -> Statistics:
    """Return the statistics of one axis, shape (samples,), at a sampling rate and a shaft frequency [Hz].

    The lines are those of BPFO, or of another kinematic ``order`` [-], as BPFI of a defect of the inner ring.
    """
    order = orders.bpfo if order is None else order
    values = np.asarray(signal, np.float64) - float(np.mean(signal))
    power = float((values**2).mean())
    squared, its_rate = squared_envelope(values, rate)
    lines = lines_of(squared, its_rate)
    bpfo = lines.fitted(order * shaft_frequency)
    depth = float(lines.at(bpfo))
    ftf = bpfo * orders.ftf / order
    beside = lines.at(np.array([bpfo - shaft_frequency, bpfo + shaft_frequency]))
    spectrum = np.abs(fft.rfft(values * np.hanning(len(values)))) ** 2
    below = spectrum[: round(LOW * len(values) / rate)].sum() / spectrum.sum()
    return Statistics(
        rms=power**0.5,
        peak=float(np.abs(values).max()),
        kurtosis=float((values**4).mean()) / power**2,
        bpfo_depth=depth,
        cage_depth=float(np.median(lines.at(CAGE_LINES * ftf))),
        sidebands=float(beside.mean()) / max(depth, 1e-12),
        departure=bpfo / (order * shaft_frequency) - 1.0,
        wander=wander(squared, its_rate, bpfo),
        crest=10.0 * float(np.log10(np.percentile(squared, HIGH_PERCENTILE) / np.median(squared))),
        harmonics=(depth, float(lines.at(8.0 * bpfo))),
        low=10.0 * float(np.log10(max(below, 1e-12))),
    )
