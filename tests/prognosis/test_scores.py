"""Scores of remaining lives: perfect estimates, asymmetry, monotony, and the half points of the challenge."""

from __future__ import annotations

import math
import warnings

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.prognosis.scores import phm_2008_score, phm_2012_score
from dcrb_ros.schema.refusal import Refusal

LIVES = st.lists(st.floats(1e-3, 1e6), min_size=1, max_size=10)


@given(LIVES)
def test_perfect_estimates_have_the_best_score(lives: list[float]) -> None:
    assert phm_2012_score(lives, lives) == 1.0
    assert phm_2008_score(lives, lives) == 0.0


@given(st.floats(1.0, 1e5), st.floats(1e-3, 0.9))
def test_a_late_warning_costs_more_than_an_early_one(life: float, share: float) -> None:
    early, late = life * (1.0 - share), life * (1.0 + share)
    assert phm_2012_score([life], [late]) < phm_2012_score([life], [early]) < 1.0
    assert phm_2008_score([life], [late], unit=life) > phm_2008_score([life], [early], unit=life) > 0.0


@given(st.floats(1.0, 1e5), st.floats(0.0, 2.0), st.floats(1e-3, 1.0), st.sampled_from([-1.0, 1.0]))
def test_a_larger_error_of_one_sign_has_a_worse_score(life: float, share: float, more: float, sign: float) -> None:
    near, far = life * (1.0 + sign * share), life * (1.0 + sign * (share + more))
    assert phm_2012_score([life], [far]) < phm_2012_score([life], [near])
    assert phm_2008_score([life], [far], unit=life) > phm_2008_score([life], [near], unit=life)


def test_half_points_are_those_of_the_challenge() -> None:
    # Nectoux et al. 2012: one half for an estimate 20 % too short and for one 5 % too long.
    assert phm_2012_score([200.0], [160.0]) == pytest.approx(0.5)
    assert phm_2012_score([200.0], [210.0]) == pytest.approx(0.5)


def test_penalties_are_those_of_the_challenge() -> None:
    # Saxena et al. 2008: exp(-d / 13) - 1 for an early, exp(d / 10) - 1 for a late estimate.
    assert phm_2008_score([50.0], [37.0]) == pytest.approx(math.e - 1.0)
    assert phm_2008_score([50.0], [60.0]) == pytest.approx(math.e - 1.0)


def test_a_bearing_that_is_said_to_live_on_has_the_worst_score() -> None:
    assert phm_2012_score([10.0], [math.inf]) == 0.0
    assert phm_2008_score([10.0], [math.inf]) == math.inf


def test_an_error_beyond_the_range_of_numbers_has_the_worst_score_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert phm_2012_score([1e-320], [90.0]) == 0.0
        assert phm_2008_score([100.0], [190.0], unit=1e-320) == math.inf


@given(LIVES, st.floats(1e-3, 1e3))
def test_the_relative_score_has_no_unit(lives: list[float], unit: float) -> None:
    guess = [1.1 * life for life in lives]
    assert phm_2012_score([unit * life for life in lives], [unit * one for one in guess]) == pytest.approx(phm_2012_score(lives, guess))


@pytest.mark.parametrize(
    ("true", "estimated", "words"),
    [
        ([], [], "at least one"),
        ([1.0], [1.0, 2.0], "one estimate for each"),
        ([1.0], [float("nan")], "NaN"),
        ([0.0], [1.0], "life of 0 is not"),
    ],
)
def test_invalid_input_is_refused(true: list[float], estimated: list[float], words: str) -> None:
    with pytest.raises(Refusal, match=words):
        phm_2012_score(true, estimated)


def test_a_cycle_without_length_is_refused() -> None:
    with pytest.raises(Refusal, match="unit = 0 is not"):
        phm_2008_score([1.0], [1.0], unit=0.0)


@pytest.mark.parametrize("estimate", [1.0, math.inf])
def test_the_penalty_of_a_bearing_that_never_fails_is_refused(estimate: float) -> None:
    with pytest.raises(Refusal, match="true remaining life is infinite"):
        phm_2008_score([10.0, math.inf], [10.0, estimate])
