"""Remaining life from the lives of other bearings: a Bayesian update of their times to failure by the inspections made so far.

After Gebraeel, Lawley, Li and Ryan, Residual-life distributions from component degradation signals: A Bayesian approach, IIE Transactions
37 (2005) 543-557, with the mean course of the failed bearings instead of an exponential trend.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.prognosis.remaining_life import RemainingLife, operating_hours, probability, representable
from dcrb_ros.schema.arguments import checked_arguments, numbers
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

FEWEST_LIVES = 3
"""Fewest failed bearings from which a distribution is taken [-]."""
SHARES = np.linspace(0.0, 1.0, 21)
"""Shares of the time from the begin of the trend to failure at which courses are compared [-]."""
CORRELATION = 3.0
"""Time over which the deviation of a bearing from the mean course is correlated, as a share of that time [-]."""
NUGGET = 0.03
"""Variance of an inspection given the one before at the same time, over that between bearings [-]."""
LEAST_DEVIATION = 0.2
"""Deviation of the logarithm of a severity beside that between bearings [-]."""
LEAST_SCATTER = 0.1
"""Smallest deviation of the logarithm of lives, for failed bearings that happen to agree [-]."""
SHORTEST, LONGEST, TIMES = 0.05, 20.0, 800
"""Times to failure that are considered: from a share of the shortest known one to a multiple of the longest, and their number [-]."""


def _histories(name: str, value: Any) -> None:
    """Refuse what is not a sequence of pairs of hours and severities."""
    if not isinstance(value, Sequence) or not all(isinstance(pair, (tuple, list)) and len(pair) == 2 for pair in value):
        raise Refusal(f"{name} is not a list of pairs: give hours and severities of each failed bearing")
    for hours, severity in value:
        operating_hours(name, hours)
        numbers(name, severity)


@checked_arguments(hours=operating_hours, severity=numbers, failed=_histories, coverage=probability)
@representable()
def update_remaining_life(
    hours: npt.ArrayLike,
    severity: npt.ArrayLike,
    failed: Sequence[tuple[npt.ArrayLike, npt.ArrayLike]],
    *,
    coverage: float = 0.9,
) -> RemainingLife:
    """Return the remaining life from the inspections of a bearing and the histories of bearings that failed.

    The time T from the start of the trend to failure has the lognormal predictive distribution of the failed bearings, with Student's t for
    their small number. At the share t / T of that time, the logarithm of the severity is normal about the mean course of the failed
    bearings with the deviation between them. The deviations u of a bearing are correlated from inspection to inspection, by
    rho = exp(-change of the share / CORRELATION), so that many inspections do not count as many bearings:

        u_k given u_(k-1) ~ N(rho u_(k-1), 1 - rho^2 + NUGGET)

    The correlation, the nugget and the least deviation were chosen on simulated lives: their values are assumptions for other machines.
    T is at most 20 times the longest known life, or twice the time since the start of the trend if this is longer. The upper end of an
    interval near this bound comes from it.

    Parameters
    ----------
    hours
        Operating hours of the inspections since the trend began, shape (inspections,), at least one [h].
    severity
        Severity at each over that of the healthy bearing, above 0, shape (inspections,) [-].
    failed
        Hours and severity of at least three failed bearings, as above, from the start of their trend to failure.
    coverage
        Probability with which the interval contains the remaining life, between 0 and 1.

    Returns
    -------
    RemainingLife
        Median and interval of the distribution from the last inspection on [h].

    Raises
    ------
    Refusal
        Fewer than three failed bearings, invalid hours and severities, or numbers beyond the range of the calculation.

    Examples
    --------
    >>> failed = [([0.0, 100.0, 200.0], [1.2, 2.0, 4.0]), ([0.0, 150.0, 300.0], [1.2, 2.1, 5.0]), ([0.0, 120.0, 240.0], [1.3, 1.9, 4.5])]
    >>> life = update_remaining_life([0.0, 60.0], [1.2, 1.5], failed)
    >>> life.low < life.median < life.high
    True
    """
    if len(failed) < FEWEST_LIVES:
        raise Refusal(f"{len(failed)} failed bearings give no distribution of lives: give at least {FEWEST_LIVES}")
    known = [_history(times, levels, 2, f"failed bearing {number}") for number, (times, levels) in enumerate(failed, 1)]
    time, level = _history(hours, severity, 1, "the bearing")
    lives = np.array([times[-1] for times, _ in known])
    courses = np.array([np.interp(SHARES, times / times[-1], levels) for times, levels in known])
    grid = np.geomspace(SHORTEST * lives.min(), max(LONGEST * lives.max(), 2.0 * time[-1]), TIMES)
    weight = _prior(np.log(grid), np.log(lives)) + _likelihood(time, level, grid, courses)
    weight[grid <= time[-1]] = -np.inf
    share = np.cumsum(np.exp(weight - weight.max()))
    tails = 0.5 - 0.5 * coverage, 0.5, 0.5 + 0.5 * coverage
    low, median, high = np.maximum(np.interp(np.array(tails) * share[-1], share, grid) - time[-1], 0.0)
    return RemainingLife(float(median), float(low), float(high), coverage)


def _prior(grid: Floats, lives: Floats) -> Floats:
    """Return the logarithm of Student's predictive density of logarithms of lives, up to a constant; shape of ``grid``."""
    count = len(lives)
    spread = max(float(lives.std(ddof=1)), LEAST_SCATTER) * np.sqrt(1.0 + 1.0 / count)
    return np.asarray(-0.5 * count * np.log1p(((grid - lives.mean()) / spread) ** 2 / (count - 1)))


def _likelihood(time: Floats, level: Floats, grid: Floats, courses: Floats) -> Floats:
    """Return the log likelihood of inspections at times [h] for each time to failure of ``grid`` [h], up to a constant."""
    mean = courses.mean(axis=0)
    deviation = np.sqrt(courses.var(axis=0, ddof=1) * (1.0 + 1.0 / len(courses)) + LEAST_DEVIATION**2)
    share = np.minimum(time[:, None] / grid, 1.0)
    spread = np.interp(share, SHARES, deviation)
    away = (level[:, None] - np.interp(share, SHARES, mean)) / spread
    kept = np.exp(-np.diff(share, axis=0) / CORRELATION)
    variance = 1.0 - kept**2 + NUGGET
    steps = (away[1:] - kept * away[:-1]) ** 2 / variance + np.log(variance)
    return np.asarray(-0.5 * (away[0] ** 2 + steps.sum(axis=0)) - np.log(spread).sum(axis=0))


def _history(hours: npt.ArrayLike, severity: npt.ArrayLike, fewest: int, name: str) -> tuple[Floats, Floats]:
    """Return the hours since the first inspection, and the logarithm of the severity."""
    time, level = np.asarray(hours, np.float64), np.asarray(severity, np.float64)
    if time.ndim != 1 or time.shape != level.shape or len(time) < fewest:
        raise Refusal(
            f"{name}: hours of shape {time.shape} and a severity of shape {level.shape}: give one severity for each of at least "
            f"{fewest} inspection(s)"
        )
    if not (np.isfinite(time).all() and np.isfinite(level).all() and (level > 0.0).all()):
        raise Refusal(f"{name}: hours must be finite and severities above 0: leave out inspections without a value")
    if not (np.diff(time) > 0.0).all():
        raise Refusal(f"{name}: the hours of the inspections do not increase: sort the inspections, and give each hour once")
    return time - time[0], np.log(level)
