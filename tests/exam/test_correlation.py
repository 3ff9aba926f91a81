"""Correlations of marks, and violations of their order."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.stats import pearsonr

from dcrb_ros.exam.correlation import kendall_tau, mean_maximum_rank_violation, pearson_r, spearman_rho


def column(*values: float) -> np.ndarray:
    return np.array(values)[:, None]


def test_an_order_that_is_kept_has_no_violation() -> None:
    assert mean_maximum_rank_violation(column(1.0, 2.0, 3.0), column(0.1, 0.5, 0.6))[0] == 0.0


def test_the_violation_is_the_lost_mark_of_the_worst_choice() -> None:
    # The prediction exchanges the first two, which loses 1 for both; the third is below the second in reality and above it predicted.
    assert mean_maximum_rank_violation(column(1.0, 0.0, 0.5), column(0.0, 1.0, 0.4))[0] == pytest.approx((1.0 + 1.0 + 0.6) / 3.0)


@given(arrays(np.int64, (2, 6), elements=st.integers(0, 4)))
def test_the_violation_follows_its_definition(marks: np.ndarray) -> None:
    predicted, real = marks.astype(float)
    expected = np.mean(
        [max(abs(real[i] - real[j]) * ((predicted[i] < predicted[j]) != (real[i] < real[j])) for j in range(6)) for i in range(6)]
    )
    assert mean_maximum_rank_violation(predicted[:, None], real[:, None])[0] == pytest.approx(expected)


@given(arrays(np.int64, (2, 6), elements=st.integers(0, 4)))
def test_srcc_is_pearsons_correlation(marks: np.ndarray) -> None:
    first, second = marks.astype(float)
    found = float(pearson_r(first[:, None], second[:, None])[0])
    if np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        assert found == 0.0
    else:
        assert found == pytest.approx(pearsonr(first, second).statistic, abs=1e-12)


def test_marks_that_differ_by_one_of_many_verdicts_are_not_tied() -> None:
    first, second = column(0.5, 0.5 + 1e-4, 0.5 + 2e-4), column(3.0, 2.0, 1.0)
    assert kendall_tau(first, second)[0] == spearman_rho(first, second)[0] == -1.0


def test_marks_that_differ_in_their_last_bits_are_tied() -> None:
    third = 1.0 / 3.0
    almost = column(third, third + 1e-16, 0.1 + 0.2, 0.3)
    for correlation in (kendall_tau, spearman_rho):
        assert (
            correlation(almost, column(1.0, 2.0, 3.0, 4.0))[0] == correlation(column(third, third, 0.3, 0.3), column(1.0, 2.0, 3.0, 4.0))[0]
        )
