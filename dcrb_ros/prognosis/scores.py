"""Scores of estimated remaining lives, which punish a late warning more than an early one."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.arguments import checked_arguments, number, numbers
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal


@checked_arguments(true=numbers, estimated=numbers)
def phm_2012_score(true: npt.ArrayLike, estimated: npt.ArrayLike) -> float:
    """Return the score of the IEEE PHM 2012 challenge, from 0 to 1 for perfect estimates [-].

    The percent error of each estimate is E = 100 (true - estimated) / true, above 0 for an early warning. The score is the mean of

        A = exp(+ln 0.5 * E / 20) for E > 0, exp(-ln 0.5 * E / 5) for E <= 0

    Estimates that are 20 % too short or 5 % too long score 0.5. Source: Nectoux et al., PRONOSTIA: An experimental platform for
    bearings accelerated degradation tests, IEEE International Conference on Prognostics and Health Management, Denver 2012.

    Parameters
    ----------
    true
        True remaining lives above 0, shape (estimates,), in any unit of time.
    estimated
        Estimated remaining lives in the same unit, shape (estimates,); infinite for a bearing that is not expected to fail.

    Raises
    ------
    Refusal
        No estimates, different shapes, NaN, or a true remaining life that is not above 0, of which no share can be taken.

    Examples
    --------
    >>> phm_2012_score([100.0, 100.0], [80.0, 105.0])
    0.5
    """
    truth, guess = _checked(true, estimated)
    if not ((truth > 0.0) & np.isfinite(truth)).all():
        least = float(truth[~((truth > 0.0) & np.isfinite(truth))][0])
        raise Refusal(f"a true remaining life of {least:g} is not a finite number above 0: leave out estimates made at the end of a life")
    with np.errstate(over="ignore"):  # an estimate that is wrong by many orders of magnitude scores 0
        error = 100.0 * (truth - guess) / truth
    return float(np.mean(np.exp(math.log(2.0) * np.where(error > 0.0, -error / 20.0, error / 5.0))))


@checked_arguments(true=numbers, estimated=numbers, unit=number)
def phm_2008_score(true: npt.ArrayLike, estimated: npt.ArrayLike, *, unit: float = 1.0) -> float:
    """Return the penalty of the PHM 2008 challenge, 0 for perfect estimates and without an upper limit [-].

    With d = (estimated - true) / unit, below 0 for an early warning, it is the sum of

        exp(-d / 13) - 1 for d < 0, exp(d / 10) - 1 for d >= 0

    Source: Saxena, Goebel, Simon and Eklund, Damage propagation modeling for aircraft engine run-to-failure simulation, International
    Conference on Prognostics and Health Management, Denver 2008. There the unit is a flight. The penalty depends on the unit, so state it
    together with the penalty. `phm_2012_score` has no unit.

    Parameters
    ----------
    true
        True remaining lives, finite, shape (estimates,).
    estimated
        Estimated remaining lives in the same unit of time, shape (estimates,); infinite for a bearing that is not expected to fail.
    unit
        Time that counts as one cycle, above 0, in the same unit of time.

    Raises
    ------
    Refusal
        No estimates, different shapes, NaN, an infinite true remaining life, or a unit that is not above 0.

    Examples
    --------
    >>> round(phm_2008_score([100.0, 100.0], [87.0, 110.0]), 3)
    3.437
    """
    truth, guess = _checked(true, estimated)
    if np.isinf(truth).any():
        raise Refusal("a true remaining life is infinite: leave out bearings whose end is unknown")
    if not (unit > 0.0 and math.isfinite(unit)):
        raise Refusal(f"unit = {unit:g} is not a finite number above 0: give the time that counts as one cycle, such as an interval")
    with np.errstate(over="ignore"):  # an estimate that is wrong by thousands of cycles has an infinite penalty
        late = (guess - truth) / unit
        return float(np.sum(np.expm1(np.where(late < 0.0, -late / 13.0, late / 10.0))))


def _checked(true: npt.ArrayLike, estimated: npt.ArrayLike) -> tuple[Floats, Floats]:
    truth, guess = np.asarray(true, np.float64), np.asarray(estimated, np.float64)
    if truth.ndim != 1 or truth.shape != guess.shape or not truth.size:
        raise Refusal(f"lives of shape {truth.shape} and estimates of shape {guess.shape}: give one estimate for each life, at least one")
    if np.isnan(truth).any() or np.isnan(guess).any():
        raise Refusal("NaN is no remaining life: give inf for a bearing that is said to live on, or leave the estimate out")
    return truth, guess
