"""Johnson's line contact (Eq. 4 of Fan et al. 2025) and its loss."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.bearing.equilibrium import johnson_forces
from dcrb_ros.core.laws.johnson import johnson_force, johnson_penetration
from dcrb_ros.core.laws.loss import loss_coefficient
from dcrb_ros.settings.parameters import Bearing

pytestmark = pytest.mark.kernel

BEARING = Bearing()
MODULUS = math.pi * BEARING.effective_modulus * BEARING.roller_length
SCALE = 4.0 * (BEARING.inner_raceway_radius + BEARING.roller_radius)
penetrations = st.floats(1e-10, 1e-4)  # 30 kN press 20 um deep


def test_stiffness_at_30_kn() -> None:
    depth = johnson_penetration(30e3, MODULUS, SCALE)
    assert johnson_force(depth, MODULUS, SCALE)[1] == pytest.approx(1.67e9, rel=0.005)  # Eq. 4: pi E* L / (ln(4 pi E* L dR / F) - 2)


@given(penetrations)
def test_force_inverts_equation_4(depth: float) -> None:
    force, _ = johnson_force(depth, MODULUS, SCALE)
    assert johnson_penetration(force, MODULUS, SCALE) == pytest.approx(depth, rel=5e-12)


@given(penetrations)
def test_stiffness_is_the_slope_of_the_force(depth: float) -> None:
    low, high = johnson_force(0.9999 * depth, MODULUS, SCALE)[0], johnson_force(1.0001 * depth, MODULUS, SCALE)[0]
    assert johnson_force(depth, MODULUS, SCALE)[1] == pytest.approx((high - low) / (2e-4 * depth), rel=1e-5)


@given(penetrations)
def test_kernel_agrees_with_lambert_w(depth: float) -> None:
    assert johnson_force(depth, MODULUS, SCALE)[0] == pytest.approx(float(johnson_forces(depth, MODULUS, SCALE)), rel=5e-12)  # type: ignore[arg-type]


@given(penetrations, st.floats(-10.0, 10.0))
def test_a_contact_never_pulls(depth: float, rate: float) -> None:
    force, stiffness = johnson_force(depth, MODULUS, SCALE)
    damping = loss_coefficient(force, 2.5e-6 * stiffness, rate)
    assert force + damping * rate >= -1e-9 * force
    assert 0.0 <= damping <= 2.5e-6 * stiffness
