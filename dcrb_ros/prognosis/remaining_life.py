"""Remaining life from the trend of a severity: a baseline against which other methods are measured."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.arguments import checked_arguments, number, numbers, of_type
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal, nearest

FEWEST_INSPECTIONS = 3
"""Fewest inspections to which a trend with an interval is fitted [-]."""
Growth = Literal["exponential", "linear", "hyperbolic"]


def operating_hours(name: str, value: Any) -> None:
    """Refuse what is not an array of numbers, with a remedy for dates."""
    if getattr(getattr(value, "dtype", None), "kind", "") in ("m", "M"):
        raise Refusal(f"{name} is an array of dates or times: give hours as numbers, such as (dates - dates[0]) / np.timedelta64(1, 'h')")
    numbers(name, value)


def probability(name: str, value: Any) -> None:
    """Refuse what is not a probability between 0 and 1."""
    number(name, value)
    if not 0.0 < value < 1.0:
        raise Refusal(f"{name} = {value:g} is outside 0 .. 1, both excluded: give a probability such as 0.9")


@dataclass(frozen=True)
class RemainingLife:
    """An estimate of the remaining life with its interval."""

    median: float
    """Hours until the trend reaches the limit [h]; infinite if it does not rise."""
    low: float
    """Lower end of the interval, 0 at least [h]."""
    high: float
    """Upper end of the interval [h]; infinite if the trend may as well be level."""
    coverage: float
    """Probability with which the interval contains the remaining life [-]."""


@checked_arguments(hours=operating_hours, severity=numbers, limit=number, growth=of_type(str), coverage=probability, limit_deviation=number)
def estimate_remaining_life(
    hours: npt.ArrayLike,
    severity: npt.ArrayLike,
    limit: float,
    *,
    growth: Growth = "exponential",
    coverage: float = 0.9,
    limit_deviation: float = 0.0,
) -> RemainingLife:
    """Return the hours until the trend of a severity reaches its limit, without histories of other bearings.

    With histories of failed bearings, use `update_remaining_life`: trends with bends, such as those of spalls, are extrapolated poorly.

    A straight line y = a + b t is fitted by least squares: to the severity s with linear growth, to ln s with exponential growth,
    ds/dt = b s, and to -1/s with hyperbolic growth, ds/dt = b s^2, which is infinite after a finite time (Voight, A relation to describe
    rate-dependent material failure, Science 243 (1989) 200-203). It reaches the limit l at t = (l - a) / b. The interval is the set of
    times that a test with Student's t does not reject (Fieller 1954; Draper and Smith, Applied Regression Analysis, inverse regression):

        (l - a - b t)^2 <= q^2 [s^2 (1/n + (t - mean)^2 / S_tt) + d^2]

    with the quantile q for n - 2 degrees of freedom, the residual deviation s and the deviation d of the limit. Its coverage is exact for
    a trend of that form with independent normal deviations and a limit that is known (d = 0).

    Parameters
    ----------
    hours
        Operating hours of the inspections since the trend began, shape (inspections,), at least three [h].
    severity
        Severity at each, such as a root mean square or the level of a fault's lines, shape (inspections,); above 0 unless growth is linear.
    limit
        Severity at which the life ends, in the same unit.
    growth
        ``exponential``, ``linear`` or ``hyperbolic``.
    coverage
        Probability with which the interval contains the remaining life, between 0 and 1.
    limit_deviation
        Standard deviation of the limit between bearings, of s, ln s or 1/s as they are fitted.

    Returns
    -------
    RemainingLife
        Median and interval from the last inspection on [h].

    Raises
    ------
    Refusal
        Fewer than three inspections, other values than finite ones, a severity or limit not above 0 unless growth is linear, or numbers
        beyond the range of the calculation.

    Examples
    --------
    >>> found = estimate_remaining_life([0.0, 100.0, 200.0, 300.0], [1.0, 2.1, 3.9, 8.2], 16.0)
    >>> f"{found.median:.0f} h, {found.low:.0f} to {found.high:.0f} h"
    '98 h, 79 to 120 h'
    """
    with representable():
        time, level, target = _checked(hours, severity, limit, growth, limit_deviation)
        life = _crossing(time, level, target, coverage, limit_deviation)
        if math.isnan(life.low + life.median + life.high):
            raise FloatingPointError  # Python's own numbers overflow without an exception
        return life


@contextmanager
def representable() -> Iterator[None]:
    """Refuse numbers so large or so close together that the calculation in the context overflows or divides by zero."""
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except ArithmeticError:
        raise Refusal(
            "hours, severities or deviations are too large, too small or too close together to calculate with: check their units"
        ) from None


def _crossing(time: Floats, level: Floats, target: float, coverage: float, deviation: float) -> RemainingLife:
    from scipy.stats import t as student

    count, centre, now = len(time), float(time.mean()), float(time[-1])
    about = time - centre
    spread = float(about @ about)
    slope, rise = float(about @ level) / spread, target - float(level.mean())
    residual = level - level.mean() - slope * about
    variance = float(residual @ residual) / (count - 2)
    quantile = float(student.ppf(0.5 + 0.5 * coverage, count - 2))
    at_centre, along = variance / count + deviation**2, variance / spread
    clear = slope**2 - quantile**2 * along
    """Above 0 if the slope differs from 0 with the given probability."""
    root = math.sqrt(max(quantile**2 * (along * rise**2 + at_centre * clear), 0.0))
    above, over = slope * (now - centre) - rise, math.sqrt(at_centre + along * (now - centre) ** 2)
    pivot = above / over if over > 0.0 else math.copysign(math.inf, above)
    """Distance of the trend above the limit at the last inspection, over its deviation [-]."""
    rising = slope > 0.0
    median = max(centre + rise / slope - now, 0.0) if rising else (0.0 if above >= 0.0 else math.inf)
    low = 0.0
    if pivot < -quantile and rising:  # in the form without cancellation
        low = max(centre + (rise**2 - quantile**2 * at_centre) / (slope * rise + root) - now, 0.0)
    elif pivot < -quantile:
        low = max(centre + (slope * rise - root) / clear - now, 0.0) if clear < 0.0 else math.inf
    high = math.inf
    if pivot >= quantile:
        high = 0.0
    elif rising and clear > 0.0:
        high = max(centre + (slope * rise + root) / clear - now, 0.0)
    return RemainingLife(median, min(low, median), max(high, median), coverage)


def _checked(hours: npt.ArrayLike, severity: npt.ArrayLike, limit: float, growth: str, deviation: float) -> tuple[Floats, Floats, float]:
    """Return hours, level and limit as they are fitted."""
    growths = get_args(Growth)
    if growth not in growths:
        raise Refusal(f"growth = {growth!r} is not one of {', '.join(growths)}{nearest(str(growth), growths)}")
    if not (deviation >= 0.0 and math.isfinite(deviation)):
        raise Refusal(f"limit_deviation = {deviation:g} is not a finite number from 0 on: give a standard deviation, 0 for a known limit")
    time, level = np.asarray(hours, np.float64), np.asarray(severity, np.float64)
    if time.ndim != 1 or time.shape != level.shape:
        raise Refusal(f"hours of shape {time.shape} and a severity of shape {level.shape} differ: give one severity for each inspection")
    if len(time) < FEWEST_INSPECTIONS:
        raise Refusal(f"{len(time)} inspections give no trend with an interval: wait for at least {FEWEST_INSPECTIONS}")
    if not (np.isfinite(time).all() and np.isfinite(level).all() and math.isfinite(limit)):
        raise Refusal("hours, severity and limit must be finite numbers: leave out inspections without a value")
    if not (np.diff(time) > 0.0).all():
        raise Refusal("the hours of the inspections do not increase: sort the inspections, and give each hour once")
    if growth == "linear":
        return time, level, float(limit)
    if not ((level > 0.0).all() and limit > 0.0):
        least = min(float(level.min()), limit)
        raise Refusal(f"a severity or limit of {least:g} is not above 0, as {growth} growth needs it: give growth='linear', or a level")
    return (time, np.log(level), math.log(limit)) if growth == "exponential" else (time, -1.0 / level, -1.0 / limit)
