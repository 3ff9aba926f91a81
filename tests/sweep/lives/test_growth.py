"""Laws of growth: monotone paths from the first to the last width, their medians, and what their constants mean."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest, lognorm

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.lives.growth import GROWTH_LAWS
from dcrb_ros.sweep.lives.growth.exponential import ExponentialGrowth
from dcrb_ros.sweep.lives.growth.gamma_process import GammaGrowth
from dcrb_ros.sweep.lives.growth.paris import ParisGrowth

FIRST, LAST = 0.001, 0.014
LAWS = st.sampled_from(list(GROWTH_LAWS.values()))


@given(LAWS, st.integers(0, 2**31), st.floats(0.0, 1.0))
def test_damage_never_heals_and_ends_at_its_last_width(law: Any, seed: int, scatter: float) -> None:
    time, width = law(scatter=scatter).path(FIRST, LAST, np.random.default_rng(seed))
    assert time[0] == 0.0
    assert (np.diff(time) > 0.0).all()
    assert (np.diff(width) >= 0.0).all()
    assert (width[0], width[-1]) == (pytest.approx(FIRST), pytest.approx(LAST))


@given(LAWS, st.integers(0, 2**31))
def test_equal_random_numbers_give_equal_paths(law: Any, seed: int) -> None:
    one, other = (law().path(FIRST, LAST, np.random.default_rng(seed)) for _ in range(2))
    assert np.array_equal(one.time, other.time)
    assert np.array_equal(one.width, other.width)


@pytest.mark.parametrize("law", [ParisGrowth(), ExponentialGrowth(), GammaGrowth(jumps=400.0)])
def test_the_median_of_the_growth_is_one_with_small_steps(law: Any) -> None:
    random = np.random.default_rng(3)
    ends = [law.path(FIRST, LAST, random).time[-1] for _ in range(2000)]
    # The standard error of the median of a lognormal variable with a deviation of 0.5 is 1.25 * 0.5 / sqrt(2000) = 1.4 %.
    assert np.median(ends) == pytest.approx(1.0, rel=0.06)


def test_large_jumps_make_the_median_of_the_growth_longer_than_that_of_mean_growth() -> None:
    """The first passage is later than 1 with the probability that X(1) ~ Gamma(1, 1) is below 1, which is 1 - 1/e."""
    random = np.random.default_rng(3)
    ends = [GammaGrowth(jumps=1.0, scatter=0.0).path(FIRST, LAST, random).time[-1] for _ in range(2000)]
    assert np.mean(np.array(ends) > 1.0) == pytest.approx(1.0 - np.exp(-1.0), abs=0.04)
    assert np.median(ends) == pytest.approx(1.2, rel=0.05)  # docs/reference/sweeps.md


@pytest.mark.parametrize("exponent", [-1.0, 0.0, 1.0, 1.5, 3.0])
def test_without_scatter_the_rate_is_the_power_of_the_width(exponent: float) -> None:
    time, width = ParisGrowth(exponent=exponent, scatter=0.0, noise=0.0).path(FIRST, LAST, np.random.default_rng(0))
    assert time[-1] == pytest.approx(1.0)
    # Central differences are of second order: 2 % of the steepest step of a path with 50.
    rate, middle = np.diff(width) / np.diff(time), np.sqrt(width[1:] * width[:-1])
    slope = np.polyfit(np.log(middle[:40]), np.log(rate[:40]), 1)[0]
    assert slope == pytest.approx(exponent, abs=0.03)


def test_rates_of_exponential_growth_are_lognormal() -> None:
    random = np.random.default_rng(5)
    ends = [ExponentialGrowth(scatter=0.5).path(FIRST, LAST, random).time[-1] for _ in range(2000)]
    assert kstest(ends, lognorm(0.5).cdf).pvalue > 0.01


def test_a_gamma_process_has_the_mean_and_the_variance_of_its_source() -> None:
    law, random = GammaGrowth(power=1.5, jumps=40.0, scatter=0.0), np.random.default_rng(7)
    half = []
    for _ in range(2000):
        time, width = law.path(0.0, 1.0, random)
        half.append(np.interp(0.5, time, width))
    # van Noortwijk 2009: mean t^b, variance t^b / c.
    assert np.mean(half) == pytest.approx(0.5**1.5, rel=0.03)
    assert np.var(half) == pytest.approx(0.5**1.5 / 40.0, rel=0.15)


def test_growth_that_does_not_end_is_refused() -> None:
    slow = ExponentialGrowth.model_construct(law="exponential", scatter=-100.0)
    random = np.random.default_rng(next(seed for seed in range(99) if np.random.default_rng(seed).standard_normal() > 1.0))
    with pytest.raises(Refusal, match="a life cannot end"):
        slow.path(FIRST, LAST, random)
