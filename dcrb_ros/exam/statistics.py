"""Statistics of an exam: confidence intervals of a rate and of a proportion, and the receiver operating characteristic."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest, chi2

from dcrb_ros.schema.arrays import Floats

CONFIDENCE = 0.95
"""Confidence level of every interval [-]."""


class Interval(NamedTuple):
    """An estimate with its confidence interval."""

    value: float
    low: float
    high: float


def rate(count: int, hours: float, repeats: float = 1.0) -> Interval:
    """Return the rate of ``count`` events in ``hours`` with its exact Poisson interval (Garwood 1936) [1/h].

    If the time is counted ``repeats`` times on average [-], so are its events. The interval is that of count and time divided by this
    number, which need not be whole.
    """
    if hours <= 0.0:
        return Interval(float("nan"), 0.0, float("inf"))
    tail = 0.5 * (1.0 - CONFIDENCE)
    once, distinct = count / repeats, hours / repeats
    low = 0.5 * float(chi2.ppf(tail, 2.0 * once)) if count else 0.0
    return Interval(count / hours, low / distinct, 0.5 * float(chi2.ppf(1.0 - tail, 2.0 * once + 2.0)) / distinct)


def share(count: int, of: int) -> Interval:
    """Return the proportion ``count / of`` with its exact binomial interval (Clopper and Pearson 1934) [-]."""
    if of == 0:
        return Interval(float("nan"), 0.0, 1.0)
    limits = binomtest(count, of).proportion_ci(CONFIDENCE, method="exact")
    return Interval(count / of, float(limits.low), float(limits.high))


def class_mean(marks: Floats, truths: Sequence[str], weights: Floats) -> Floats:
    """Return the mean over the classes of the weighted mean over their scenarios, shape (detectors, samples) [-].

    ``marks`` has shape (detectors, scenarios), ``weights`` (scenarios, samples). A class without weight in a sample is left out of it.
    """
    total, present = np.zeros((len(marks), weights.shape[1])), np.zeros(weights.shape[1])
    for truth in sorted(set(truths)):
        members = np.array([other == truth for other in truths])
        whole = weights[members].sum(axis=0)
        total += np.where(whole > 0.0, marks[:, members] @ weights[members] / np.where(whole > 0.0, whole, 1.0), 0.0)
        present += whole > 0.0
    return np.asarray(total / np.maximum(present, 1.0), np.float64)


def partial_area(faulty: Sequence[float], healthy: Sequence[float], share: float) -> float | None:
    """Return the area under the receiver operating characteristic up to a false positive rate, divided by that rate [-].

    pAUC = sum over i <= floor(p N-), j <= N+ of H(x+_j - x-_i) / (floor(p N-) N+), with the N- healthy scores x- in decreasing order
    (Koizumi et al. 2020, DCASE task 2); ties count one half, as in `characteristic`. None if floor(p N-) or N+ is 0.
    """
    highest = sorted(healthy, reverse=True)[: int(share * len(healthy) + 1e-9)]
    curve = characteristic(faulty, highest)
    return None if curve is None else curve.area


def percentile(values: Sequence[float], percent: float) -> float:
    """Return a percentile of values; NaN if there are none."""
    return float(np.percentile(values, percent)) if values else float("nan")


class Characteristic(NamedTuple):
    """Receiver operating characteristic: true over false positive rate for decreasing thresholds."""

    false: list[float]
    """False positive rate: share of the healthy runs at or above the threshold [-]."""
    true: list[float]
    """True positive rate: share of the faulty runs at or above the threshold [-]."""
    threshold: list[float]
    """The score at each point but the first; infinite for a score that is missing."""
    area: float
    """Area under the curve: probability that a faulty run scores higher than a healthy one [-]."""


def characteristic(faulty: Sequence[float], healthy: Sequence[float]) -> Characteristic | None:
    """Return the receiver operating characteristic of scores; None unless there are scores of both faulty and healthy runs."""
    if not faulty or not healthy:
        return None
    positive, negative = np.sort(faulty), np.sort(healthy)
    thresholds = np.unique(np.concatenate([positive, negative]))[::-1]
    true = 1.0 - np.searchsorted(positive, thresholds, side="left") / len(positive)
    false = 1.0 - np.searchsorted(negative, thresholds, side="left") / len(negative)
    # Ties count one half (Mann and Whitney 1947).
    below, upto = np.searchsorted(negative, positive, side="left"), np.searchsorted(negative, positive, side="right")
    area = float((below + upto).sum()) / (2.0 * len(positive) * len(negative))
    return Characteristic([0.0, *false.tolist()], [0.0, *true.tolist()], thresholds.tolist(), area)
