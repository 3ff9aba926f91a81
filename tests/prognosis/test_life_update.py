"""Remaining life from other lives: the update is exact for bearings that are alike, and its interval is what it says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import binom, multivariate_normal

from dcrb_ros.prognosis.life_update import CORRELATION, LEAST_DEVIATION, NUGGET, _likelihood, update_remaining_life
from dcrb_ros.prognosis.remaining_life import estimate_remaining_life
from dcrb_ros.schema.refusal import Refusal

SHARES = np.linspace(0.0, 1.0, 21)


def life(hours: float, deviation: np.ndarray | float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return a bearing that grows from 1.2 to 12 times its healthy severity with a bend."""
    return hours * SHARES, 1.2 * 10.0 ** (SHARES**2) * np.exp(deviation)


FAILED = [life(hours) for hours in (900.0, 1000.0, 1100.0, 1300.0)]


@pytest.mark.parametrize("hours", [500.0, 1000.0, 2000.0])
def test_the_pace_along_the_same_course_gives_the_remaining_life(hours: float) -> None:
    times, levels = life(hours)
    for now in (14, 17, 19):
        estimate = update_remaining_life(times[: now + 1], levels[: now + 1], FAILED)
        assert estimate.median == pytest.approx(hours - times[now], abs=0.1 * hours)


def test_one_inspection_leaves_the_distribution_of_the_other_lives() -> None:
    logs = np.log([times[-1] for times, _ in FAILED])
    estimate = update_remaining_life([0.0], [1.2], FAILED)
    assert estimate.median == pytest.approx(np.exp(logs.mean()), rel=0.05)
    # Student's t with 3 degrees of freedom: 2.353 at 95 %.
    assert estimate.high == pytest.approx(np.exp(logs.mean() + 2.353 * logs.std(ddof=1) * np.sqrt(1.25)), rel=0.01)


def test_inspections_are_as_likely_as_their_joint_distribution_says() -> None:
    """A normal distribution of all, whose covariance follows from u_k = rho u_(k-1) + noise of the variance 1 - rho^2 + NUGGET."""
    courses = np.array([np.log(life(1000.0, 0.3 * k * SHARES)[1]) for k in (-1.0, 0.0, 2.0)])
    time, grid = np.array([0.0, 200.0, 250.0, 600.0]), np.array([700.0, 1000.0, 1500.0])
    level = np.log([1.2, 1.4, 1.3, 3.0])
    expected = []
    for hours in grid:
        share = time / hours
        mean = np.interp(share, SHARES, courses.mean(axis=0))
        covariance = np.eye(4)
        for k in range(1, 4):
            rho = np.exp(-(share[k] - share[k - 1]) / CORRELATION)
            covariance[k, :k] = covariance[:k, k] = rho * covariance[k - 1, :k]
            covariance[k, k] = rho**2 * covariance[k - 1, k - 1] + 1.0 - rho**2 + NUGGET
        # The deviation of this bearing from the mean of three others.
        spread = np.interp(share, SHARES, np.sqrt(4.0 / 3.0 * courses.var(axis=0, ddof=1) + LEAST_DEVIATION**2))
        expected.append(multivariate_normal(mean, spread[:, None] * covariance * spread).logpdf(level))
    assert np.diff(_likelihood(time, level, grid, courses)) == pytest.approx(np.diff(expected), rel=1e-9)


def test_a_bearing_that_outlives_all_others_still_has_a_life() -> None:
    estimate = update_remaining_life([0.0, 5e5], [1.2, 1.3], FAILED)
    assert 0.0 <= estimate.low < estimate.median < estimate.high < 1e8


def test_the_interval_contains_the_remaining_life_about_as_often_as_it_says() -> None:
    """Populations as the model describes them: lognormal lives, and deviations correlated along each life."""
    random, inside, trials = np.random.default_rng(5), 0, 300
    distance = np.abs(SHARES[:, None] - SHARES)
    covariance = 0.4**2 * (np.exp(-distance / CORRELATION) + 0.5 * NUGGET * np.eye(len(SHARES)))
    for _ in range(trials):
        bearings = [
            life(1000.0 * np.exp(0.4 * random.standard_normal()), random.multivariate_normal(np.zeros(len(SHARES)), covariance))
            for _ in range(9)
        ]
        times, levels = bearings.pop()
        now = int(random.integers(4, 19))
        estimate = update_remaining_life(times[: now + 1], levels[: now + 1], bearings, coverage=0.8)
        inside += estimate.low <= times[-1] - times[now] <= estimate.high
    # Eight bearings give the deviations roughly: a tenth less or more than stated passes, half of it does not.
    assert binom.ppf(0.001, trials, 0.7) <= inside <= binom.ppf(0.999, trials, 0.9)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"failed": FAILED[:2]}, "2 failed bearings give no distribution of lives: give at least 3"),
        ({"coverage": 1.0}, "coverage = 1 is outside 0 .. 1"),
        ({"severity": [1.0]}, "the bearing: hours of shape"),
        ({"severity": [1.0, 0.0]}, "the bearing: hours must be finite and severities above 0"),
        ({"hours": [1.0, 1.0]}, "the bearing: the hours of the inspections do not increase"),
        ({"failed": [*FAILED, ([0.0], [1.0])]}, r"failed bearing 5: .* at least 2 inspection"),
        ({"hours": [0.0, 1e308]}, "too large, too small or too close together"),
        ({"failed": [*FAILED, ([0.0, 1e308], [1.0, 2.0])]}, "too large, too small or too close together"),
    ],
)
def test_what_gives_no_estimate_is_refused(changes: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"hours": [0.0, 100.0], "severity": [1.2, 1.3], "failed": FAILED}
    with pytest.raises(Refusal, match=words):
        update_remaining_life(**{**given, **changes})


def test_dates_are_not_taken_for_hours() -> None:
    dates = np.array(["2026-01-01", "2026-01-02", "2026-01-04"], "M8[ns]")
    for times in (dates, dates - dates[0]):
        with pytest.raises(Refusal, match=r"^hours is an array of dates or times: give hours as numbers"):
            update_remaining_life(times, [1.2, 1.3, 1.5], FAILED)
        with pytest.raises(Refusal, match=r"^hours is an array of dates or times"):
            estimate_remaining_life(times, [1.2, 1.3, 1.5], 10.0)
    with pytest.raises(Refusal, match=r"^failed is an array of dates or times"):
        update_remaining_life([0.0], [1.2], [*FAILED, (dates, [1.2, 1.3, 1.5])])
