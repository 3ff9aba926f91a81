"""LuGre friction (Eqs. 6 and 7 of Fan et al. 2025) over one step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.contacts.arrays import no_memory
from dcrb_ros.core.laws.lugre import Bristle, LuGre, bristle_weights, build, convection_rate, lugre_line, lugre_update, stribeck_coefficient
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import material_of

pytestmark = pytest.mark.kernel

PAYLOAD = build_payload(Configuration())
LAW = PAYLOAD.traction_law
MATERIAL = material_of(Configuration().bearing)
STATIC, KINETIC = LAW.static_coefficient, LAW.kinetic_coefficient
slips = st.floats(-20.0, 20.0)


def settled(slip: float, steps: int, law: LuGre = LAW) -> tuple[float, float]:
    """Return bristle [m] and friction coefficient [-] after ``steps`` steps of constant slip [m/s]."""
    memory, coefficient = Bristle(0.0), 0.0
    for _ in range(steps):
        offset, slope, kept = lugre_line(law, memory, slip, None, 0.0, None, PAYLOAD.step)
        coefficient = offset + slope * slip
        memory = lugre_update(law, memory, kept, slip, True, PAYLOAD.step)
    return memory.bristle, coefficient


def test_a_contact_at_which_nothing_has_happened_has_no_bristle() -> None:
    assert no_memory(LAW) == Bristle(0.0)


@given(slips.filter(lambda s: abs(s) > 1e-3))
def test_steady_slip_has_the_stribeck_coefficient(slip: float) -> None:
    expected = math.copysign(stribeck_coefficient(slip, KINETIC, STATIC, LAW.stribeck_speed), slip)
    assert settled(slip, 2000)[1] == pytest.approx(expected, rel=1e-6)


@given(slips, st.integers(1, 50))
def test_friction_stays_inside_its_cone(slip: float, steps: int) -> None:
    bristle, coefficient = settled(slip, steps)
    assert abs(bristle) <= STATIC / LAW.bristle_stiffness * (1.0 + 1e-12)
    assert abs(coefficient) <= STATIC + LAW.bristle_damping * abs(slip)


@pytest.mark.parametrize(("kinetic", "static"), [(0.0, 0.06), (0.0, 0.0)])
@pytest.mark.parametrize("slip", [0.0, 0.3, 20.0])
def test_without_kinetic_friction_gross_sliding_is_free(kinetic: float, static: float, slip: float) -> None:
    constants = build({**LAW._asdict(), "kinetic_coefficient": kinetic, "static_coefficient": static}, MATERIAL)
    assert settled(slip, 200, constants)[1] == pytest.approx(0.0, abs=1e-8)


@given(slips, st.floats(-1.0, 1.0))
def test_friction_opposes_slip_more_as_slip_grows(slip: float, share: float) -> None:
    _, slope, _ = lugre_line(LAW, Bristle(share * STATIC / LAW.bristle_stiffness), slip, None, 0.0, None, PAYLOAD.step)
    assert slope > 0.0  # the implicit update is passive


@given(st.floats(0.0, 1e4))
def test_bristle_never_overshoots(decay: float) -> None:
    phi, psi = bristle_weights(decay)
    assert 0.0 <= 1.0 - decay * phi <= 1.0
    assert 0.0 < psi <= 0.5


def test_bristle_mean_is_second_order() -> None:
    # The exact mean weight of the start over a step is (1 - exp(-x))/x.
    decays = np.array([0.2, 0.1, 0.05, 0.025])
    errors = [abs(bristle_weights(x)[0] - (1.0 - math.exp(-x)) / x) for x in decays]
    slope = np.polyfit(np.log(decays), np.log(errors), 1)[0]
    assert slope > 1.8


def test_stribeck_limits() -> None:
    assert stribeck_coefficient(0.0, KINETIC, STATIC, 0.01) == STATIC
    assert stribeck_coefficient(1.0, KINETIC, STATIC, 0.01) == pytest.approx(KINETIC)


@pytest.mark.parametrize("deflection", [0.0, 3e-7, -2e-7])
@pytest.mark.parametrize("slip", [1e-3, -0.02, 0.5])
def test_a_moving_bristle_adds_its_damping_to_its_stiffness(deflection: float, slip: float) -> None:
    # Fan et al. 2025, Eq. 6, at an instant: sigma_0 z + sigma_1 dz/dt with dz/dt = s - sigma_0 |s|/g(s) z.
    offset, slope, _ = lugre_line(LAW, Bristle(deflection), slip, None, 0.0, None, 1e-12)
    growth = slip - 1e5 * abs(slip) / stribeck_coefficient(slip, KINETIC, STATIC, 0.01) * deflection
    assert offset + slope * slip == pytest.approx(1e5 * deflection + 0.0133 * growth, rel=1e-4)


def test_an_open_contact_forgets_its_bristle() -> None:
    _, _, kept = lugre_line(LAW, Bristle(1e-7), 0.1, None, 0.0, None, PAYLOAD.step)
    assert lugre_update(LAW, Bristle(1e-7), kept, 0.1, False, PAYLOAD.step) == Bristle(0.0)


def test_rolling_convection_gives_carters_creep() -> None:
    # Carter 1926: the slope of friction over creep in a line contact is pi L E* a/2, whatever the friction coefficient.
    bearing, force, rolling = Configuration().bearing, 30e3, 5.7
    law, half_width = LAW._replace(convection=0.7), math.sqrt(PAYLOAD.inner.width * force)
    assert convection_rate(rolling, force, PAYLOAD.inner.width, 0.7) == pytest.approx(0.35 * rolling / half_width)
    slip, memory, coefficient = 1e-6, Bristle(0.0), 0.0
    for _ in range(3000):
        offset, slope, kept = lugre_line(law, memory, slip, rolling, force, PAYLOAD.inner, PAYLOAD.step)
        coefficient, memory = offset + slope * slip, lugre_update(law, memory, kept, slip, True, PAYLOAD.step)
    slope = coefficient * force / (slip / rolling)
    assert slope == pytest.approx(0.5 * math.pi * bearing.roller_length * bearing.effective_modulus * half_width, rel=0.05)


@pytest.mark.parametrize("slip", [-0.02, -0.005, 0.0, 0.005, 0.01, 0.02, 0.03])
def test_the_stribeck_curve_falls_with_the_square_of_the_slip(slip: float) -> None:
    # Fan et al. 2025, Eq. 7: g = mu_k + (mu_s - mu_k) exp(-(s/v_s)^2), here with v_s = 0.01 m/s.
    expected = 0.05 + 0.01 * math.exp(-((slip / 0.01) ** 2))
    assert stribeck_coefficient(slip, 0.05, 0.06, 0.01) == pytest.approx(expected, rel=1e-13)
