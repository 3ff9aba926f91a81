"""Numbers read off a run, as pure functions of arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import signal

Floats = npt.NDArray[np.float64]
Array = npt.NDArray[np.floating]

LEAST_FORCE = 50.0
"""Force from which a roller counts as loaded [N]."""

FLOOR_SPAN = 8.0
"""Reach of the stretch round a line whose median is its floor [Hz]."""


def decibels(ratio: float) -> float:
    """Return a ratio of amplitudes [dB]."""
    return 20.0 * math.log10(max(ratio, 1e-12))


@dataclass(frozen=True)
class Spectrum:
    """Amplitudes over frequency."""

    frequency: Floats
    """[Hz]"""
    amplitude: Floats
    """[m/s^2]"""

    def largest(self, low: float, high: float) -> float:
        """Return the frequency of the largest line between two frequencies [Hz]."""
        inside = np.flatnonzero((self.frequency >= low) & (self.frequency <= high))
        return float(self.frequency[inside[self.amplitude[inside].argmax()]])

    def line(self, near: float, width: float) -> Line:
        """Return the largest line within ``width`` of ``near`` [Hz]."""
        found = self.largest(near - width, near + width)
        floor = np.median(self.amplitude[np.abs(self.frequency - found) < FLOOR_SPAN])
        return Line(found, float(self.amplitude[np.argmin(np.abs(self.frequency - found))]), float(floor))


@dataclass(frozen=True)
class Line:
    """A line of a spectrum."""

    frequency: float
    """[Hz]"""
    amplitude: float
    """[m/s^2]"""
    floor: float
    """Median amplitude round it [m/s^2]."""

    @property
    def level(self) -> float:
        """Level over its floor [dB]."""
        return decibels(self.amplitude / self.floor)


def envelope_spectrum(acceleration: Floats, rate: int) -> Spectrum:
    """Return the spectrum of the envelope of the raw signal, shape (samples,), as in the paper's Fig. 11."""
    envelope = np.abs(signal.hilbert(signal.detrend(acceleration)))
    window = signal.windows.hann(len(envelope))
    amplitude = np.asarray(np.abs(np.fft.rfft((envelope - envelope.mean()) * window)) * 2.0 / window.sum(), np.float64)
    return Spectrum(np.asarray(np.fft.rfftfreq(len(envelope), 1.0 / rate), np.float64), amplitude)


def kurtosis(acceleration: Floats) -> float:
    """Return the kurtosis [-]; 3 for noise."""
    deviation = acceleration - acceleration.mean()
    return float((deviation**4).mean() / (deviation**2).mean() ** 2)


def settling_time(time: Floats, speed: Array, tolerance: float) -> float:
    """Return when a speed is last outside ``tolerance`` of its mean over the last fifth [s]."""
    final = speed[-len(speed) // 5 :].mean()
    outside = np.flatnonzero(np.abs(speed / final - 1.0) > tolerance)
    return float(time[outside[-1]]) if len(outside) else 0.0


@dataclass(frozen=True)
class Zone:
    """Where rollers are loaded, over many passes; azimuths from the load line."""

    entry: float
    """Mean over the passes [deg]."""
    exit: float
    """[deg]"""
    entry_spread: float
    """Standard deviation [deg]."""
    exit_spread: float
    first: float
    """Smallest of all passes [deg]."""
    last: float
    """Largest of all passes [deg]."""

    @property
    def asymmetry(self) -> float:
        """How far the zone's middle is off the load line, twice [deg]."""
        return abs(self.entry + self.exit)


LOOKED_AT = 60.0
"""Azimuths within this make a pass [deg]."""


def loading_zone(azimuth: Array, force: Array) -> Zone:
    """Return the zone in which the rollers of the columns bear more than `LEAST_FORCE`, shapes (times, rollers) [rad], [N].

    A pass counts when it was seen from end to end.
    """
    ends = [pass_ends for column in range(azimuth.shape[1]) for pass_ends in _passes(np.degrees(azimuth[:, column]), force[:, column])]
    entries, exits = np.array(ends).reshape(-1, 2).T
    return Zone(*(float(value) for value in (entries.mean(), exits.mean(), entries.std(), exits.std(), entries.min(), exits.max())))


def _passes(azimuth: Array, force: Array) -> list[tuple[float, float]]:
    inside = np.abs(azimuth) < LOOKED_AT
    starts, stops = np.flatnonzero(~inside[:-1] & inside[1:]) + 1, np.flatnonzero(inside[:-1] & ~inside[1:]) + 1
    found = []
    for start in starts:
        later = stops[stops > start]
        loaded = azimuth[start : later[0]][force[start : later[0]] > LEAST_FORCE] if len(later) else azimuth[:0]
        if len(loaded):
            found.append((float(loaded.min()), float(loaded.max())))
    return found


def profile(azimuth: Array, force: Array, edges: Floats) -> Floats:
    """Return the mean of a quantity over azimuth bins of ``edges`` [rad]; NaN where nothing fell."""
    where = np.digitize(azimuth.ravel(), edges)
    total = np.bincount(where, weights=force.ravel(), minlength=len(edges) + 1)[1:-1]
    count = np.bincount(where, minlength=len(edges) + 1)[1:-1]
    return np.asarray(np.divide(total, count, out=np.full(len(count), np.nan), where=count > 0))
