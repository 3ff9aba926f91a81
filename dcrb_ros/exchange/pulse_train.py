"""The angle of the shaft from a tacho: pulses, a constant number per turn, or the speed over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.schema.refusal import Refusal

FULL_TURN = 2.0 * np.pi
LEVELS = (1.0 / 3.0, 2.0 / 3.0)
"""Lower and upper level of the hysteresis between the smallest and the largest sample [-]: noise of a third of the pulse counts no edge."""
LONE_PULSE = 8.0
"""Interval that is assumed after a pulse without a neighbour [samples]."""
FEWEST_EDGES = 3
"""Least number of edges from which a speed follows [-]: two intervals that can be compared."""
MOST_IRREGULAR = 0.1
"""Largest share of intervals with missing or additional pulses [-]; a wheel of 60 teeth without two of them has 0.02."""
NEIGHBOURS = 5
"""Intervals with whose median one is compared [-]: one missing or additional pulse does not change it."""
FASTEST_RPM = 1e6
"""Largest speed of a channel, as of a stated one [rpm]."""


@dataclass(frozen=True)
class PulseTrain:
    """The turns of the shaft at the rising edges of a tacho signal."""

    edges: Floats
    """Position of each edge, shape (edges,) [samples]."""
    turns: Floats
    """Turns since the first edge, shape (edges,) [-]."""
    irregular: int
    """Intervals in which pulses were missing or too many [-]."""

    def at(self, index: npt.NDArray[np.int64]) -> Floats:
        """Return the turns at each sample, shape (samples,) [-]; beyond the edges the speed of the nearest interval continues."""
        positions = np.asarray(index, np.float64)
        turns = np.interp(positions, self.edges, self.turns)
        for beyond, edge, neighbour in ((positions < self.edges[0], 0, 1), (positions > self.edges[-1], -1, -2)):
            slope = (self.turns[edge] - self.turns[neighbour]) / (self.edges[edge] - self.edges[neighbour])
            turns[beyond] = self.turns[edge] + slope * (positions[beyond] - self.edges[edge])
        return np.asarray(turns, np.float64)


def pulse_train(pulses: Floats, index: npt.NDArray[np.int64], per_turn: int, levels: tuple[float, float] | None, source: str) -> PulseTrain:
    """Return the turns at the rising edges of ``pulses``, shape (samples,), at the samples ``index``, with ``per_turn`` edges per turn.

    An edge is where the signal rises through the mean of two ``levels``, interpolated between samples, after it was below the lower one
    and before it exceeds the upper one. By default the levels lie at a third and two thirds of its range. An interval that is a multiple of
    its neighbours has missing pulses, which are counted; one below half of them ends with an additional pulse, which is left out.
    One across missing samples has as many pulses as its neighbours suggest, and counts as regular.

    Raises:
        Refusal: there are fewer than three edges, or a tenth of the intervals are irregular; ``source`` names the channel.
    """
    low, high = levels or _levels(pulses)
    edges, borders = _edges(pulses, index, low, high)
    if len(edges) < FEWEST_EDGES:
        raise Refusal(
            f"{source} has {len(edges)} rising edges through {low:g} and {high:g}, but a speed needs {FEWEST_EDGES}: "
            "check the channel, or give tacho_levels"
        )
    intervals = np.diff(edges)
    within = ~_across(edges, borders)
    if not within.any():
        raise Refusal(f"{source} has no two pulses without missing samples between them: give the speed by another key")
    usual = np.interp(np.arange(len(intervals)), np.flatnonzero(within), _median_of_neighbours(intervals[within]))
    steps = np.rint(intervals / usual)
    steps[~within] = np.maximum(1.0, steps[~within])
    regular, irregular = np.count_nonzero(within), int(np.count_nonzero(steps[within] != 1.0))
    if irregular > MOST_IRREGULAR * regular:
        raise Refusal(
            f"{source}: {irregular} of {regular} intervals between pulses differ from their neighbours by half or more: "
            "give tacho_levels beyond the noise, or a smoother signal"
        )
    kept = np.concatenate([[True], steps > 0.0])
    turns = np.concatenate([[0.0], np.cumsum(steps)]) / per_turn
    return PulseTrain(edges[kept], turns[kept], irregular)


def counted_pulses(pulses: Floats, index: npt.NDArray[np.int64], per_turn: int, levels: tuple[float, float] | None) -> PulseTrain:
    """Return the turns at all rising edges of ``pulses``, each of which is one pulse; across missing samples the median interval goes on.

    It is for the exact pulses of an export; `pulse_train` corrects those of a real wheel and its pickup.
    """
    edges, borders = _edges(pulses, index, *(levels or _levels(pulses)))
    steps, intervals = np.ones(max(0, len(edges) - 1)), np.diff(edges)
    across = _across(edges, borders)
    if across.any() and not across.all():
        steps[across] = np.maximum(1.0, np.rint(intervals[across] / np.median(intervals[~across])))
    return PulseTrain(edges, np.concatenate([np.zeros(min(1, len(edges))), np.cumsum(steps)]) / per_turn, 0)


def sampled_pulses(edges: Floats, index: npt.NDArray[np.int64]) -> Samples:
    """Return the signal of a tacho with rising ``edges`` [samples] at the samples ``index``, from 0 to 1, shape (samples,).

    A pulse lasts half of the interval to the next edge. It rises and falls within two samples, or half as long as the pulse if that is
    shorter, so that interpolation between samples restores the times of its edges.
    """
    if not len(edges):
        return np.zeros(len(index), np.float32)
    intervals = np.diff(edges) if len(edges) > 1 else np.array([LONE_PULSE])
    before, after = np.insert(intervals, 0, intervals[0])[: len(edges)], np.append(intervals, intervals[-1])[: len(edges)]
    half = np.minimum(1.0, 0.25 * np.minimum(before, after))
    falls = edges + 0.5 * after
    corners = np.column_stack([edges - half, edges + half, falls - half, falls + half]).ravel()
    return np.asarray(np.interp(index, corners, np.tile([0.0, 1.0, 1.0, 0.0], len(edges))), np.float32)


def _edges(pulses: Floats, index: npt.NDArray[np.int64], low: float, high: float) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Return the rising edges [samples] except those across missing samples, and the samples after each gap."""
    runs = np.flatnonzero(np.diff(index) != 1) + 1
    parts = zip(np.split(pulses, runs), np.split(index, runs), strict=True)
    return np.concatenate([begin[0] + edges for part, begin in parts for edges in [rising_edges(part, low, high)]]), index[runs]


