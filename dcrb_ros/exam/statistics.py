"""The few statistics of an exam: bounds on a rate and on a share, and the receiver operating characteristic."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest, chi2

CONFIDENCE = 0.95
"""Confidence of every interval [-]."""


class Interval(NamedTuple):
    """An estimate with its bounds."""

    value: float
    low: float
    high: float


def rate(count: int, hours: float) -> Interval:
    """Return events per hour with the exact bounds of a Poisson process (Garwood 1936)."""
    if hours <= 0.0:
        return Interval(float("nan"), 0.0, float("inf"))
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = 0.5 * float(chi2.ppf(tail, 2 * count)) if count else 0.0
    return Interval(count / hours, low / hours, 0.5 * float(chi2.ppf(1.0 - tail, 2 * count + 2)) / hours)


def share(count: int, of: int) -> Interval:
    """Return a share with the exact bounds of a binomial one (Clopper and Pearson 1934)."""
    if of == 0:
        return Interval(float("nan"), 0.0, 1.0)
    found = binomtest(count, of).proportion_ci(CONFIDENCE, method="exact")
    return Interval(count / of, float(found.low), float(found.high))


def percentile(values: Sequence[float], percent: float) -> float:
    """Return a percentile, NaN of nothing."""
    return float(np.percentile(values, percent)) if values else float("nan")


class Characteristic(NamedTuple):
    """Detections over false alarms as the threshold falls."""

    false: list[float]
    """Share of the healthy runs above the threshold."""
    true: list[float]
    """Share of the faulty runs above it."""
    threshold: list[float]
    area: float
    """Area below the curve: how often a faulty run has more evidence than a healthy one."""


def characteristic(faulty: Sequence[float], healthy: Sequence[float]) -> Characteristic | None:
    """Return the receiver operating characteristic of scores; none without both kinds."""
    if not faulty or not healthy:
        return None
    positive, negative = np.sort(faulty), np.sort(healthy)
    thresholds = np.unique(np.concatenate([positive, negative]))[::-1]
    true = 1.0 - np.searchsorted(positive, thresholds, side="left") / len(positive)
    false = 1.0 - np.searchsorted(negative, thresholds, side="left") / len(negative)
    # Ties count half (Mann and Whitney).
    below, upto = np.searchsorted(negative, positive, side="left"), np.searchsorted(negative, positive, side="right")
    area = float((below + upto).sum()) / (2.0 * len(positive) * len(negative))
    return Characteristic([0.0, *false.tolist()], [0.0, *true.tolist()], thresholds.tolist(), area)
