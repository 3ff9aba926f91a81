"""Logarithm and exponential of the kernels against the library's."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.core.arithmetic import exponential, logarithm

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
