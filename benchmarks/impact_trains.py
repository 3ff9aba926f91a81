"""Strength and time of single impacts in a squared envelope, and the scatter of a train of impacts.

The impacts are those of one line of the envelope: its phase is followed, and each period contains one impact. The estimators are alike for
simulated and measured signals; docs/explanation/realism.md defines the statistics. ``squared`` is a squared envelope of shape (samples,),
``rate`` its sampling rate [Hz] and ``frequency`` that of the line, found within half a bandwidth of 2 Hz [Hz].
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import signal

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

FOLLOWING = 0.5
"""Length of the Hann window in which the phase of a line is followed [s]; its bandwidth is 2 Hz."""
STEPS = 32
"""Phases per window [-]."""
BINS = 64
"""Parts of a period in which the envelope is averaged [-]."""
SMOOTHING = 5
"""Parts over which that mean is averaged [-]."""
BEFORE, LENGTH = 0.2, 0.55
"""Begin of an impact before the maximum of the mean envelope, and its length, as shares of the period [-]."""
FLOOR_BINS = 16
"""Parts of the period with the lowest mean envelope, whose mean is the floor [-]."""
COMPLETE = 0.4
"""Least share of the samples of an impact that must be present [-]."""
FEWEST = 20
"""Impacts from which their scatter is estimated [-]."""
ENVELOPE_SMOOTHING = 3e-4
"""Length of the Hann window that smooths an envelope before impacts are compared with their mean [s]."""
REACH, EDGE = 0.15, 0.95
"""Largest shift of an impact relative to its length, and the share of it beyond which an impact is left out [-]."""


class Train(NamedTuple):
    """The impacts of one line of a squared envelope."""

    times: Floats
    """Centres of the impacts, shape (impacts,) [s]."""
    energies: Floats
    """Mean squared envelope over the floor during each impact, shape (impacts,), in the square of the signal's unit."""
    fold: Floats
    """Mean envelope over the period, shape (BINS,)."""
    turns: Floats
    """Phase of the line in periods, shape of the envelope [-]."""

    @property
    def begin(self) -> float:
        """Phase at which an impact begins [-]."""
        return float(np.argmax(self.fold)) / BINS - BEFORE


class Scatter(NamedTuple):
    """How the impacts of a train differ."""

    energy: float
    """Standard deviation of the energies over their mean, c_E [-]."""
    neighbour: float
    """Correlation of the strengths of consecutive impacts [-]; the strength is the square root of the energy."""
    element: float
    """Correlation of the strengths of impacts of the same rolling element [-]."""
    shaft: float
    """Share of the variance of the strengths that follows the angle of the shaft [-]."""


