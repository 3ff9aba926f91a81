"""What readings of temperature say: hot, starved, or nothing."""

from __future__ import annotations

import math
from typing import Any

import pytest

from dcrb_ros.diagnosis.heat_monitor import HeatJudgement, HeatMonitor
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.registry import HEAT_RULES

AMBIENT = 20.0
FREQUENCY = 15.0
"""Shaft frequency at which the prior rise holds [Hz]."""
MINUTE = 60.0


def monitor(**parameters: Any) -> HeatMonitor:
    p: Any = DetectorParameters(**parameters)
    return HeatMonitor(p, [rule(p) for rule in HEAT_RULES])


def reason(judgement: HeatJudgement) -> str:
    assert judgement.confirmed is not None
    return judgement.confirmed.reason


def read(judge: HeatMonitor, rise: float, count: int, start: float = 0.0, step: float = MINUTE) -> list[HeatJudgement]:
    """Return the judgements of equal readings."""
    found = [judge.update(start + k * step, FREQUENCY, AMBIENT + rise, AMBIENT) for k in range(count)]
    return [one for one in found if one is not None]


def names(found: list[HeatJudgement]) -> list[str]:
    return [one.confirmed.trouble if one.confirmed else "" for one in found]


@pytest.mark.parametrize(("rise", "verdict"), [(10.0, ""), (27.0, ""), (45.0, ""), (110.0, "overheating")])
def test_without_learning_healthy_axle_boxes_have_10_to_45_kelvin(rise: float, verdict: str) -> None:
    assert names(read(monitor(), rise, 10, step=1.0))[-1] == verdict


def learned(rise: float = 22.0) -> HeatMonitor:
    """Return a monitor that has seen a healthy bearing for a day."""
    judge = monitor()
    assert not any(names(read(judge, rise, 24 * 60)))
    return judge


DAY = 24 * 60 * MINUTE


def test_the_healthy_rise_is_learned() -> None:
    judge = learned(22.0)
    (last,) = read(judge, 22.0, 1, DAY)
    assert last.evidence.expected == pytest.approx(22.0, abs=0.5)
    assert last.evidence.deviation < 4.0
    assert judge.learned <= 24 * 3600.0 + MINUTE


def test_a_hot_bearing_is_confirmed_by_three_readings_and_cleared_by_sixty() -> None:
    judge = learned()
    assert names(read(judge, 50.0, 4, DAY)) == ["", "", "overheating", "overheating"]
    cooled = names(read(judge, 22.0, 60, DAY + 5 * MINUTE))
    assert cooled[:59] == ["overheating"] * 59
    assert cooled[59] == ""


def test_a_starved_bearing_is_too_cool_and_then_hot() -> None:
    judge = learned(40.0)
    found = read(judge, 8.0, 10, DAY)
    assert names(found)[-1] == "lubrication"
    assert "starved films" in reason(found[-1])
    hot = read(judge, 90.0, 10, DAY + 600.0)
    assert names(hot)[-1] == "lubrication"
    assert "too cool before" in reason(hot[-1])


@pytest.mark.parametrize(("pause", "verdict"), [(11.0, "lubrication"), (13.0, "overheating"), (-24.0, "overheating")])
def test_a_hint_of_starved_films_outlasts_a_pause_but_no_reset(pause: float, verdict: str) -> None:
    judge = learned(40.0)
    read(judge, 8.0, 10, DAY)
    assert names(read(judge, 110.0, 10, DAY + pause * 3600.0))[-1] == verdict


def test_a_hint_of_starved_films_is_forgotten_after_half_a_day() -> None:
    judge = learned(40.0)
    read(judge, 8.0, 10, DAY)
    read(judge, 40.0, 13 * 60, DAY + 600.0)
    assert names(read(judge, 90.0, 10, DAY + 600.0 + 13 * 3600.0))[-1] == "overheating"