def _across(edges: Floats, borders: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Return whether samples are missing between each edge and the next one, shape (edges - 1,), from the samples after each gap."""
    return np.asarray(np.searchsorted(borders, edges[1:]) != np.searchsorted(borders, edges[:-1]))


def rising_edges(pulses: Floats, low: float, high: float) -> Floats:
    """Return where ``pulses`` rise through the mean of ``low`` and ``high`` after being below ``low``, shape (edges,) [samples].

    Each edge is interpolated between the last sample below the mean and the next one.
    """
    state = np.where(pulses >= high, 1, np.where(pulses <= low, -1, 0))
    decided = np.flatnonzero(state)
    risen = decided[1:][(state[decided[1:]] > 0) & (state[decided[:-1]] < 0)]
    fallen = decided[:-1][(state[decided[1:]] > 0) & (state[decided[:-1]] < 0)]
    return np.array(list(_crossings(pulses, fallen, risen, 0.5 * (low + high))), np.float64)


def _crossings(pulses: Floats, before: npt.NDArray[np.intp], after: npt.NDArray[np.intp], middle: float) -> Iterator[float]:
    """Yield the last crossing of ``middle`` between each pair of samples ``before`` and ``after``."""
    for first, last in zip(before.tolist(), after.tolist(), strict=True):
        below = first + int(np.flatnonzero(pulses[first:last] < middle)[-1])
        rise = float(pulses[below + 1] - pulses[below])
        yield below + float(middle - pulses[below]) / rise


def _levels(pulses: Floats) -> tuple[float, float]:
    least, most = float(pulses.min()), float(pulses.max())
    low, high = (least + share * (most - least) for share in LEVELS)
    return low, high


def _median_of_neighbours(intervals: Floats) -> Floats:
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(intervals, min(NEIGHBOURS, len(intervals)), mode="nearest"), np.float64)


def turns_at_speed(rpm: Floats, index: npt.NDArray[np.int64], rate: float, source: str) -> Floats:
    """Return the turns of the shaft at the samples ``index``, shape (samples,) [-], from its speed over the same time [rpm].

    A single speed is constant. Fewer speeds than samples are spread evenly over the time. Those that are NaN are interpolated.

    Raises:
        Refusal: no speed is finite, or one is infinite or there are more of them than samples; ``source`` names the channel.
    """
    known = np.isfinite(rpm)
    if not known.any() or np.isinf(rpm).any() or len(rpm) > len(index):
        raise Refusal(
            f"{source} has {len(rpm)} speeds for {len(index)} samples, of which {int(known.sum())} are finite: "
            "give speeds in rpm, NaN where unknown, at most one per sample"
        )
    fastest = float(np.nanmax(np.abs(rpm), initial=0.0))
    if fastest > FASTEST_RPM:
        raise Refusal(f"{source} is {fastest:g} rpm, above {FASTEST_RPM:g} rpm: give a channel of the speed in rpm")
    # The first speed is that of the first sample, and the time between two speeds is the same for all of them.
    positions = index[0] + np.arange(len(rpm)) * ((index[-1] - index[0] + 1) / len(rpm)) if len(rpm) < len(index) else index
    frequency = np.interp(index, np.asarray(positions)[known], rpm[known]) / 60.0
    steps = 0.5 * (frequency[1:] + frequency[:-1]) * np.diff(index) / rate
    return np.concatenate([[0.0], np.cumsum(steps)])


def joined_turns(parts: Sequence[Floats], indices: Sequence[npt.NDArray[np.int64]]) -> Floats:
    """Return the turns of the shaft over consecutive files from those within each file at its samples ``indices``, shape (samples,) [-].

    Between two files the shaft turns at the mean of the speeds at the end of one and at the beginning of the other.
    """
    begin, joined = 0.0, [parts[0]]
    for (before, after), (index, following) in zip(pairwise(parts), pairwise(indices), strict=True):
        speeds = [np.diff(turns) / np.diff(index) for turns, index in ((before[-2:], index[-2:]), (after[:2], following[:2]))]
        speed = float(np.mean(np.concatenate(speeds))) if sum(map(len, speeds)) else 0.0
        begin += float(before[-1]) + speed * float(following[0] - index[-1])
        joined.append(begin + after)
    return np.concatenate(joined)


def wrapped(turns: Floats) -> npt.NDArray[np.float32]:
    """Return turns as angles within [0, 2 pi), NaN where unknown, same shape [rad]."""
    return wrapped_angle(np.mod(turns, 1.0) * FULL_TURN)


def wrapped_angle(angle: Floats) -> npt.NDArray[np.float32]:
    """Return angles within [0, 2 pi), NaN where unknown, same shape [rad]."""
    within = np.mod(angle, FULL_TURN).astype(np.float32)
    within[within >= np.float32(FULL_TURN)] = 0.0
    return within
