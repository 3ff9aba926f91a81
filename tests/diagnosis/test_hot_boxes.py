"""Axles by day and night: tables that repeat the bearing, and hot boxes that the detector finds before a wayside detector."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))

from hot_box_fleet import STEP, Fleet, Growth, Temperatures
from hot_box_heat import HeatTable, heat_table
from hot_boxes import Outcome, faulty_days, healthy_days

import dcrb_ros
from dcrb_ros.bearing.quasi_steady import QuasiSteady
from dcrb_ros.diagnosis.parameters import DetectorParameters

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def configuration() -> dcrb_ros.Configuration:
    return dcrb_ros.load_configuration("healthy", {"thermal.law": "network"})


@pytest.fixture(scope="module")
def table(configuration: dcrb_ros.Configuration) -> HeatTable:
    return heat_table(configuration, "loss")


@pytest.mark.parametrize("loss", [0.0, 0.75, 1.0])
def test_tables_repeat_the_bearing_between_their_points(configuration: dcrb_ros.Configuration, table: HeatTable, loss: float) -> None:
    bearing, one = QuasiSteady(configuration), np.ones(1)
    running, exact, found = bearing.running(100.0, 110e3), [20.0] * 7, np.full((4, 1), 20.0)
    for _ in range(90):
        exact = bearing.after(running, exact, 20.0, loss)
        found = table.after(found, 100.0 * one, 110e3 * one, loss * one, 20.0 * one, one, one, 0.0 * one, 20.0)
    nodes = [bearing.network.inner(0), bearing.network.rollers(0), bearing.network.outer(0), bearing.network.box]
    assert found[:, 0] == pytest.approx([exact[node] for node in nodes], rel=0.02)


def test_a_fleet_is_the_same_for_the_same_seed_and_runs_by_day() -> None:
    one, same, other = Fleet(3, 1, 7), Fleet(3, 1, 7), Fleet(3, 1, 8)
    assert np.array_equal(one.duty.speed, same.duty.speed)
    assert np.array_equal(one.duty.ambient, same.duty.ambient)
    assert not np.array_equal(one.duty.speed, other.duty.speed)
    assert not one.duty.speed[: round(4.9 * 3600.0 / STEP)].any()
    kmh = 3.6 * 0.46 * one.duty.speed[one.duty.speed > 0.0]
    assert 0.6 * 120.0 <= kmh.min() <= kmh.max() <= 200.0


@pytest.fixture(scope="module")
def outcomes(table: HeatTable) -> list[Outcome]:
    """Two axles that lose their lubricant within two hours of their first day."""
    fleet = Fleet(2, 1, 3)
    return faulty_days(fleet, table, Growth(np.full(2, 9.0 * 3600.0), np.full(2, 7200.0), 1.0), DetectorParameters())


def test_the_detector_finds_a_hot_box_before_the_wayside_rule(outcomes: list[Outcome]) -> None:
    assert all(one.wayside < math.inf for one in outcomes)
    assert all(one.lead > 0.0 for one in outcomes)
    assert all(one.hottest > 94.4 for one in outcomes)
    assert not any(one.early for one in outcomes)


def test_healthy_days_raise_no_alarm(table: HeatTable) -> None:
    boxes, hot = healthy_days(Fleet(1, 1, 5), table, DetectorParameters())
    assert len(boxes) == 2
    assert not any(box.alarms for box in boxes)
    assert hot == 0


def test_thermometers_have_noise_steps_and_a_bias() -> None:
    fleet = Fleet(2, 1, 1)
    exact = np.full((fleet.steps, 2, 2), 40.2, np.float32)
    ring, air = fleet.readings(Temperatures(exact, exact))
    assert set(np.unique(ring * 2.0 % 1.0)) == {0.0}
    assert ring.mean() == pytest.approx(40.2, abs=0.02)
    assert (air - fleet.duty.ambient).mean(axis=0) == pytest.approx(fleet.bias, abs=0.02)
