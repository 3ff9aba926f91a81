"""Shaft revolutions over time, compared with the simulated speed and with numerical integration."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.exam.exam_file import exam_of
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.revolutions import revolutions

knots = st.lists(
    st.tuples(st.floats(0.0, 10.0), st.floats(-100.0, 100.0)), min_size=1, max_size=6, unique_by=lambda knot: round(knot[0], 3)
)


@given(knots, st.floats(0.0, 10.0), st.floats(0.0, 10.0))
def test_revolutions_are_the_integral_of_the_speed(given_: list[tuple[float, float]], begin: float, end: float) -> None:
    ordered = sorted(given_)
    times = np.linspace(begin, end, 20001)
    speeds = np.abs(np.interp(times, [t for t, _ in ordered], [v for _, v in ordered]))
    expected = float(np.trapezoid(speeds, times)) / (2.0 * math.pi) if end > begin else 0.0
    assert revolutions(ordered, begin, end) == pytest.approx(expected, abs=2e-2)


@given(knots, st.floats(0.0, 5.0), st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_revolutions_add_up(given_: list[tuple[float, float]], begin: float, first: float, second: float) -> None:
    ordered = sorted(given_)
    parts = revolutions(ordered, begin, begin + first) + revolutions(ordered, begin + first, begin + first + second)
    assert revolutions(ordered, begin, begin + first + second) == pytest.approx(parts, abs=1e-9)


def test_without_a_known_speed_nothing_turns() -> None:
    assert Expectation("x", "healthy", 10.0).revolutions(0.0, 10.0) == 0.0
    assert Expectation("x", "healthy", 10.0, tags={"speed": 2.0 * math.pi}).revolutions(1.0, 4.0) == pytest.approx(3.0)


def speeds(**entry: Any) -> Expectation:
    tree = {"exam": "t", "scenarios": [{"name": "x", "verdict": "healthy", "duration": 20.0, **entry}]}
    return exam_of(tree, "t").cases[0].expectation


def test_the_speed_of_a_scenario_follows_its_timeline_at_its_ramp() -> None:
    start = {"operating.speed": 100.0, "operating.speed_ramp": 10.0}
    found = speeds(set=start, timeline=[{"at": 5.0, "set": {"operating.speed": 50.0}}, {"at": 7.0, "set": {"operating.speed": 100.0}}])
    # 100 to 5 s, down to 80 at 7 s, up to 100 at 9 s
    assert found.revolutions(0.0, 20.0) == pytest.approx((100.0 * 20.0 - 0.5 * 4.0 * 20.0) / (2.0 * math.pi))


def test_a_gradual_change_and_a_reversal_are_counted_in_both_directions() -> None:
    found = speeds(set={"operating.speed": 100.0}, timeline=[{"at": 5.0, "over": 10.0, "set": {"operating.speed": -100.0}}])
    assert found.revolutions(0.0, 20.0) == pytest.approx((500.0 + 500.0 + 500.0) / (2.0 * math.pi))
