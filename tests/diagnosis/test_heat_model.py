"""The model of the healthy rise: its steady state, its lag, and what it learns."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dcrb_ros.diagnosis.heat_model import LAG, LAG_AT_REST, OFFSET_DEVIATION, RING_SHARE, HeatModel

HOUR = 3600.0


def steady(frequency: float, load: float = math.nan, *, rise: float = 25.0) -> HeatModel:
    """Return a model that has followed an operation for a day."""
    model = HeatModel(rise, 9.0, 2.0, 0.1)
    model.follow(frequency, load, 0.0, 0.0)
    for _ in range(24):
        model.follow(frequency, load, HOUR, 0.0)
    return model


def test_the_rise_grows_with_speed_and_load() -> None:
    assert steady(15.0).expected == pytest.approx(25.0)
    assert steady(7.5).expected == pytest.approx(25.0 * 0.5**0.7)
    assert steady(-15.0, 100e3).expected == pytest.approx(25.0)
    assert steady(15.0, 50e3).expected == pytest.approx(25.0 * 0.5**0.25)
    assert steady(15.0, -50e3).expected == steady(15.0, 50e3).expected
    assert steady(15.0, 0.0).expected == pytest.approx(25.0 * 0.2, rel=1e-3)
    assert steady(0.0).expected == pytest.approx(0.0, abs=1e-3)


def test_the_box_follows_with_its_lag_and_the_ring_at_once() -> None:
    model = HeatModel(25.0, 9.0, 2.0, 0.1)
    model.follow(15.0, math.nan, 0.0, 25.0 * RING_SHARE)
    model.follow(15.0, math.nan, LAG, 0.0)
    assert model.expected == pytest.approx(25.0 * (RING_SHARE + (1.0 - RING_SHARE) * (1.0 - math.exp(-1.0))))
    cooling = steady(15.0)
    cooling.follow(0.0, math.nan, LAG_AT_REST, 0.0)
    assert cooling.expected == pytest.approx(25.0 * (1.0 - RING_SHARE) * math.exp(-1.0), rel=1e-6)


def test_steps_of_any_length_lead_to_the_same_rise() -> None:
    coarse, fine = steady(15.0), steady(15.0)
    coarse.follow(5.0, math.nan, 600.0, 0.0)
    for _ in range(600):
        fine.follow(5.0, math.nan, 1.0, 0.0)
    assert fine.expected == pytest.approx(coarse.expected, rel=1e-12)
    assert fine.deviation == pytest.approx(coarse.deviation, rel=1e-12)


def test_it_begins_at_the_temperature_that_it_finds_unless_that_is_not_healthy() -> None:
    warm, hot = HeatModel(25.0, 9.0, 2.0, 0.1), HeatModel(25.0, 9.0, 2.0, 0.1)
    warm.follow(15.0, math.nan, 0.0, 18.0)
    hot.follow(15.0, math.nan, 0.0, 90.0)
    assert warm.expected == pytest.approx(18.0)
    assert hot.expected < 30.0
    assert not warm.known


def test_learning_is_bayesian_linear_regression() -> None:
    """Against the posterior of all observations at once (Bishop 2006, eq. 3.50 and 3.51), with a constant error."""
    model = HeatModel(25.0, 9.0, 2.0, 0.0)
    model.follow(12.0, math.nan, 0.0, 10.0)
    rows, rises, deviations = [], [], []
    random = np.random.default_rng(1)
    for frequency in (12.0, 5.0, 18.0, 9.0, 15.0):
        for _ in range(5):
            model.follow(frequency, math.nan, HOUR, 0.0)
        heat = (model.expected - model.offset) / model.rise
        rows.append([1.0, heat])
        rises.append(3.0 + 18.0 * heat + random.standard_normal())
        deviations.append(2.0 * model._stray)
        model.learn(rises[-1], HOUR)
    design, weight = np.array(rows), np.diag(np.array(deviations) ** -2.0)
    prior = np.diag([OFFSET_DEVIATION**-2, 9.0**-2])
    covariance = np.linalg.inv(prior + design.T @ weight @ design)
    mean = covariance @ (prior @ [0.0, 25.0] + design.T @ weight @ np.array(rises))
    assert [model.offset, model.rise] == pytest.approx(mean.tolist(), rel=1e-9)
    heat = (model.expected - model.offset) / model.rise
    expected = (2.0 * model._stray) ** 2 + np.array([1.0, heat]) @ covariance @ np.array([1.0, heat])
    assert model.deviation**2 == pytest.approx(expected, rel=1e-6)


def test_many_readings_within_half_an_hour_are_one_observation() -> None:
    often, once = steady(15.0), steady(15.0)
    for _ in range(1800):
        often.learn(40.0, 1.0)
    once.learn(40.0, 1800.0)
    assert often.rise == pytest.approx(once.rise, rel=0.02)


def test_heat_from_outside_makes_a_larger_error_at_rest() -> None:
    assert steady(0.0).deviation == pytest.approx(math.hypot(2.0 * LAG_AT_REST / LAG, OFFSET_DEVIATION), rel=1e-3)
    # At a third of the speed the air cools by (1/3)^0.8, and heat from outside counts 1.733 times; the rise is (1/3)^0.7 of 25 K.
    assert steady(5.0).deviation == pytest.approx(math.hypot(2.0 * 1.733, 0.1 * 25.0 * 0.4635, OFFSET_DEVIATION, 0.4635 * 9.0), rel=1e-3)
    assert steady(15.0).deviation == pytest.approx(math.hypot(2.0, 0.1 * 25.0, OFFSET_DEVIATION, 9.0), rel=1e-3)


def test_an_unknown_beginning_makes_a_larger_error() -> None:
    model = HeatModel(25.0, 9.0, 2.0, 0.1)
    model.follow(15.0, math.nan, 0.0, 25.0)
    # A deviation of 0.2 of the box's share of 0.7 of 25 K is 3.5 K, which dies away as the box follows.
    assert model.deviation == pytest.approx(math.hypot(2.0, 2.5, OFFSET_DEVIATION, 9.0, 3.5))
    model.follow(15.0, math.nan, LAG, 0.0)
    assert model.deviation == pytest.approx(math.hypot(2.0, 2.5, OFFSET_DEVIATION, 9.0, 3.5 / math.e))
