"""Johnson's line contact (Eq. 4 of Fan et al. 2025) and its loss."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.bearing.equilibrium import normal_forces
from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.laws.johnson import johnson_force, johnson_penetration, johnson_stiffness
from dcrb_ros.core.laws.loss import loss_coefficient
from dcrb_ros.core.laws.site import NoMemory
from dcrb_ros.settings.configuration import Configuration

pytestmark = pytest.mark.kernel

PAYLOAD = build_payload(Configuration())
LAW, SITE, NONE = PAYLOAD.normal_law, PAYLOAD.inner, NoMemory()
penetrations = st.floats(1e-10, 1e-4)  # 30 kN press 20 um deep


def test_stiffness_at_30_kn() -> None:
    depth = johnson_penetration(LAW, 30e3, SITE)
    assert johnson_force(LAW, NONE, depth, SITE)[1] == pytest.approx(1.67e9, rel=0.005)  # Eq. 4: pi E* L / (ln(4 pi E* L dR / F) - 2)


@given(penetrations)
def test_force_inverts_equation_4(depth: float) -> None:
    force, _ = johnson_force(LAW, NONE, depth, SITE)
    assert johnson_penetration(LAW, force, SITE) == pytest.approx(depth, rel=5e-12)


@given(penetrations)
def test_stiffness_is_the_slope_of_the_force(depth: float) -> None:
    low, high = johnson_force(LAW, NONE, 0.9999 * depth, SITE)[0], johnson_force(LAW, NONE, 1.0001 * depth, SITE)[0]
    force, stiffness = johnson_force(LAW, NONE, depth, SITE)
    assert stiffness == pytest.approx((high - low) / (2e-4 * depth), rel=1e-5)
    assert johnson_stiffness(LAW, force, SITE) == pytest.approx(stiffness, rel=1e-9)


@given(penetrations)
def test_kernel_agrees_with_lambert_w(depth: float) -> None:
    assert johnson_force(LAW, NONE, depth, SITE)[0] == pytest.approx(float(normal_forces(LAW, np.array(depth), SITE)[0]), rel=5e-12)


@given(penetrations, st.floats(-10.0, 10.0))
def test_a_contact_never_pulls(depth: float, rate: float) -> None:
    force, stiffness = johnson_force(LAW, NONE, depth, SITE)
    damping = loss_coefficient(force, 2.5e-6 * stiffness, rate)
    assert force + damping * rate >= -1e-9 * force
    assert 0.0 <= damping <= 2.5e-6 * stiffness
