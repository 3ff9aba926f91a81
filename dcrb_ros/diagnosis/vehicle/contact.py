"""Wheels and track, as one axle box measures them.

A flat strikes once in a turn, at one angle of its wheel: the median of the turns at each angle shows it. A kink of the rail is rare and at
no fixed angle: it is larger than nearly all of the time. Long waves of the rail reach the trailing wheelset later, as the same waveform.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.demodulation import Band, Demodulator
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum, medians
from dcrb_ros.diagnosis.order_tracking import bin_means
from dcrb_ros.diagnosis.segments import Segment, Segmenter
from dcrb_ros.diagnosis.vehicle.turn_spectrum import TurnSpectrum
from dcrb_ros.diagnosis.window import margin_samples
from dcrb_ros.schema.arrays import Floats

BIN_RATE = 3200
"""Values of the envelope per second, about [Hz]: twice the width of the band."""
ANGLES = 96
"""Angles of a turn [-]."""
FEWEST_TURNS = 6
"""Turns from which the median at an angle is taken [-]."""
MARGIN_PERIODS = 6.0
"""Periods of the lowest frequency on either side of a hop."""
RINGING = 0.03
"""Time after an impact in which it still rings [s]."""
SETTLING = 0.1
"""Time after the start of a signal in which filters settle, and impacts are not counted [s]."""
RARE = 0.98
"""Share of the time in which the envelope is below the level over which impacts are rated [-]."""


@dataclass(frozen=True)
class Impact:
    """An impact that a box measured."""

    time: float
    """[s]"""
    loudness: float
    """Largest squared envelope over the median, which is the noise of the rail on the same path [dB]."""


@dataclass(frozen=True)
class Contact:
    """What one box measured of wheels and track within the window."""

    end: int
    """Index of the last sample."""
    median: float
    """Median squared envelope in the band of the wheels [(m/s^2)^2]."""
    peak: float
    """Squared envelope at the angle at which it is largest, in the median of the turns [(m/s^2)^2]; 0 without enough turns."""
    level: float
    """That value over the median around the turn [dB]."""
    turns: float
    """Turns of the shaft within the window [-]; NaN without a shaft angle."""
    first_turns: float
    """Those of its first half [-]."""
    seconds: float
    """Length of the window [s]."""
    impacts: Sequence[Impact]
    """In the band of the kinks."""
    faintest: float
    """Loudness from which on an impact is counted [dB]."""
    motion: Floats
    """Vertical acceleration, means over equal times, shape (values,) [m/s^2]."""
    spectrum: OrderSpectrum | None
    """That acceleration over orders of the wheelset [m/s^2]; None without a shaft angle or enough turns."""

    @property
    def motion_rate(self) -> float:
        """Values of the motion per second [Hz]."""
        return len(self.motion) / self.seconds

    @property
    def shaft_frequency(self) -> float:
        """Mean within the window, negative backwards [Hz]."""
        return self.turns / self.seconds


class ContactMonitor:
    """Takes the blocks of one box and returns what it measured at the end of each hop."""

    def __init__(self, rate: int, hop: int, hops: int, bands: tuple[Band, Band], longest_gap: int, event: float) -> None:
        """Prepare for hops of ``hop`` samples at ``rate`` [Hz], of which a window has ``hops``.

        ``bands`` are those of wheels and kinks, ``event`` is the least level of an impact [dB].
        """
        self._rate, self._hop, self._event = rate, hop, event
        self._margin = margin_samples(rate, bands[0].low, MARGIN_PERIODS)
        self._segmenter = Segmenter(hop, self._margin, longest_gap)
        self._demodulator = Demodulator(bands, rate, hop + 2 * self._margin)
        self._bins = max(1, round(hop / rate * BIN_RATE))
        self._hops: deque[tuple[Floats, Floats, Floats, Floats]] = deque(maxlen=hops)
        """Squared envelopes in the bands of wheels and kinks [(m/s^2)^2], turns since the start [-] and vertical acceleration [m/s^2]."""
        self._spectrum = TurnSpectrum(hop, self._margin, hops)
        self._turned = self._began = 0.0

    def align(self, origin: int) -> None:
        """Begin hops as `Segmenter.align`."""
        self._segmenter.align(origin)

    def add(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any] | None) -> list[Contact]:
        """Take a block; return what was measured at the end of each hop that it completes."""
        return [self._measured(segment) for segment in self._segmenter.add(index, acceleration, shaft_angle)]

    def _measured(self, segment: Segment) -> Contact:
        end = segment.last - self._margin
        self._spectrum.add(segment)
        if segment.first:
            self._hops.clear()
            self._turned, self._began = 0.0, (end + 1 - self._hop) / self._rate
        edges = np.asarray(self._margin + np.arange(self._bins + 1) * (self._hop / self._bins), np.float64)
        wheel, kink = (bin_means(at, values, edges) for at, values in self._demodulator.squared_envelopes(segment.acceleration))
        samples = np.arange(len(segment.missing), dtype=np.float64)
        turns = np.full(self._bins, np.nan)
        if segment.turns is not None:
            turns = np.interp(0.5 * (edges[1:] + edges[:-1]), samples, segment.turns) - segment.turns[self._margin] + self._turned
            self._turned += float(segment.turns[self._margin + self._hop] - segment.turns[self._margin])
        vertical = segment.acceleration[:, min(1, segment.acceleration.shape[1] - 1)]
        motion = bin_means(samples, np.asarray(vertical, np.float64), edges[::2] if self._bins % 2 == 0 else edges)
        self._hops.append((wheel, kink, np.asarray(turns, np.float64), motion))
        return self._concluded(segment.last, end)

    def _concluded(self, last: int, end: int) -> Contact:
        wheel, kink, turns, motion = (np.concatenate(parts) for parts in zip(*self._hops, strict=True))
        seconds = len(self._hops) * self._hop / self._rate
        times = (end + 1) / self._rate - seconds + (np.arange(len(kink)) + 0.5) * (seconds / len(kink))
        peak, level = _around(wheel, turns)
        impacts, faintest = impacts_of(kink, times, self._event, self._began + SETTLING)
        turned = float(turns[-1] - turns[0]) * len(turns) / max(len(turns) - 1, 1)
        step = turned / len(turns)
        middle = float(np.interp(0.5 * len(turns) - 0.5, np.arange(len(turns)), turns) - turns[0]) + 0.5 * step
        wave, spectrum = np.asarray(motion, np.float64), self._spectrum.spectrum()
        return Contact(last, float(np.median(wheel)), peak, level, turned, middle, seconds, impacts, faintest, wave, spectrum)


def _around(envelope: npt.NDArray[Any], turns: npt.NDArray[Any]) -> tuple[float, float]:
    """Return the peak around the turn of the median over turns, and its level over the median around the turn [dB]."""
    if not np.isfinite(turns).all() or abs(turns[-1] - turns[0]) < FEWEST_TURNS:
        return 0.0, 0.0
    angle = np.floor(np.mod(turns, 1.0) * ANGLES).astype(np.int64) % ANGLES
    order = np.argsort(angle, kind="stable")
    starts = np.searchsorted(angle[order], np.arange(ANGLES + 1))
    values = envelope[order]
    around = np.array([medians(values[first:last]) if last > first else np.nan for first, last in itertools.pairwise(starts.tolist())])
    known = np.isfinite(around)
    around = around if known.all() else np.where(known, around, medians(around[known]))
    peak, middle = float(around.max()), float(np.median(around))
    return peak, 10.0 * float(np.log10(max(peak, 1e-30) / max(middle, 1e-30)))


def impacts_of(envelope: npt.NDArray[Any], times: npt.NDArray[Any], event: float, begin: float) -> tuple[list[Impact], float]:
    """Return the impacts after a time ``begin`` [s] with at least ``event`` [dB], and the loudness from which on they are counted [dB].

    Of the impacts within a time of ringing, the largest counts.
    """
    usual, noise = float(np.quantile(envelope, RARE)), float(np.median(envelope))
    if noise <= 0.0:
        return [], 0.0
    above = 10.0 * float(np.log10(usual / noise))
    impacts: list[Impact] = []
    for k in np.flatnonzero((envelope >= usual * 10.0 ** (event / 10.0)) & (times >= begin)):
        impact = Impact(float(times[k]), 10.0 * float(np.log10(envelope[k] / usual)) + above)
        if impacts and impact.time - impacts[-1].time < RINGING:
            if impact.loudness > impacts[-1].loudness:
                impacts[-1] = impact
        else:
            impacts.append(impact)
    return impacts, event + above
