"""Statistics of an exam, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, poisson

from dcrb_ros.exam.statistics import characteristic, percentile, rate, share


@given(st.integers(0, 60), st.floats(0.1, 100.0))
def test_the_poisson_interval_has_two_and_a_half_per_cent_on_either_side(count: int, hours: float) -> None:
    found = rate(count, hours)
    assert found.value == pytest.approx(count / hours)
    assert poisson.cdf(count, found.high * hours) == pytest.approx(0.025)
    if count:
        assert poisson.sf(count - 1, found.low * hours) == pytest.approx(0.025)
    else:
        assert found.low == 0.0


@given(st.integers(0, 20), st.floats(0.1, 100.0), st.integers(1, 8))
def test_time_that_is_counted_several_times_makes_no_interval_narrower(count: int, hours: float, repeats: int) -> None:
    once, several = rate(count, hours), rate(repeats * count, repeats * hours, repeats)
    assert several == pytest.approx(once)


@given(st.integers(0, 60), st.integers(0, 60))
def test_the_binomial_interval_has_two_and_a_half_per_cent_on_either_side(count: int, missed: int) -> None:
    of = count + missed
    found = share(count, of)
    if not of:
        assert math.isnan(found.value)
        assert found[1:] == (0.0, 1.0)
        return
    assert found.value == count / of
    assert found.low == 0.0 if not count else binom.sf(count - 1, of, found.low) == pytest.approx(0.025, rel=1e-4)
    assert found.high == 1.0 if not missed else binom.cdf(count, of, found.high) == pytest.approx(0.025, rel=1e-4)


@pytest.mark.parametrize("hours", [0.0, -1.0])
def test_without_healthy_time_the_rate_is_unknown(hours: float) -> None:
    found = rate(0, hours)
    assert math.isnan(found.value)
    assert found[1:] == (0.0, math.inf)


def test_percentiles_lie_between_the_values() -> None:
    assert (percentile([1.0, 2.0, 4.0], 50.0), percentile([0.0, 10.0], 95.0)) == (2.0, 9.5)
    assert math.isnan(percentile([], 50.0))


@given(st.lists(st.integers(0, 5), min_size=1, max_size=20), st.lists(st.integers(0, 5), min_size=1, max_size=20))
def test_the_characteristic_counts_runs_at_or_above_each_threshold(faulty: list[int], healthy: list[int]) -> None:
    found = characteristic([float(score) for score in faulty], [float(score) for score in healthy])
    assert found is not None
    assert found.threshold == sorted({float(score) for score in (*faulty, *healthy)}, reverse=True)
    assert found.true == pytest.approx([0.0, *(np.mean(np.array(faulty) >= at) for at in found.threshold)])
    assert found.false == pytest.approx([0.0, *(np.mean(np.array(healthy) >= at) for at in found.threshold)])
    pairs = [1.0 if a > b else 0.5 if a == b else 0.0 for a in faulty for b in healthy]
    assert found.area == pytest.approx(np.mean(pairs))


def test_scores_of_one_side_only_have_no_characteristic() -> None:
    assert characteristic([], [1.0]) is None
    assert characteristic([1.0], []) is None
