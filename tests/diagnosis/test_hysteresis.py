"""Confirmation and release of verdicts, and the trend of the severity."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.diagnosis.hysteresis import Hysteresis, confidence, least_evidence, probability, shortfall, strongest_of
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.trend import Trend

QUIET = {"outer_ring": -5.0, "inner_ring": -5.0, "roller": -5.0, "cage": -5.0}


def test_a_fault_is_confirmed_kept_and_released() -> None:
    hysteresis = Hysteresis(confirm=2, release=3, release_margin=1.0)
    loud, border = {**QUIET, "roller": 2.0}, {**QUIET, "roller": -0.5}
    course = [QUIET, QUIET, loud, loud, border, QUIET, QUIET, border, QUIET, QUIET, QUIET]
    expected = ["waiting", "healthy", "healthy", "roller", *["roller"] * 6, "healthy"]
    assert [hysteresis.verdict(excess) for excess in course] == expected


def test_related_components_confirm_the_one_with_more_evidence() -> None:
    """The lines of a damaged roller that the cage modulates are taken for those of the cage in every other judgement."""
    roller, cage, none = {**QUIET, "roller": 6.0}, {**QUIET, "cage": 4.0}, QUIET
    related = Hysteresis(confirm=2, release=3, release_margin=1.0, related=("roller", "cage"))
    course = (none, none, roller, cage, none, roller, none, none, none)
    assert [related.verdict(excess) for excess in course] == ["waiting", "healthy", "healthy", *["roller"] * 5, "healthy"]
    assert [related.verdict(excess) for excess in (cage, none, roller)] == ["healthy"] * 3
    assert [related.verdict(excess) for excess in (cage, cage)] == ["roller", "cage"]
    alone = Hysteresis(confirm=2, release=3, release_margin=1.0)
    assert [alone.verdict(excess) for excess in (roller, cage, roller, cage)] == ["waiting"] * 4


def test_a_watched_bearing_raises_an_alarm_from_strong_evidence_on() -> None:
    """A recording judged as a whole is named at the threshold, and one below 2.5 s from 1.2 dB on."""
    p = DetectorParameters()
    assert probability(p.alarm_evidence) == pytest.approx(0.9, abs=0.005)
    assert least_evidence(p.confirm, p.window, p.alarm_evidence) == p.alarm_evidence
    assert [least_evidence(1, window, p.alarm_evidence) for window in (2.4, 2.5)] == [1.2, 0.0]
    hysteresis, least = Hysteresis(p.confirm, p.release, p.release_margin, 8), dict.fromkeys(QUIET, p.alarm_evidence)
    assert {hysteresis.verdict({**QUIET, "outer_ring": 2.7}, least) for _ in range(40)} == {"waiting", "healthy"}
    assert [hysteresis.verdict({**QUIET, "outer_ring": 2.9}, least) for _ in range(2)] == ["healthy", "outer_ring"]


@pytest.mark.parametrize(
    ("excess", "component", "sentence"),
    [
        ({}, "outer_ring", "no lines exceed all limits for a defect"),
        ({"cage": 0.24}, "cage", "lines exceed all limits for a defect by 0.2 dB, less than the 5.0 dB required"),
        ({"cage": 4.0, "roller": 2.9}, "roller", "lines that exceed all limits for a defect are not confirmed yet"),
    ],
)
def test_evidence_that_names_no_fault_is_explained(excess: dict[str, float], component: str, sentence: str) -> None:
    found, least = {**QUIET, **excess}, {**dict.fromkeys(QUIET, 2.8), "cage": 5.0}
    strongest = strongest_of(found, least)
    assert (strongest, shortfall(found[strongest], least[strongest])) == (component, sentence)


def test_two_confirmed_faults_are_compound() -> None:
    hysteresis = Hysteresis(confirm=2, release=3, release_margin=1.0)
    both = {**QUIET, "outer_ring": 1.0, "cage": 4.0}
    assert [hysteresis.verdict(both) for _ in range(2)] == ["waiting", "compound"]
    assert hysteresis.confirmed == ["outer_ring", "cage"]


@pytest.mark.parametrize(("excess", "judgements"), [(0.0, 8), (0.7, 7), (1.4, 5), (2.1, 4), (2.8, 2), (9.0, 2)])
def test_weak_evidence_must_last_until_the_window_is_renewed(excess: float, judgements: int) -> None:
    """From 2 judgements at 2.8 dB, where nine of ten alarms are right, to the 8 of a window at the threshold."""
    found = {**QUIET, "inner_ring": excess}
    hysteresis = Hysteresis(confirm=2, release=4, release_margin=1.0, persist=8)
    assert [hysteresis.verdict(found) for _ in range(9)] == ["waiting"] * (judgements - 1) + ["inner_ring"] * (10 - judgements)
    interrupted = [QUIET, QUIET, *[found] * (judgements - 1), {**QUIET, "inner_ring": -0.1}, *[found] * (judgements - 1)]
    hysteresis.reset()
    assert {hysteresis.verdict(evidence) for evidence in interrupted} == {"waiting", "healthy"}


@pytest.mark.parametrize(("excess", "verdict"), [(1.1, "healthy"), (1.3, "inner_ring")])
def test_a_watched_bearing_is_not_named_on_evidence_of_which_many_alarms_are_wrong(excess: float, verdict: str) -> None:
    """However long it lasts: waves of a healthy raceway last, too. It does not keep an alarm either."""
    hysteresis, least = Hysteresis(confirm=2, release=4, release_margin=1.0, persist=8), dict.fromkeys(QUIET, 1.2)
    found = [hysteresis.verdict({**QUIET, "inner_ring": excess}, least) for _ in range(40)]
    assert found[-1] == verdict
    for _ in range(2):
        hysteresis.verdict({**QUIET, "inner_ring": 6.0}, least)
    assert [hysteresis.verdict({**QUIET, "inner_ring": 0.1}, least) for _ in range(5)][1] == "inner_ring"
    assert hysteresis.verdict({**QUIET, "inner_ring": 0.1}, least) == "healthy"


def test_faults_that_explain_each_other_in_turn_are_one() -> None:
    roller, cage = {**QUIET, "roller": 6.5}, {**QUIET, "cage": 6.0}
    hysteresis = Hysteresis(confirm=2, release=4, release_margin=1.0)
    course = [roller, roller, cage, cage, roller, cage, roller, roller]
    assert [hysteresis.verdict(evidence) for evidence in course] == ["waiting", *["roller"] * 7]
    both = {**roller, "cage": 6.0}
    assert [hysteresis.verdict(both) for _ in range(2)] == ["roller", "compound"]


def test_confidence_is_a_half_at_a_threshold_and_rises_with_the_evidence() -> None:
    assert confidence("healthy", [], {**QUIET, "cage": 0.0}) == 0.5
    assert confidence("roller", ["roller"], {**QUIET, "roller": 4.0}) == pytest.approx(0.95)
    assert confidence("waiting", [], QUIET) == confidence("sensor", [], QUIET) == 0.0


def test_the_trend_is_the_growth_in_decibels_per_minute() -> None:
    trend = Trend(60.0, 0.5)
    for k in range(20):
        slope = trend.slope(0.5 * k, "outer_ring", 10.0 ** (0.05 * 0.5 * k))  # 1 dB a second
    assert slope == pytest.approx(60.0)


def test_the_trend_needs_four_points_and_forgets_those_before_its_time() -> None:
    trend = Trend(3.0, 0.5)  # six points
    slopes = [trend.slope(0.5 * k, "cage", 10.0 if k < 6 else 10.0 * 10.0 ** (0.05 * (k - 5))) for k in range(12)]
    assert slopes[:3] == [0.0] * 3
    assert slopes[3] == pytest.approx(0.0, abs=1e-9)
    assert slopes[6] > 0.0
    assert slopes[11] == pytest.approx(120.0)  # 1 dB per half a second
    assert slopes[10] == pytest.approx(120.0, rel=1e-9)  # the last six points are on the line
    assert [trend.slope(6.0 + 0.5 * k, "roller", 2.0**k) for k in range(3)] == [0.0] * 3
    assert trend.slope(7.5, "roller", 8.0) == pytest.approx(60.0 * 20.0 * np.log10(2.0) / 0.5)
    assert trend.slope(8.0, "roller", 0.0) == 0.0
    assert trend.slope(8.5, "roller", 1.0) == 0.0
    short = Trend(0.1, 0.5)
    assert [short.slope(0.5 * k, "cage", 10.0 ** (0.05 * k)) for k in range(4)][3] == pytest.approx(120.0)


def test_the_trend_forgets_a_severity_before_a_pause() -> None:
    trend, pause = Trend(60.0, 0.5), 3600.0
    for k in range(120):
        trend.slope(0.5 * k, "outer_ring", 1.0)
    slopes = [trend.slope(pause + 0.5 * k, "outer_ring", 10.0 ** (0.05 * 0.5 * k)) for k in range(4)]  # 1 dB a second
    assert slopes == pytest.approx([0.0, 0.0, 0.0, 60.0])


def test_the_trend_begins_anew_after_a_restart() -> None:
    trend = Trend(60.0, 0.5)
    for time, severity in [(100.0, 1.0), (100.5, 1.0), (101.0, 1.0), (0.5, 2.0), (1.0, 2.0), (1.5, 2.0), (2.0, 2.0)]:
        assert trend.slope(time, "cage", severity) == pytest.approx(0.0, abs=1e-9)


def test_confidence_is_that_of_the_weakest_confirmed_fault_or_of_the_strongest_suspicion() -> None:
    both = {**QUIET, "outer_ring": 20.0, "cage": 4.0}
    assert confidence("compound", ["outer_ring", "cage"], both) == pytest.approx(0.95)
    assert confidence("healthy", [], {**QUIET, "cage": -3.0}) == pytest.approx(1.0 - 0.5 * 10.0**-0.3)
    assert confidence("cage", ["cage"], {**QUIET, "cage": -2.0}) == 0.5


def test_an_excess_of_zero_counts_and_the_margin_does_not_release() -> None:
    hysteresis = Hysteresis(confirm=2, release=1, release_margin=1.0)
    course = [{**QUIET, "cage": value} for value in (0.0, 0.0, -1.0, -1.01)]
    assert [hysteresis.verdict(excess) for excess in course] == ["waiting", "cage", "cage", "waiting"]


def test_a_suspicion_interrupts_the_way_to_the_first_verdict_only() -> None:
    hysteresis = Hysteresis(confirm=2, release=2, release_margin=1.0)
    loud = {**QUIET, "cage": 1.0}
    assert [hysteresis.verdict(excess) for excess in (QUIET, loud, QUIET, QUIET, loud)] == ["waiting"] * 3 + ["healthy"] * 2
    assert (hysteresis.suspected, hysteresis.confirmed) == (["cage"], [])
    hysteresis.reset()
    assert (hysteresis.suspected, hysteresis.verdict(QUIET)) == ([], "waiting")


def test_a_healthy_verdict_is_never_certain() -> None:
    """A fault that is too faint for every band leaves no evidence, so that no distance from the threshold excludes it."""
    assert confidence("healthy", [], dict.fromkeys(QUIET, -60.0)) == 0.9


@given(st.floats(-60.0, 60.0), st.floats(0.0, 20.0))
def test_the_probability_rises_with_the_evidence(excess: float, more: float) -> None:
    assert 0.1 <= probability(excess) <= probability(excess + more) <= 0.99
