"""Quantities derived from a run, as pure functions of arrays."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import signal

from dcrb_ros.schema.arrays import Floats

Array = npt.NDArray[np.floating]

LOADED_FORCE = 50.0
"""Normal force above which a roller counts as loaded [N]."""

FLOOR_SPAN = 8.0
"""Distance from a line within which the median of the spectrum is taken as its floor [Hz]."""


def decibels(ratio: float) -> float:
    """Return a ratio of amplitudes in decibels [dB]."""
    return 20.0 * math.log10(max(ratio, 1e-12))


@dataclass(frozen=True)
class Spectrum:
    """An amplitude spectrum, both arrays of shape (frequencies,)."""

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
        frequency = self.largest(near - width, near + width)
        floor = np.median(self.amplitude[np.abs(self.frequency - frequency) < FLOOR_SPAN])
        return Line(frequency, float(self.amplitude[np.argmin(np.abs(self.frequency - frequency))]), float(floor))


@dataclass(frozen=True)
class Line:
    """A line of a spectrum."""

    frequency: float
    """[Hz]"""
    amplitude: float
    """[m/s^2]"""
    floor: float
    """Median amplitude around it [m/s^2]."""

    @property
    def level(self) -> float:
        """Level above its floor [dB]."""
        return decibels(self.amplitude / self.floor)


def envelope_spectrum(acceleration: Floats, rate: int) -> Spectrum:
    """Return the envelope spectrum of the whole band of a signal of shape (samples,), as in the paper's Fig. 11."""
    envelope = np.abs(signal.hilbert(signal.detrend(acceleration)))
    window = signal.windows.hann(len(envelope))
    amplitude = np.asarray(np.abs(np.fft.rfft((envelope - envelope.mean()) * window)) * 2.0 / window.sum(), np.float64)
    return Spectrum(np.asarray(np.fft.rfftfreq(len(envelope), 1.0 / rate), np.float64), amplitude)


def settling_time(time: Floats, speed: Array, tolerance: float) -> float:
    """Return the last time at which a speed deviates from its final value by more than ``tolerance`` (relative) [s].

    The final value is the mean over the last fifth of the run.
    """
    final = speed[-len(speed) // 5 :].mean()
    outside = np.flatnonzero(np.abs(speed / final - 1.0) > tolerance)
    return float(time[outside[-1]]) if len(outside) else 0.0


@dataclass(frozen=True)
class LoadZone:
    """The load zone over many passes of a roller; azimuths are measured from the load line."""

    entry: float
    """Mean azimuth at which rollers become loaded [deg]."""
    exit: float
    """Mean azimuth at which rollers become unloaded [deg]."""
    first: float
    """Smallest entry of all passes [deg]."""
    last: float
    """Largest exit of all passes [deg]."""

    @property
    def asymmetry(self) -> float:
        """Twice the distance of the zone's middle from the load line [deg]."""
        return abs(self.entry + self.exit)


PASS_LIMIT = 60.0
"""Azimuth range, to either side of the load line, of a pass [deg]."""


def load_zone(azimuth: Array, force: Array) -> LoadZone:
    """Return the load zone, in which rollers carry more than `LOADED_FORCE`; shapes (times, rollers) [rad], [N].

    Only complete passes are counted.
    """
    ends = []
    for degrees, loaded in zip(np.degrees(azimuth).T, force.T > LOADED_FORCE, strict=True):
        zones = (degrees[stretch][loaded[stretch]] for stretch in passes(np.abs(degrees) < PASS_LIMIT))
        ends += [(float(zone.min()), float(zone.max())) for zone in zones if len(zone)]
    entries, exits = np.array(ends).reshape(-1, 2).T
    return LoadZone(*(float(value) for value in (entries.mean(), exits.mean(), entries.min(), exits.max())))


def passes(inside: npt.NDArray[np.bool_]) -> Iterator[slice]:
    """Yield the complete stretches in which a roller is ``inside`` a range of azimuth, shape (times,)."""
    starts, stops = np.flatnonzero(~inside[:-1] & inside[1:]) + 1, np.flatnonzero(inside[:-1] & ~inside[1:]) + 1
    for start in starts:
        later = stops[stops > start]
        if len(later):
            yield slice(start, later[0])


def profile(azimuth: Array, force: Array, edges: Floats) -> Floats:
    """Return the mean of a quantity in the azimuth bins between ``edges`` [rad]; NaN in empty bins."""
    where = np.digitize(azimuth.ravel(), edges)
    total = np.bincount(where, weights=force.ravel(), minlength=len(edges) + 1)[1:-1]
    count = np.bincount(where, minlength=len(edges) + 1)[1:-1]
    return np.asarray(np.divide(total, count, out=np.full(len(count), np.nan), where=count > 0))
