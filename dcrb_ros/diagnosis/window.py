"""The sliding window: squared envelopes of the latest hops in every band, over the angle of the shaft."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.demodulation import Demodulator
from dcrb_ros.diagnosis.order_tracking import JITTER, bin_edges, bin_means, reverses
from dcrb_ros.diagnosis.segments import Segment
from dcrb_ros.schema.arrays import Floats

REFERENCE_FREQUENCY = 20.0
"""Shaft frequency to which envelopes are scaled and for which limits are given [Hz]."""
SLOWEST = 0.5
"""Shaft frequency below which envelopes are scaled as at this one [Hz]."""
LARGEST = 1e30
"""Largest squared envelope kept [(m/s^2)^2]: its square must not overflow in single precision sums."""
MOST_BINS = 1 << 20
"""Most bins of a window [-]; the default window has some 14000 at 20 Hz."""


class Hop(NamedTuple):
    """A hop's squared envelopes."""

    envelopes: npt.NDArray[np.float32]
    """Squared envelope of each band in bins of equal angle, scaled to the reference frequency, shape (bands, bins) [(m/s^2)^2]."""
    missing: npt.NDArray[np.bool_]
    """Bins with missing samples, shape (bins,)."""
    turns: float
    """Turns of the shaft, or of a clock if the shaft angle is not known [-]."""

    @property
    def powers(self) -> Floats:
        """Mean squared envelope of each band, shape (bands,) [(m/s^2)^2]."""
        known = self.envelopes[:, ~self.missing]
        return np.asarray(known.mean(axis=1), np.float64) if known.shape[1] else np.zeros(len(self.envelopes))


class Window:
    """The latest hops, up to the length of the window."""

    def __init__(self, demodulator: Demodulator, rate: int, hop: int, margin: int, bins_per_turn: int, hops: int, exponent: float) -> None:
        self._demodulator, self._rate, self._hop, self._margin = demodulator, rate, hop, margin
        self.bins_per_turn, self._exponent = bins_per_turn, exponent
        self._hops: deque[Hop] = deque(maxlen=hops)
        self._turned, self._direction, self._tracked = 0.0, 0, True
        self.reversed = False
        """Whether the shaft changed its direction within the latest hop, which started a new window."""
        self.excessive_bins = 0.0
        """Bins that a window like the latest hop would have, if that is more than `MOST_BINS`; such a hop starts a new window."""

    def __len__(self) -> int:
        return len(self._hops)

    def clear(self) -> None:
        """Remove all hops."""
        self._hops.clear()
        self._direction = 0

    def add(self, segment: Segment, clock: float, *, useless: bool) -> Hop | None:
        """Take a segment and return its hop, or none if the shaft changed its direction or turned through more than `MOST_BINS`.

        Without a shaft angle, the turns are those of a ``clock`` [Hz]. ``useless`` samples count as missing.
        """
        tracked = segment.turns is not None
        turns = segment.turns if segment.turns is not None else np.arange(len(segment.missing), dtype=np.float64) * (clock / self._rate)
        inside = turns[self._margin : self._margin + self._hop + 1]
        net = float(inside[-1] - inside[0])
        self.reversed = reverses(inside)
        direction = int(np.sign(net)) if abs(net) > JITTER else self._direction
        if tracked != self._tracked or self.reversed or (self._direction and direction != self._direction):
            self.clear()
        self._tracked, self._direction = tracked, direction
        bins = abs(net) * self.bins_per_turn * (self._hops.maxlen or 1)
        self.excessive_bins = bins if bins > MOST_BINS else 0.0
        if self.excessive_bins:
            self.clear()
        if self.reversed or self.excessive_bins:
            return None
        forward = np.maximum.accumulate(turns if direction >= 0 else -turns)
        self._hops.append(self._binned(segment, forward - forward[self._margin], tracked=tracked, useless=useless))
        self._turned += abs(net)
        return self._hops[-1]

    def _binned(self, segment: Segment, turns: npt.NDArray[np.float64], *, tracked: bool, useless: bool) -> Hop:
        begin, length = self._turned, float(turns[self._margin + self._hop])
        edges = bin_edges(begin, begin + length, self.bins_per_turn) - begin
        positions = np.interp(edges, turns, np.arange(len(turns), dtype=np.float64))
        if len(positions) < 2:
            return Hop(np.zeros((len(self._demodulator.bands), 0), np.float32), np.zeros(0, np.bool_), length)
        means = np.array(
            [bin_means(where, values, positions) for where, values in self._demodulator.squared_envelopes(segment.acceleration)]
        )
        if tracked:
            frequency = self._rate / (np.maximum(np.diff(positions), 1e-9) * self.bins_per_turn)
            means = means / (np.maximum(frequency, SLOWEST) / REFERENCE_FREQUENCY) ** (2.0 * self._exponent)
        missing = np.ones(len(positions) - 1, np.bool_) if useless else _missing_bins(segment.missing, positions, self._margin // 2)
        return Hop(np.minimum(means, LARGEST).astype(np.float32), missing, length)

    @property
    def tracked(self) -> bool:
        """Whether the turns are those of the shaft, not of a clock."""
        return self._tracked

    @property
    def turns(self) -> float:
        """Turns within the window [-]."""
        return sum(hop.turns for hop in self._hops)

    @property
    def begin(self) -> float:
        """Angle at the begin of the first bin, from that of the shaft at the end of the window [turns]."""
        bins = math.floor(self._turned * self.bins_per_turn) - sum(len(hop.missing) for hop in self._hops)
        return bins / self.bins_per_turn - self._turned

    @property
    def frequency(self) -> float:
        """Mean frequency of the turns [Hz]."""
        return self.turns * self._rate / (len(self._hops) * self._hop) if self._hops else 0.0

    @property
    def missing_share(self) -> float:
        """Share of missing bins [-]."""
        missing = np.concatenate([hop.missing for hop in self._hops]) if self._hops else np.ones(1, np.bool_)
        return float(missing.mean()) if len(missing) else 1.0

    def ages(self) -> Floats:
        """Return the time from each bin to the end of the window, for a shaft that turns evenly within each hop, shape (bins,) [s]."""
        seconds, count = self._hop / self._rate, len(self._hops)
        ages = [(np.arange(len(hop.missing), 0, -1) - 0.5) / max(len(hop.missing), 1) for hop in self._hops]
        return np.concatenate([(count - 1 - number + age) * seconds for number, age in enumerate(ages)])

    def envelopes(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.bool_]]:
        """Return the squared envelopes of all hops, shape (bands, bins), and which bins are missing."""
        return np.concatenate([hop.envelopes for hop in self._hops], axis=1), np.concatenate([hop.missing for hop in self._hops])


def _missing_bins(missing: npt.NDArray[np.bool_], positions: npt.NDArray[np.float64], beside: int) -> npt.NDArray[np.bool_]:
    """Return which bins have missing samples in them or within ``beside`` samples of them, where the filter still rings."""
    if not missing.any():
        return np.zeros(len(positions) - 1, np.bool_)
    count = np.concatenate([[0], np.cumsum(missing)])
    first = np.clip(np.floor(positions[:-1]).astype(int) - beside, 0, len(missing))
    last = np.clip(np.ceil(positions[1:]).astype(int) + beside, 0, len(missing))
    return np.asarray(count[last] > count[first], np.bool_)


def margin_samples(rate: int, low: float, periods: float) -> int:
    """Return the samples on either side of a hop that its envelope depends on: ``periods`` of the lowest frequency ``low`` [Hz]."""
    return math.ceil(periods * rate / low)
