"""Removal of what repeats in every turn of a wheelset: the roughness of its wheels, flats, and the mesh of its gear.

The synchronous average is that of Braun 1975, "The extraction of periodic waveforms by time domain averaging", Acustica 32, 69. Lines of a
bearing are at no whole orders, so that their impacts average out.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
from scipy.ndimage import map_coordinates, maximum_filter1d

from dcrb_ros.diagnosis.order_tracking import bin_edges, reverses
from dcrb_ros.diagnosis.segments import Segment
from dcrb_ros.schema.arrays import Floats

FEWEST_TURNS = 4.0
"""Turns from which the average is removed [-]: it holds 1/N of everything else in N turns."""
MOST_BINS = 1 << 15
"""Most bins of a turn [-]; they are at least as dense as samples, so that a wheelset below 1.6 Hz at 51.2 kHz is not averaged."""

REACH = 8
"""Samples beside a missing one in which a spline still rings [-]."""


class _Sums(NamedTuple):
    """A hop over the angle of the wheelset."""

    total: Floats
    """Sum of the samples at each angle, shape (bins, axes) [m/s^2]."""
    samples: Floats
    """Their number, shape (bins,) [-]."""
    turns: float
    """[-]"""


class TurnAverage:
    """Averages the latest hops of one box over the angle of its wheelset."""

    def __init__(self, hop: int, margin: int, hops: int) -> None:
        """Prepare for segments of ``hop`` samples with a ``margin`` on either side; ``hops`` of them are averaged."""
        self._hop, self._margin = hop, margin
        self._hops: deque[_Sums] = deque(maxlen=hops)
        self._bins, self._turned, self._forward = 0, 0.0, True

    def removed(self, segment: Segment) -> Segment:
        """Return a segment without the average of the hops up to it; the segment itself if too few turns are known.

        The average begins anew after a gap, and where the angle is missing or the wheelset turns back.
        """
        if segment.first:
            self._clear()
        turns = segment.turns
        if turns is None or reverses(turns):
            self._clear()
            return segment
        net = float(turns[self._margin + self._hop] - turns[self._margin])
        if (net > 0.0) != self._forward:
            self._clear()
        self._forward = net > 0.0
        bins = 1 << int(np.ceil(np.log2(max(self._hop / max(abs(net), 1e-9), 1.0))))
        if bins > MOST_BINS:
            self._clear()
            return segment
        # A speed at a power of two does not begin the average anew again and again.
        if bins != self._bins != 2 * bins:
            self._clear()
            self._bins = bins
        forward = np.maximum.accumulate(turns if self._forward else -turns)
        forward += self._turned - forward[self._margin]
        self._hops.append(self._summed(segment, forward, abs(net)))
        self._turned += abs(net)
        if sum(hop.turns for hop in self._hops) < FEWEST_TURNS:
            return segment
        return segment._replace(acceleration=np.where(segment.missing[:, None], 0.0, segment.acceleration - self._at(forward)))

    def _summed(self, segment: Segment, turns: Floats, net: float) -> _Sums:
        """Return the sums of the samples within the hop, by cubic splines between them; those near missing ones are left out."""
        angles = bin_edges(self._turned, self._turned + net, self._bins)[1:]
        positions = np.interp(angles, turns, np.arange(len(turns), dtype=np.float64))
        known = ~maximum_filter1d(segment.missing, 2 * REACH + 1)[np.rint(positions).astype(np.int64)]
        bins = np.rint(angles[known] * self._bins).astype(np.int64) % self._bins
        total = [np.bincount(bins, map_coordinates(axis, [positions[known]], order=3), self._bins) for axis in segment.acceleration.T]
        return _Sums(np.array(total).T, np.bincount(bins, minlength=self._bins).astype(np.float64), net)

    def _at(self, turns: Floats) -> Floats:
        """Return the average at ``turns``, shape (samples, axes) [m/s^2]."""
        count = np.maximum(sum(hop.samples for hop in self._hops), 1.0)
        mean = sum(hop.total for hop in self._hops) / count[:, None]
        positions = np.mod(turns, 1.0) * self._bins
        return np.column_stack([map_coordinates(axis, [positions], order=3, mode="grid-wrap") for axis in mean.T])

    def _clear(self) -> None:
        self._hops.clear()
        self._turned = 0.0
