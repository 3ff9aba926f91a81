"""The conformal contact of bars and lands: its mean force over a step, and strikes that keep their energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from dcrb_ros.core.laws.pereira import LARGEST_GAIN, impact_damping, mean_force, pereira_coefficients, pereira_stiffness, step_force
from dcrb_ros.validation.reference.laws import pereira

pytestmark = pytest.mark.kernel

COEFFICIENT, EXPONENT = 4.6e10, 1.213
"""Of a bar 0.1 mm from its roller."""
MASS, STEP = 0.248, 1.0 / 102400.0
# Penetrations of less than an atom's nucleus count as `LEAST_PENETRATION`; a force of 1e-8 N there is not what is tested.
ends = st.floats(-2e-6, 5e-6)


@given(first=ends, last=ends)
def test_mean_force_is_that_of_the_potential(first: float, last: float) -> None:
    force, slope = mean_force(first, last, COEFFICIENT, EXPONENT)
    low, high = sorted((first, last))
    law = quad(lambda depth: COEFFICIENT * max(depth, 0.0) ** EXPONENT, low, high, points=[0.0] if low < 0.0 < high else None)[0]
    assert force * (high - low) == pytest.approx(law, rel=1e-5, abs=1e-12)
    assert force >= 0.0
    assert slope >= -1e-6 * COEFFICIENT ** (1.0 / EXPONENT)


@pytest.mark.parametrize("first", [-1e-6, 0.0, 1e-6, 4e-6])
@pytest.mark.parametrize("last", [5e-7, 2e-6, 5e-6])
def test_the_slope_of_the_mean_force_is_that_over_the_end_of_the_way(first: float, last: float) -> None:
    before, after = (mean_force(first, share * last, COEFFICIENT, EXPONENT)[0] for share in (0.9999, 1.0001))
    assert mean_force(first, last, COEFFICIENT, EXPONENT)[1] == pytest.approx((after - before) / (2e-4 * last), rel=1e-4)


@pytest.mark.parametrize("depth", [1e-7, 2e-6, 5e-6])
def test_a_contact_that_stands_still_has_half_the_slope_of_its_force(depth: float) -> None:
    """The mean over the way moves half as far as its end."""
    force, slope = mean_force(depth, depth, COEFFICIENT, EXPONENT)
    assert force == pytest.approx(COEFFICIENT * depth**EXPONENT, rel=1e-9)
    assert slope == pytest.approx(0.5 * pereira_stiffness(force, COEFFICIENT, EXPONENT), rel=1e-9)


@given(clearance=st.floats(5e-6, 2e-3), depth=st.floats(1e-8, 1e-4))
def test_coefficients_are_those_of_the_reference(clearance: float, depth: float) -> None:
    # Eq. 22 of Fan et al. 2025, in mm, MPa and N; the reference implementation shares no code.
    coefficient, exponent = pereira_coefficients(clearance, 0.048, 114e9)
    force = float(pereira(np.array([depth]), clearance, 0.048, 114e9)[0])
    assert coefficient * depth**exponent == pytest.approx(force, rel=1e-9)
    slope = (coefficient * (1.001 * depth) ** exponent - coefficient * (0.999 * depth) ** exponent) / (0.002 * depth)
    assert pereira_stiffness(force, coefficient, exponent) == pytest.approx(slope, rel=1e-5)


def bounced(speed: float, phase: float, impact_loss: float) -> float:
    """Return the speed with which a roller leaves a bar that it strikes with ``speed`` [m/s]."""
    depth, rate, force, impact = -phase * STEP * speed, speed, 0.0, 0.0
    yielding = 0.5 * STEP / MASS
    for _ in range(200):
        elastic, slope, expected = step_force(depth, rate - yielding * force, force, yielding, STEP, COEFFICIENT, EXPONENT)
        impact = impact or max(rate, 1e-3)
        damping = impact_damping(elastic, expected, impact, impact_loss)
        force = elastic + damping * expected
        mean = (rate - yielding * (elastic - slope * expected)) / (1.0 + yielding * (slope + damping))
        depth, rate = depth + STEP * mean, 2.0 * mean - rate
        if depth <= 0.0 and rate < 0.0:
            return -rate
    raise AssertionError("the roller stays in the bar")


@given(speed=st.floats(2e-3, 0.5), phase=st.floats(0.0, 1.0))
def test_strike_without_loss_gives_back_what_it_took(speed: float, phase: float) -> None:
    # At the default step: the strike lasts three to seven steps, whatever its phase.
    assert bounced(speed, phase, 0.0) ** 2 == pytest.approx(speed**2, rel=2e-3)


@given(speed=st.floats(2e-3, 0.5), phase=st.floats(0.0, 1.0), loss=st.floats(0.02, 0.2))
def test_restitution(speed: float, phase: float, loss: float) -> None:
    # m s' = -F (1 + d s/s_0) integrated over the strike: ln((1 + d)/(1 - d e)) = d (1 + e), Hunt and Crossley 1975.
    exact = brentq(lambda e: math.log((1.0 + loss) / (1.0 - loss * e)) - loss * (1.0 + e), 0.1, 1.0)
    assert bounced(speed, phase, loss) / speed == pytest.approx(exact, abs=0.025)


@given(force=st.floats(1e-3, 1e5), rate=st.floats(-10.0, 10.0), impact=st.floats(1e-3, 10.0), loss=st.floats(0.0, 0.75))
def test_bar_never_pulls(force: float, rate: float, impact: float, loss: float) -> None:
    total = force + impact_damping(force, rate, impact, loss) * rate
    assert -1e-9 * force <= total <= (LARGEST_GAIN + 1e-9) * force