def test_a_hot_bearing_is_not_learned_as_healthy() -> None:
    judge = monitor()
    read(judge, 22.0, 6 * 60)
    before = judge.model.rise
    read(judge, 80.0, 60, 6 * 3600.0)
    assert judge.model.rise == before


def test_a_time_lapse_makes_the_bearing_as_much_faster() -> None:
    real, fast = monitor(), monitor(heat_time_lapse=200.0)
    one = read(real, 22.0, 30, step=200.0)
    other = read(fast, 22.0, 30, step=1.0)
    assert [a.evidence for a in one] == [b.evidence for b in other]


def test_readings_that_are_no_temperatures_are_counted() -> None:
    judge = monitor()
    assert judge.update(0.0, FREQUENCY, math.nan, AMBIENT) is None
    assert judge.update(1.0, FREQUENCY, 40.0, -273.15) is None
    assert judge.update(2.0, FREQUENCY, 1370.0, AMBIENT) is None
    assert judge.rejected == 3


def test_late_readings_are_ignored_and_a_clock_that_was_set_back_begins_anew() -> None:
    judge = monitor()
    read(judge, 22.0, 10)
    assert judge.update(8 * MINUTE + 58.0, FREQUENCY, 99.0, AMBIENT) is None
    assert judge.update(9 * MINUTE + 30.0, FREQUENCY, 42.0, AMBIENT) is not None
    assert judge.update(0.0, FREQUENCY, 42.0, AMBIENT) is None
    assert judge.update(1.0, FREQUENCY, 42.0, AMBIENT) is not None


def test_a_reading_does_not_count_after_the_clock_was_set_back() -> None:
    judge = monitor()
    read(judge, 110.0, 60)
    last = 59 * MINUTE
    assert judge.judgement_at(last) is judge.judgement_at(last - 600.0) is not None
    assert judge.judgement_at(0.0) is None


def test_after_a_pause_the_bearing_may_have_any_healthy_temperature() -> None:
    judge = learned(22.0)
    assert judge.update(DAY + 7200.0, FREQUENCY, AMBIENT + 2.0, AMBIENT) is None  # it stood, and has cooled down
    assert not any(names(read(judge, 3.0, 10, DAY + 7201.0, step=1.0)))


def test_nothing_is_learned_before_the_beginning_has_died_away() -> None:
    judge = monitor()
    read(judge, 22.0, 30)  # 30 of the 35 minutes in which a fifth of the doubt about the beginning is left at 15 Hz
    assert judge.learned == 0.0
    read(judge, 22.0, 30, 30 * MINUTE)
    assert judge.learned > 0.0


@pytest.mark.parametrize(("rise", "verdict"), [(40.0, ""), (52.0, "overheating"), (65.0, "overheating"), (75.0, "overheating")])
def test_a_bearing_that_is_hot_from_its_first_day_is_found(rise: float, verdict: str) -> None:
    """Up to some 55 K at 15 Hz the rise is learned, and found to be that of no healthy bearing; beyond, it is not learned."""
    found = read(monitor(), rise, 8 * 60)
    assert names(found)[-1] == verdict
    if rise == 52.0:
        assert "a healthy one has 45 K at most: it was hot from the beginning" in reason(found[-1])
        assert not any(names(found)[: 2 * 60])  # before it is known


def test_a_healthy_rise_that_is_given_is_known_without_learning() -> None:
    judge = monitor(heat_learn=0.0, heat_rise_deviation=2.0)
    before = read(judge, 45.0, 60)
    assert before[-1].evidence.usual == 27.5 - 2.0 * 2.0
    assert 3.0 < before[-1].evidence.residual / before[-1].evidence.deviation < 5.0
    assert names(before)[-1] == ""


def test_a_reading_with_an_infinite_load_is_dropped() -> None:
    judge = monitor()
    judge.update(0.0, FREQUENCY, AMBIENT + 110.0, AMBIENT, load=math.inf)
    assert judge.rejected == 1
    assert names(read(judge, 110.0, 10, start=1.0, step=1.0))[-1] == "overheating"
