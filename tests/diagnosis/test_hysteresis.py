"""Confirmation and release of verdicts, and the trend of the severity."""

from __future__ import annotations

import pytest

from dcrb_ros.diagnosis.hysteresis import Hysteresis, confidence
from dcrb_ros.diagnosis.trend import Trend

QUIET = {"outer_ring": -5.0, "inner_ring": -5.0, "roller": -5.0, "cage": -5.0}


def test_a_fault_is_confirmed_kept_and_released() -> None:
    hysteresis = Hysteresis(confirm=2, release=3, release_margin=1.0)
    loud, border = {**QUIET, "roller": 2.0}, {**QUIET, "roller": -0.5}
    course = [QUIET, QUIET, loud, loud, border, QUIET, QUIET, border, QUIET, QUIET, QUIET]
    expected = ["waiting", "healthy", "healthy", "roller", *["roller"] * 6, "healthy"]
    assert [hysteresis.verdict(excess) for excess in course] == expected


def test_two_confirmed_faults_are_compound() -> None:
    hysteresis = Hysteresis(confirm=2, release=3, release_margin=1.0)
    both = {**QUIET, "outer_ring": 1.0, "cage": 4.0}
    assert [hysteresis.verdict(both) for _ in range(2)] == ["waiting", "compound"]
    assert hysteresis.confirmed == ["outer_ring", "cage"]


def test_confidence_is_a_half_at_a_threshold_and_approaches_one() -> None:
    assert confidence("healthy", [], {**QUIET, "cage": 0.0}) == 0.5
    assert confidence("roller", ["roller"], {**QUIET, "roller": 10.0}) == pytest.approx(0.95)
    assert confidence("waiting", [], QUIET) == confidence("sensor", [], QUIET) == 0.0


def test_the_trend_is_the_growth_in_decibels_per_minute() -> None:
    trend = Trend(60.0, 0.5)
    for k in range(20):
        slope = trend.slope(0.5 * k, "outer_ring", 10.0 ** (0.05 * 0.5 * k))  # 1 dB a second
    assert slope == pytest.approx(60.0)
