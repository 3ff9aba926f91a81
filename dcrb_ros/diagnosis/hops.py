"""The sliding window: squared envelopes of the latest hops in every band, over the turns of the shaft."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.bands import BandBank
from dcrb_ros.diagnosis.stream import Stretch
from dcrb_ros.diagnosis.turning import bin_means, borders_between, turns_back

REFERENCE_FREQUENCY = 20.0
"""Shaft frequency at which limits are stated and envelopes are kept [Hz]."""
SLOWEST = 0.5
"""Shaft frequency below which an envelope is not scaled up any more [Hz]."""
LOUDEST = 1e30
"""Squared envelope that a single float still squares without overflow in a mean [(m/s^2)^2]."""
MOST_TURNED_BACK = 0.02
"""Turns that an angle may go back by within a hop, its jitter set aside [-]."""


class Hop(NamedTuple):
    """A hop's squared envelopes."""

    envelopes: npt.NDArray[np.float32]
    """Of each band in bins of equal angle, as they would be at the reference frequency, shape (bands, bins) [(m/s^2)^2]."""
    missing: npt.NDArray[np.bool_]
    """Bins whose samples are missing."""
    turns: float
    """Turns of the shaft; of a stretch without shaft angle those of a clock [-]."""

    @property
    def powers(self) -> npt.NDArray[np.floating]:
        """Mean squared envelope of each band [(m/s^2)^2]."""
        known = self.envelopes[:, ~self.missing]
        return known.mean(axis=1) if known.shape[1] else np.zeros(len(self.envelopes))


class Window:
    """The latest hops, as many as a window holds."""

    def __init__(self, bank: BandBank, rate: int, hop: int, margin: int, bins_per_turn: int, hops: int, exponent: float) -> None:
        self._bank, self._rate, self._hop, self._margin = bank, rate, hop, margin
        self.bins_per_turn, self._exponent = bins_per_turn, exponent
        self._hops: deque[Hop] = deque(maxlen=hops)
        self._turned, self._direction, self._tracked = 0.0, 0, True
        self.turned_back = False
        """Whether the latest hop began a new window because the shaft turned back in it."""

    def __len__(self) -> int:
        return len(self._hops)

    def clear(self) -> None:
        """Forget all hops."""
        self._hops.clear()
        self._direction = 0

    def add(self, stretch: Stretch, clock: float, *, useless: bool) -> Hop | None:
        """Take a stretch and return its hop, unless the shaft turned back in it.

        Without a shaft angle it is laid over the turns of a ``clock`` [Hz]. ``useless`` samples count as missing.
        """
        tracked = stretch.turns is not None
        turns = stretch.turns if stretch.turns is not None else np.arange(len(stretch.missing), dtype=np.float64) * (clock / self._rate)
        inside = turns[self._margin : self._margin + self._hop + 1]
        net = float(inside[-1] - inside[0])
        self.turned_back = turns_back(inside, MOST_TURNED_BACK)
        direction = int(np.sign(net)) if abs(net) > MOST_TURNED_BACK else self._direction
        if tracked != self._tracked or self.turned_back or (self._direction and direction != self._direction):
            self.clear()
        self._tracked, self._direction = tracked, direction
        if self.turned_back:
            return None
        forward = np.maximum.accumulate(turns if direction >= 0 else -turns)
        self._hops.append(self._binned(stretch, forward - forward[self._margin], tracked=tracked, useless=useless))
        self._turned += abs(net)
        return self._hops[-1]

    def _binned(self, stretch: Stretch, turns: npt.NDArray[np.float64], *, tracked: bool, useless: bool) -> Hop:
        begin, length = self._turned, float(turns[self._margin + self._hop])
        borders = borders_between(begin, begin + length, self.bins_per_turn) - begin
        places = np.interp(borders, turns, np.arange(len(turns), dtype=np.float64))
        if len(places) < 2:
            return Hop(np.zeros((len(self._bank.bands), 0), np.float32), np.zeros(0, np.bool_), length)
        means = np.array([bin_means(where, values, places) for where, values in self._bank.squared_envelopes(stretch.acceleration)])
        if tracked:
            frequency = self._rate / (np.maximum(np.diff(places), 1e-9) * self.bins_per_turn)
            means = means / (np.maximum(frequency, SLOWEST) / REFERENCE_FREQUENCY) ** (2.0 * self._exponent)
        missing = np.ones(len(places) - 1, np.bool_) if useless else _missing_bins(stretch.missing, places, self._margin // 2)
        return Hop(np.minimum(means, LOUDEST).astype(np.float32), missing, length)

    @property
    def tracked(self) -> bool:
        """Whether the hops lie over the shaft's turns."""
        return self._tracked

    @property
    def turns(self) -> float:
        """Turns within the window [-]."""
        return sum(hop.turns for hop in self._hops)

    @property
    def frequency(self) -> float:
        """Mean frequency of the turns [Hz]."""
        return self.turns * self._rate / (len(self._hops) * self._hop) if self._hops else 0.0

    @property
    def missing_share(self) -> float:
        """Share of the bins that is missing [-]."""
        missing = np.concatenate([hop.missing for hop in self._hops]) if self._hops else np.ones(1, np.bool_)
        return float(missing.mean()) if len(missing) else 1.0

    def envelopes(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.bool_]]:
        """Return the squared envelopes of all hops, shape (bands, bins), and which bins are missing."""
        return np.concatenate([hop.envelopes for hop in self._hops], axis=1), np.concatenate([hop.missing for hop in self._hops])


def _missing_bins(missing: npt.NDArray[np.bool_], places: npt.NDArray[np.float64], beside: int) -> npt.NDArray[np.bool_]:
    """Return which bins have missing samples within them or ``beside`` them, where a filter still rings."""
    if not missing.any():
        return np.zeros(len(places) - 1, np.bool_)
    count = np.concatenate([[0], np.cumsum(missing)])
    first = np.clip(np.floor(places[:-1]).astype(int) - beside, 0, len(missing))
    last = np.clip(np.ceil(places[1:]).astype(int) + beside, 0, len(missing))
    return np.asarray(count[last] > count[first], np.bool_)


def margin_samples(rate: int, low: float, periods: float) -> int:
    """Return the samples beside a hop that belong to its envelope: ``periods`` of the lowest band's edge ``low`` [Hz]."""
    return math.ceil(periods * rate / low)
