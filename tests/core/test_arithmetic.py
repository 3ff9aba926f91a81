"""Logarithm and exponential of the kernels against the library's, and the lanes that rollers lie in."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.core import lanes as at
from dcrb_ros.core.arithmetic import exponential, logarithm
from dcrb_ros.core.state import copy_of, empty_state

pytestmark = pytest.mark.kernel


@given(st.floats(1e-300, 1e300))
def test_logarithm(x: float) -> None:
    assert logarithm(x) == pytest.approx(math.log(x), rel=4e-16, abs=3e-16)


@given(st.floats(-699.0, 0.0))
def test_exponential(x: float) -> None:
    assert exponential(x) == pytest.approx(math.exp(x), rel=5e-16)


@pytest.mark.parametrize(("x", "expected"), [(0.0, 1.0), (-701.0, 0.0), (-1e300, 0.0)])
def test_exponential_at_its_ends(x: float, expected: float) -> None:
    assert exponential(x) == expected


def test_views_of_the_lanes_lie_where_the_kernels_look() -> None:
    state = empty_state(2, 16)
    state.roller_velocity[1, 3] = 1.0, 2.0, 3.0
    state.outer_force[1, 3] = 4.0
    lane = 16 + 3
    assert [state.lanes[field + lane] for field in (at.VX, at.VY, at.SPIN, at.OUTER_FORCE)] == [1.0, 2.0, 3.0, 4.0]
    assert np.count_nonzero(state.lanes) == 4
    assert state.lanes.ctypes.data % at.CACHE_LINE == 0


def test_copy_of_a_state_has_a_life_of_its_own() -> None:
    state = empty_state(1, 6)
    state.inner_force[0, 2] = 5.0
    state.load[1] = -7.0
    copy = copy_of(state)
    state.inner_force[0, 2] = state.load[1] = 0.0
    assert (copy.inner_force[0, 2], copy.load[1]) == (5.0, -7.0)
