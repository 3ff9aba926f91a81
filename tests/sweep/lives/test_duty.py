"""Duties: times and revolutions of a line and of a spectrum."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.lives.duty import duty_of_line, duty_of_spectrum
from dcrb_ros.sweep.lives.recipe import Braking, Level, Station

WHEEL = 0.92


def line(*km: float, speed: float = 144.0, **braking: float) -> list[Station]:
    return [Station(name=f"S{k}", km=place, load=1e5, speed_kmh=speed, dwell=0.0) for k, place in enumerate(km)]


def test_a_stretch_is_accelerated_kept_and_braked() -> None:
    # 144 km/h = 40 m/s: 80 s and 1600 m of acceleration, 40 s and 800 m of braking, 2600 m in 65 s at constant speed.
    (only,) = duty_of_line(line(0.0, 5.0), Braking(acceleration=0.5, braking=1.0), WHEEL, "test").sections
    assert 3600.0 * only.steady == pytest.approx(65.0)
    assert 3600.0 * only.total == pytest.approx(185.0)
    assert only.speed == pytest.approx(40.0 / (0.5 * WHEEL))


def test_a_short_stretch_does_not_reach_the_permitted_speed() -> None:
    # v = sqrt(2 s / (1/a + 1/b)) = sqrt(2 * 600 / 3) = 20 m/s.
    (only,) = duty_of_line(line(0.0, 0.6), Braking(acceleration=0.5, braking=1.0), WHEEL, "test").sections
    assert only.speed == pytest.approx(20.0 / (0.5 * WHEEL))
    assert only.steady == pytest.approx(0.0, abs=1e-9)
    assert 3600.0 * only.total == pytest.approx(60.0)


def test_a_dwell_at_the_last_station_is_refused() -> None:
    *before, last = line(0.0, 5.0)
    for dwell in ({}, {"dwell": 0.0}):
        stations = [*before, Station(name="S1", km=last.km, **dwell)]
        assert duty_of_line(stations, Braking(), WHEEL, "test") == duty_of_line([*before, last], Braking(), WHEEL, "test")
    with pytest.raises(Refusal, match="the line ends at S1, so its dwell of 600 s has no effect: leave it out, or add it to that of S0"):
        duty_of_line([*before, Station(name="S1", km=5.0, dwell=600.0)], Braking(), WHEEL, "test")


@given(st.lists(st.floats(0.05, 300.0), min_size=1, max_size=6), st.floats(10.0, 300.0))
def test_the_wheels_turn_once_per_circumference(stretches: list[float], speed: float) -> None:
    places = [sum(stretches[:k]) for k in range(len(stretches) + 1)]
    duty = duty_of_line(line(*places, speed=speed), Braking(), WHEEL, "test")
    assert duty.revolutions_per_hour * duty.hours * math.pi * WHEEL == pytest.approx(1e3 * places[-1], rel=1e-6)
    assert duty.load == pytest.approx(1e5)


def test_a_spectrum_counts_standstill_as_hours_without_revolutions() -> None:
    levels = [Level(name="run", share=0.25, speed_kmh=100.0, load=1e5), Level(name="stand", share=0.75, load=9e5)]
    duty = duty_of_spectrum(levels, WHEEL, "test")
    assert duty.hours == pytest.approx(1.0)
    assert duty.revolutions_per_hour == pytest.approx(0.25 * 1e5 / (math.pi * WHEEL))
    assert duty.load == pytest.approx(1e5)


def test_an_inspection_needs_a_long_enough_stretch() -> None:
    duty = duty_of_line(line(0.0, 5.0, 5.7), Braking(acceleration=0.5, braking=1.0), WHEEL, "test")
    assert [section.name for section in duty.inspected("", 10.0, "test")] == ["S0 - S1"]
    with pytest.raises(Refusal, match="an inspection of 66 s is longer than every stretch at constant speed, 65 s at most"):
        duty.inspected("", 66.0, "test")
    with pytest.raises(Refusal, match="'S9' is no section with a moving vehicle: the duty has S0 - S1, S1 - S2"):
        duty.inspected("S9", 1.0, "test")
