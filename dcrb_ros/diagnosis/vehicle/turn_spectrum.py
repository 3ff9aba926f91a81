"""The vertical acceleration of an axle box over the angle of its wheelset, and its spectrum over orders."""

from __future__ import annotations

from collections import deque

import numpy as np
from scipy import fft

from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum, order_spectra
from dcrb_ros.diagnosis.order_tracking import bin_edges, bin_means, reverses
from dcrb_ros.diagnosis.segments import Segment
from dcrb_ros.schema.arrays import Floats

BINS = 640
"""Bins of a turn [-]."""
HIGHEST = 220.0
"""Highest order of the spectrum [-]."""
CUT = 230.0, 300.0
"""Orders between which the low-pass filter falls [-]: what it leaves is not aliased below `HIGHEST`."""
FEWEST_TURNS = 16.0
"""Turns from which neighbouring orders are separated [-]: a line is four bins of 1/16 order wide."""
MOST_BINS = 1 << 18
"""Most bins of a hop [-]; at 300 km/h and hops of 0.5 s there are some 10000."""


class TurnSpectrum:
    """The latest hops of one box, in bins of equal angle."""

    def __init__(self, hop: int, margin: int, hops: int) -> None:
        """Prepare for segments of ``hop`` samples with a ``margin`` on either side; a window has ``hops`` of them."""
        self._hop, self._margin = hop, margin
        self._hops: deque[Floats] = deque(maxlen=hops)
        self._turns: deque[float] = deque(maxlen=hops)
        self._turned, self._forward = 0.0, True

    def add(self, segment: Segment) -> None:
        """Take a segment; the window begins anew after a gap, and where the angle is missing or the wheelset turns back."""
        if segment.first:
            self._clear()
        turns = segment.turns
        if turns is None or reverses(turns):
            self._clear()
            return
        net = float(turns[self._margin + self._hop] - turns[self._margin])
        usable = 0.0 < abs(net) * BINS <= MOST_BINS
        if not usable or (net > 0.0) != self._forward:
            self._clear()
        self._forward = net > 0.0
        if not usable:
            return
        forward = np.maximum.accumulate(turns if self._forward else -turns)
        forward -= forward[self._margin]
        edges = bin_edges(self._turned, self._turned + abs(net), BINS) - self._turned
        positions = np.interp(edges, forward, np.arange(len(forward), dtype=np.float64))
        vertical = np.asarray(segment.acceleration[:, min(1, segment.acceleration.shape[1] - 1)], np.float64)
        smooth = _low_passed(vertical, abs(net) / self._hop)
        self._hops.append(bin_means(np.arange(len(smooth), dtype=np.float64), smooth, positions))
        self._turns.append(abs(net))
        self._turned += abs(net)

    def spectrum(self) -> OrderSpectrum | None:
        """Return the spectrum of the window; None with fewer turns than `FEWEST_TURNS`."""
        if sum(self._turns) < FEWEST_TURNS:
            return None
        wave = np.concatenate(list(self._hops))
        return order_spectra(wave[None, :], np.zeros(len(wave), np.bool_), BINS, HIGHEST)[0]

    def _clear(self) -> None:
        self._hops.clear()
        self._turns.clear()
        self._turned = 0.0


def _low_passed(values: Floats, turn: float) -> Floats:
    """Return a waveform without what is above the orders `CUT`; the wheelset rotates by ``turn`` in a sample [turns]."""
    length = fft.next_fast_len(len(values), real=True)
    order = np.arange(length // 2 + 1) / (length * turn)
    share = np.clip((CUT[1] - order) / (CUT[1] - CUT[0]), 0.0, 1.0)
    return np.asarray(fft.irfft(fft.rfft(values, length) * (0.5 - 0.5 * np.cos(np.pi * share)), length)[: len(values)], np.float64)
