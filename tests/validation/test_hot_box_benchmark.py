"""The trial of hot boxes, `benchmarks/hot_boxes.py`: its tables of heat, and the wayside detector at both sides of an axle."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hot_box_fleet import Fleet, Temperatures
from hot_box_heat import heat_table
from hot_boxes import wayside_alarm

from dcrb_ros.bearing.quasi_steady import QuasiSteady
from dcrb_ros.settings.files import load_configuration

AMBIENT = 20.0


@pytest.mark.slow
@pytest.mark.parametrize(("losses", "error"), [((0.0,), 0.03), ((0.6, 0.89, 0.952, 1.0), 0.06)])
def test_boxes_have_the_temperatures_of_steady_running(losses: tuple[float, ...], error: float) -> None:
    """docs/results/thermal.md: ring and box within 3 % of `QuasiSteady` while healthy, within 6 % with a loss of lubricant."""
    c = load_configuration("healthy", {"thermal.law": "network"})
    table, steady = heat_table(c, "loss"), QuasiSteady(c)
    cases = list(itertools.product((40.0, 75.0, 120.0), (80e3, 100e3, 115e3), losses))
    speed, load, loss = np.array(cases).T
    temperatures, usual = np.full((4, len(cases)), AMBIENT), np.ones(len(cases))
    for _ in range(600):
        temperatures = table.after(temperatures, speed, load, loss, AMBIENT * usual, usual, usual, 0.0 * usual, 60.0)
    network = steady.network
    expected = np.array([steady.steady(steady.running(*case[:2]), case[2]) for case in cases])[:, [network.outer(0), network.box]]
    rise = temperatures[2:].T - AMBIENT
    assert rise == pytest.approx(expected - AMBIENT, rel=error)


def test_a_wayside_detector_judges_both_boxes_of_an_axle() -> None:
    fleet = Fleet(1, 1, 1)
    for hot in (0, 1):
        box = np.repeat(fleet.duty.ambient[:, :, None] + 20.0, 2, axis=2)
        box[:, :, hot] += 100.0
        found = [wayside_alarm(fleet, Temperatures(box, box), 0, 0.0, side) < np.inf for side in (0, 1)]
        assert found == [side == hot for side in (0, 1)]
