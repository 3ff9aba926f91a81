"""Remaining life from a trend: what its median and its interval mean."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.stats import binom

from dcrb_ros.prognosis.remaining_life import estimate_remaining_life
from dcrb_ros.schema.refusal import Refusal

TRENDS = 400


@given(st.floats(1e-4, 1.0), st.floats(0.1, 10.0), st.floats(1.5, 50.0), st.integers(3, 40))
def test_a_trend_without_deviations_gives_the_exact_remaining_life(rate: float, first: float, factor: float, count: int) -> None:
    hours = np.linspace(0.0, 1.0 / rate, count)
    limit = first * math.e * factor
    found = estimate_remaining_life(hours, first * np.exp(rate * hours), limit)
    expected = math.log(limit / first) / rate - hours[-1]
    assert found.median == pytest.approx(expected, rel=1e-6, abs=1e-6 / rate)
    assert found.low == pytest.approx(expected, rel=1e-3, abs=1e-3 / rate)
    assert found.high == pytest.approx(expected, rel=1e-3, abs=1e-3 / rate)


@settings(deadline=None, max_examples=15)
@given(
    st.integers(0, 2**31),
    st.integers(4, 30),
    st.floats(0.02, 0.5),
    st.sampled_from([0.5, 0.8, 0.9]),
    st.sampled_from(["linear", "exponential", "hyperbolic"]),
)
@example(1, 4, 0.5, 0.9, "linear")
def test_the_interval_contains_the_remaining_life_as_often_as_it_says(
    seed: int, count: int, deviation: float, coverage: float, growth: Any
) -> None:
    random, hours, true = np.random.default_rng(seed), np.arange(float(count)), 1.6 * count
    contained = 0
    for _ in range(TRENDS):
        level = hours + deviation * random.standard_normal(count)
        severity, limit = {
            "linear": (level, true),
            "exponential": (np.exp(level / count), math.exp(true / count)),
            "hyperbolic": (1.0 / (3.0 * count - level), 1.0 / (3.0 * count - true)),
        }[growth]
        found = estimate_remaining_life(hours, severity, limit, growth=growth, coverage=coverage)
        contained += found.low <= true - hours[-1] <= found.high
    # The probability of being outside of these limits is 2e-9 for each example.
    assert binom.ppf(1e-9, TRENDS, coverage) <= contained <= binom.isf(1e-9, TRENDS, coverage)


@given(
    st.lists(st.floats(0.1, 10.0), min_size=3, max_size=20),
    st.floats(0.1, 100.0),
    st.floats(0.0, 1.0),
    st.sampled_from(["linear", "exponential", "hyperbolic"]),
)
def test_the_median_lies_in_its_interval_and_a_wider_coverage_in_a_wider_one(
    levels: list[float], limit: float, deviation: float, growth: Any
) -> None:
    narrow, wide = (
        estimate_remaining_life(range(len(levels)), levels, limit, growth=growth, coverage=coverage, limit_deviation=deviation)
        for coverage in (0.5, 0.95)
    )
    assert 0.0 <= wide.low <= narrow.low * (1 + 1e-6) + 1e-6
    assert narrow.low <= narrow.median <= narrow.high
    assert wide.high >= narrow.high * (1 - 1e-6) - 1e-6


@given(st.floats(2.0, 50.0), st.floats(0.01, 0.5), st.integers(0, 1000))
def test_a_higher_limit_is_reached_later(limit: float, more: float, seed: int) -> None:
    hours = np.arange(10.0)
    severity = np.exp(0.05 * hours + 0.02 * np.random.default_rng(seed).standard_normal(10))
    sooner, later = (estimate_remaining_life(hours, severity, at) for at in (limit, limit * (1.0 + more)))
    assert sooner.median < later.median
    assert sooner.low < later.low


def test_hyperbolic_growth_ends_where_its_rate_says() -> None:
    hours = np.arange(6.0)
    assert estimate_remaining_life(hours, 1.0 / (20.0 - hours), 1.0 / 5.0, growth="hyperbolic").median == pytest.approx(10.0)


def test_a_level_or_falling_trend_may_last_for_ever() -> None:
    severity = [1.0, 1.2, 0.9, 1.1, 1.0, 1.05]
    assert estimate_remaining_life(range(6), severity, 5.0).high == math.inf
    falling = estimate_remaining_life(range(6), [6.0, 5.0, 4.0, 3.0, 2.1, 1.0], 10.0)
    assert (falling.median, falling.high, falling.low) == (math.inf, math.inf, math.inf)
    below = estimate_remaining_life(range(6), [6.0, 5.0, 4.0, 3.0, 2.1, 1.0], 3.0, growth="linear")  # its mean is above the limit
    assert (below.median, below.high, below.low) == (math.inf, math.inf, math.inf)
    above = estimate_remaining_life(range(6), [6.0, 5.0, 4.0, 3.0, 2.1, 1.0], 0.5, growth="linear")
    assert above.median == 0.0


def test_beyond_the_limit_no_life_remains() -> None:
    found = estimate_remaining_life(range(6), [1.0, 2.0, 3.1, 4.0, 5.1, 6.0], 2.0, growth="linear")
    assert (found.low, found.median, found.high) == (0.0, 0.0, 0.0)


def test_an_uncertain_limit_widens_the_interval() -> None:
    known, uncertain = (estimate_remaining_life(range(5), [1.0, 1.5, 2.2, 3.4, 5.0], 20.0, limit_deviation=by) for by in (0.0, 0.3))
    assert uncertain.low < known.low < known.median == uncertain.median < known.high < uncertain.high


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"hours": [0.0, 1.0], "severity": [1.0, 2.0]}, "2 inspections give no trend"),
        ({"severity": [1.0, 2.0]}, "give one severity for each inspection"),
        ({"hours": [0.0, 2.0, 1.0]}, "do not increase"),
        ({"severity": [1.0, float("nan"), 2.0]}, "must be finite"),
        ({"severity": [1.0, 0.0, 2.0]}, "not above 0"),
        ({"limit": -1.0}, "not above 0"),
        ({"growth": "linaer"}, "did you mean 'linear'"),
        ({"coverage": 1.0}, "coverage = 1 is outside 0 .. 1"),
        ({"limit_deviation": -0.1}, "limit_deviation = -0.1 is not"),
        ({"limit_deviation": 1e200}, "too large, too small or too close together"),
        ({"hours": [0.0, 1.0, 1e200]}, "too large, too small or too close together"),
        ({"hours": [0.0, 1e-200, 2e-200]}, "too large, too small or too close together"),
        ({"severity": [1.0, 2.0, 1e200], "growth": "linear"}, "too large, too small or too close together"),
        ({"severity": [1e-320, 2.0, 4.0], "growth": "hyperbolic"}, "too large, too small or too close together"),
    ],
)
def test_invalid_input_is_refused(changes: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"hours": [0.0, 1.0, 2.0], "severity": [1.0, 2.0, 4.0], "limit": 10.0, **changes}
    with pytest.raises(Refusal, match=words):
        estimate_remaining_life(**given)
