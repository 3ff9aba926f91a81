"""Wheels and track, as one axle box hears them: the squared envelope of the band in which impacts between wheel and rail ring.

A flat strikes once in a turn, at one angle of its wheel. A kink of the rail meets one wheel after the other, and no angle. The median of
the turns at each angle shows the flat, and an impact above the median of the time shows the kink.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.demodulation import Band, Demodulator
from dcrb_ros.diagnosis.segments import Segment, Segmenter
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
AT_THE_FLAT = 0.12
"""Share of a turn on either side of a flat in which impacts are its own [-]."""


@dataclass(frozen=True)
class Impact:
    """An impact that a box heard."""

    time: float
    """[s]"""
    level: float
    """Largest squared envelope over the median [dB]."""
    power: float
    """Largest squared envelope [(m/s^2)^2]."""


@dataclass(frozen=True)
class Contact:
    """What one box heard of wheels and track within the window."""

    end: int
    """Index of the last sample."""
    median: float
    """Median squared envelope [(m/s^2)^2]."""
    peak: float
    """Squared envelope at the angle at which it is largest, in the median of the turns [(m/s^2)^2]; 0 without enough turns."""
    level: float
    """That value over the median around the turn [dB]."""
    angle: float
    """That angle [turns]."""
    turns: float
    """Turns of the shaft within the window [-]; NaN without a shaft angle."""
    seconds: float
    """Length of the window [s]."""
    impacts: Sequence[Impact]

    @property
    def shaft_frequency(self) -> float:
        """Mean within the window, negative backwards [Hz]."""
        return self.turns / self.seconds


class ContactMonitor:
    """Takes the blocks of one box and returns what it heard at the end of each hop."""

    def __init__(self, rate: int, hop: int, hops: int, band: Band, longest_gap: int, event: float) -> None:
        """Prepare for hops of ``hop`` samples at ``rate`` [Hz], of which a window has ``hops``.

        ``event`` is the level of an impact over the median of the envelope [dB].
        """
        self._rate, self._hop, self._event = rate, hop, event
        self._margin = margin_samples(rate, band.low, MARGIN_PERIODS)
        self._segmenter = Segmenter(hop, self._margin, longest_gap)
        self._demodulator = Demodulator((band,), rate, hop + 2 * self._margin)
        self._bins = max(1, round(hop / rate * BIN_RATE))
        self._windows: deque[tuple[Floats, Floats]] = deque(maxlen=hops)
        self._turned = 0.0

    def add(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any] | None) -> list[Contact]:
        """Take a block; return what was heard at the end of each hop that it completes."""
        return [self._heard(segment) for segment in self._segmenter.add(index, acceleration, shaft_angle)]

    def _heard(self, segment: Segment) -> Contact:
        if segment.first:
            self._windows.clear()
            self._turned = 0.0
        positions, values = self._demodulator.squared_envelopes(segment.acceleration)[0]
        middles = self._margin + (np.arange(self._bins) + 0.5) * (self._hop / self._bins)
        edges = self._margin + np.arange(self._bins + 1) * (self._hop / self._bins)
        integral = np.concatenate([[0.0], np.cumsum(values)])
        envelope = np.diff(np.interp(edges, np.append(positions, 2.0 * positions[-1] - positions[-2]), integral)) / np.diff(edges)
        envelope = np.maximum(envelope * (positions[1] - positions[0]), 0.0)
        turns = np.full(self._bins, np.nan)
        if segment.turns is not None:
            turned = np.interp(middles, np.arange(len(segment.turns)), segment.turns)
            turns = turned - segment.turns[self._margin] + self._turned
            self._turned += float(segment.turns[self._margin + self._hop] - segment.turns[self._margin])
        self._windows.append((np.asarray(envelope, np.float64), np.asarray(turns, np.float64)))
        end = segment.last - self._margin
        return self._concluded(segment.last, end)

    def _concluded(self, last: int, end: int) -> Contact:
        envelope = np.concatenate([window[0] for window in self._windows])
        turns = np.concatenate([window[1] for window in self._windows])
        seconds = len(self._windows) * self._hop / self._rate
        times = (end + 1) / self._rate - seconds + (np.arange(len(envelope)) + 0.5) * (seconds / len(envelope))
        median = float(np.median(envelope))
        peak, level, angle = _around(envelope, turns)
        impacts = _impacts(envelope, times, median, self._event)
        turned = float(turns[-1] - turns[0]) * len(turns) / max(len(turns) - 1, 1)
        return Contact(last, median, peak, level, angle, turned, seconds, impacts)

    def lost(self) -> None:
        """Forget the window, because the signal was interrupted."""
        self._windows.clear()


def _around(envelope: npt.NDArray[Any], turns: npt.NDArray[Any]) -> tuple[float, float, float]:
    """Return the peak around the turn of the median over turns, its level over the median around the turn [dB], and its angle [turns]."""
    if not np.isfinite(turns).all() or abs(turns[-1] - turns[0]) < FEWEST_TURNS:
        return 0.0, 0.0, 0.0
    angle = np.floor(np.mod(turns, 1.0) * ANGLES).astype(np.int64) % ANGLES
    order = np.argsort(angle, kind="stable")
    starts = np.searchsorted(angle[order], np.arange(ANGLES + 1))
    parts = [envelope[order[starts[k] : starts[k + 1]]] for k in range(ANGLES)]
    around = np.array([float(np.median(part)) if len(part) else np.nan for part in parts])
    around = np.where(np.isfinite(around), around, np.nanmedian(around))
    largest = int(np.argmax(around))
    peak, middle = float(around[largest]), float(np.median(around))
    return peak, 10.0 * float(np.log10(max(peak, 1e-30) / max(middle, 1e-30))), (largest + 0.5) / ANGLES


def _impacts(envelope: npt.NDArray[Any], times: npt.NDArray[Any], median: float, event: float) -> list[Impact]:
    """Return the impacts above ``event`` [dB] over the median, the largest within each time of ringing."""
    if median <= 0.0:
        return []
    strong = np.flatnonzero(envelope >= median * 10.0 ** (event / 10.0))
    impacts: list[Impact] = []
    for k in strong:
        impact = Impact(float(times[k]), 10.0 * float(np.log10(envelope[k] / median)), float(envelope[k]))
        if impacts and impact.time - impacts[-1].time < RINGING:
            if impact.power > impacts[-1].power:
                impacts[-1] = impact
        else:
            impacts.append(impact)
    return impacts