def followed_phase(squared: Floats, rate: float, frequency: float) -> Floats:
    """Return the phase [periods] of a line of an envelope, followed with a bandwidth of 2 Hz, shape of ``squared``."""
    time = np.arange(len(squared)) / rate
    count = min(round(FOLLOWING * rate), len(squared))
    step, window = max(1, count // STEPS), np.hanning(count)
    carrier = (squared - squared.mean()) * np.exp(-2j * np.pi * frequency * time)
    smooth = signal.oaconvolve(carrier, window / window.sum(), "same")[::step]
    slow = np.unwrap(np.angle(smooth)) / (2.0 * np.pi)
    return np.asarray(frequency * time + np.interp(time, time[::step], slow), np.float64)


def train_of(squared: Floats, rate: float, frequency: float) -> Train:
    """Return the impacts at a line of a squared envelope.

    Raises:
        Refusal: the envelope contains fewer than `FEWEST` impacts.
    """
    turns, time = followed_phase(squared, rate, frequency), np.arange(len(squared)) / rate
    bins = (np.mod(turns, 1.0) * BINS).astype(np.int64) % BINS
    fold = np.bincount(bins, squared, BINS) / np.maximum(np.bincount(bins, minlength=BINS), 1)
    kernel = np.ones(SMOOTHING) / SMOOTHING
    smooth = np.asarray(np.convolve(np.tile(fold, 3), kernel, "same")[BINS : 2 * BINS], np.float64)
    floor = float(np.sort(fold)[:FLOOR_BINS].mean())
    since = turns - (float(np.argmax(smooth)) / BINS - BEFORE)
    inside = (np.mod(since, 1.0) < LENGTH) & (since >= 0.0)
    number = np.floor(since[inside]).astype(np.int64)
    count = np.bincount(number)
    kept = np.flatnonzero(count > COMPLETE * LENGTH * rate / frequency)[1:-1]
    if len(kept) < FEWEST:
        raise Refusal(
            f"{len(squared) / rate:.3g} s contain {len(kept)} complete impacts at {frequency:.4g} Hz, and their scatter needs at least "
            f"{FEWEST}: analyse a longer recording"
        )
    energies = np.bincount(number, squared[inside])[kept] / count[kept] - floor
    over = np.maximum(squared[inside] - floor, 0.0) ** 2
    mass = np.maximum(np.bincount(number, over), np.finfo(np.float64).tiny)
    return Train(np.asarray((np.bincount(number, over * time[inside]) / mass)[kept], np.float64), energies, smooth, turns)


def scatter_of(train: Train, elements: int, shaft_frequency: float) -> Scatter:
    """Return the scatter of the impacts of a train; each of the ``elements`` of a row passes again after the others.

    Raises:
        Refusal: the train has no more impacts than the row has elements.
    """
    if len(train.times) <= elements:
        raise Refusal(f"{len(train.times)} impacts are fewer than two turns of {elements} rolling elements: analyse a longer recording")
    strength = np.sqrt(np.maximum(train.energies, 0.0))
    deviation = strength - strength.mean()
    variance = max(float(np.mean(deviation**2)), np.finfo(np.float64).tiny)
    angle = 2.0 * np.pi * shaft_frequency * train.times
    basis = np.stack([np.cos(angle), np.sin(angle)], 1)
    fitted = basis @ np.linalg.lstsq(basis, deviation, rcond=None)[0]
    return Scatter(
        energy=float(train.energies.std() / train.energies.mean()),
        neighbour=float(np.mean(deviation[1:] * deviation[:-1])) / variance,
        element=float(np.mean(deviation[elements:] * deviation[:-elements])) / variance,
        shaft=float(np.var(fitted)) / variance,
    )


def delays(squared: Floats, rate: float, train: Train, envelope_rate: float) -> Floats:
    """Return the delay of each impact relative to the mean impact in the envelope of one band [s], shape (impacts,); NaN beyond the reach.

    The ``train`` is that of the envelope of the whole band, whose sampling rate is ``envelope_rate`` [Hz].
    """
    window = np.hanning(round(ENVELOPE_SMOOTHING * rate) + 2)
    smooth = np.sqrt(np.maximum(signal.oaconvolve(squared, window, "same"), 0.0))
    periods = np.arange(np.ceil(train.turns[0] - train.begin) + 1.0, np.floor(train.turns[-1] - train.begin) - 1.0)
    begins = np.searchsorted(train.turns, periods + train.begin) / envelope_rate
    length = int(LENGTH * rate * float(np.median(np.diff(begins))))
    first = np.rint(begins * rate).astype(np.int64)
    rows = np.stack([smooth[k : k + length] if k + length <= len(smooth) else np.full(length, np.nan) for k in first])
    template, reach = np.nanmean(rows, axis=0), int(REACH * length)
    shifts = np.arange(-reach, reach + 1)
    moved = np.stack([np.roll(template, k)[reach : length - reach] for k in shifts]) - template.mean()
    match = np.nan_to_num(rows[:, reach : length - reach], nan=0.0) @ moved.T
    late = shifts[np.argmax(match, axis=1)] / rate
    inside = np.isfinite(rows).all(axis=1) & (np.abs(late) < EDGE * reach / rate)
    return np.asarray(np.where(inside, late, np.nan), np.float64)


def shared_jitter(late: Sequence[npt.ArrayLike]) -> float:
    """Return the standard deviation [s] of the time errors of impacts that two bands share.

    The errors of estimation of two bands are independent, so their covariance is the variance of the errors of the impacts themselves. A
    negative covariance gives 0. ``late`` has the delays of the impacts in each band, shape (2, impacts) [s]; NaN where unknown.
    """
    both = np.asarray(late, np.float64)
    both = both[:, np.isfinite(both).all(axis=0)]
    return float(np.sqrt(max(np.cov(both)[0, 1], 0.0))) if both.shape[1] >= FEWEST else float("nan")
