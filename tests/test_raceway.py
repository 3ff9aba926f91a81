"""Notches in the raceways (Eqs. 8, 9 and 13 to 15 of Fan et al. 2025)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.core.payload import Notches
from dcrb_ros.core.raceway import inner_notch_depth, notch_under, outer_notch_depth
from dcrb_ros.parameters import Bearing

pytestmark = pytest.mark.kernel

B = Bearing()
R_I, R_O, R_R = B.inner_raceway_radius, B.outer_raceway_radius, B.roller_radius
UNBOUNDED = 1.0


# Sink depths of physics.md section 2, at the middle of the notch.
@pytest.mark.parametrize(
    ("width", "inner", "outer"), [(1e-3, 9.9e-6, 7.2e-6), (2e-3, 39.7e-6, 28.8e-6), (3e-3, 89.4e-6, 64.9e-6), (5e-3, 249e-6, 181e-6)]
)
def test_sink_depth(width: float, inner: float, outer: float) -> None:
    assert inner_notch_depth(0.5 * width / R_I, UNBOUNDED, R_I, R_R)[0] == pytest.approx(inner, rel=0.008)
    assert outer_notch_depth(0.5 * width / R_O, UNBOUNDED, R_O, R_R)[0] == pytest.approx(outer, rel=0.008)


def test_depth_is_bounded_by_the_notch() -> None:
    assert inner_notch_depth(0.03, 1e-4, R_I, R_R) == (1e-4, 0.0)
    assert outer_notch_depth(0.03, 1e-4, R_O, R_R) == (1e-4, 0.0)


def notch(width: float, azimuth: float, raceway: float, row: int = -1) -> Notches:
    return Notches(np.array([row]), np.array([0.5 * width / raceway]), np.array([3e-4]), np.array([azimuth]))


@given(st.floats(-3.0, 3.0), st.floats(-0.02, 0.02), st.floats(-10.0, 10.0))
def test_depth_seen_under_a_turned_ring(azimuth: float, offset: float, turn: float) -> None:
    width = 2e-3
    at = azimuth + turn + offset
    depth, slope = notch_under(notch(width, azimuth, R_I), True, 0, math.sin(at), -math.cos(at), turn, R_I, R_R)
    edge = 0.5 * width / R_I - abs(offset)
    expected = inner_notch_depth(edge, 3e-4, R_I, R_R)[0] if edge > 0.0 else 0.0
    assert depth == pytest.approx(expected, abs=1e-12)
    assert slope * offset <= 1e-12  # deeper towards the middle


def test_slope_is_the_derivative() -> None:
    for raceway, inner in ((R_I, True), (R_O, False)):
        under = notch(3e-3, 0.3, raceway)
        here, step = 0.304, 1e-7
        low, high = (notch_under(under, inner, 0, math.sin(a), -math.cos(a), 0.0, raceway, R_R)[0] for a in (here - step, here + step))
        slope = notch_under(under, inner, 0, math.sin(here), -math.cos(here), 0.0, raceway, R_R)[1]
        assert slope == pytest.approx((high - low) / (2.0 * step), rel=1e-5)


def test_notch_of_one_row_leaves_the_other() -> None:
    under = notch(2e-3, 0.0, R_O, row=1)
    assert notch_under(under, False, 0, 0.0, -1.0, 0.0, R_O, R_R) == (0.0, 0.0)
    assert notch_under(under, False, 1, 0.0, -1.0, 0.0, R_O, R_R)[0] > 0.0
