"""How well one table of marks predicts another one: correlations of detectors' marks, and violations of their order.

Each function takes two arrays of shape (detectors, samples) and returns one value for each sample.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import rankdata

from dcrb_ros.schema.arrays import Floats

TIE = 1e-9
"""Difference of marks below which they are equal [-]: means of the same verdicts differ in their last bits."""


def pearson_r(first: Floats, second: Floats) -> Floats:
    """Return Pearson's correlation, the sim-to-real correlation coefficient of Kadian et al. 2020; 0 where one side is constant."""
    return _correlation(first - first.mean(axis=0), second - second.mean(axis=0))


def spearman_rho(first: Floats, second: Floats) -> Floats:
    """Return the correlation of the ranks; 0 where one side has no order."""
    return _correlation(*(rankdata(np.round(values, 9), axis=0) - 0.5 * (len(values) + 1) for values in (first, second)))


def kendall_tau(first: Floats, second: Floats) -> Floats:
    """Return tau-b (Kendall 1945); 0 where one side has no order.

    tau-b is the number of pairs in the same order less that of pairs in opposite order, over the geometric mean of the pairs that are not
    tied on either side.
    """
    above, below = np.triu_indices(len(first), 1)
    return _correlation(_order(first[above] - first[below]), _order(second[above] - second[below]))


def mean_maximum_rank_violation(predicted: Floats, real: Floats) -> Floats:
    r"""Return the mean maximum rank violation (MMRV; Li et al. 2024, SIMPLER), 0 for the same order.

    With real marks R and predicted marks S of N detectors,

    .. math:: \mathrm{MMRV} = \frac1N \sum_i \max_j |R_i - R_j| \, 1[(S_i < S_j) \ne (R_i < R_j)] .
    """
    apart = _order(real[:, None] - real[None])
    violated = (apart < 0.0) != (_order(predicted[:, None] - predicted[None]) < 0.0)
    return np.asarray((np.abs(real[:, None] - real[None]) * violated).max(axis=1).mean(axis=0), np.float64)


def _order(differences: Floats) -> Floats:
    return np.asarray(np.sign(np.where(np.abs(differences) < TIE, 0.0, differences)), np.float64)


def _correlation(first: Floats, second: Floats) -> Floats:
    """Return the correlation of each column of two arrays with zero mean; 0 where one is constant."""
    part, whole = (first * second).sum(axis=0), np.sqrt((first**2).sum(axis=0) * (second**2).sum(axis=0))
    return np.asarray(np.divide(part, whole, out=np.zeros_like(part), where=whole > TIE), np.float64)
