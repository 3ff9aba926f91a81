"""Traction of an oil film: Bair and Winer 1979 within the bristle law."""

from __future__ import annotations

import math

import pytest
from documented_tables import half_unit, rows_of
from hypothesis import given
from hypothesis import strategies as st
from oil_films import SHAFT, inner_film, site_of, speeds, steady
from roelands import viscosity_under

from dcrb_ros.core.laws.film import Film
from dcrb_ros.core.laws.fluid_traction import LEAST_SLIP, characteristic_slip, fluid_coefficient
from dcrb_ros.core.laws.lugre import Bristle, LuGre, lugre_line, lugre_update
from dcrb_ros.core.laws.viscosity import ROELANDS_OFFSET

pytestmark = pytest.mark.kernel

LAW = LuGre(0.05, 0.06, 0.01, 1e5, 0.0133, 0.0, 0.7)
STEP = 1.0 / 102400.0
LIMITING, BOUNDARY = 0.06, 0.12
PAGE = "explanation/lubrication.md"
slips = st.floats(1e-9, 50.0)
forces = st.floats(1.0, 4e4)


def settled(film: Film, slip: float, force: float, rolling: float, steps: int = 6000) -> float:
    """Return the friction coefficient [-] after many steps of constant slip [m/s]."""
    memory, coefficient, site = Bristle(0.0), 0.0, site_of(film, True, force)
    for _ in range(steps):
        offset, slope, kept = lugre_line(LAW, memory, slip, rolling, force, site, STEP)
        before, coefficient = coefficient, offset + slope * slip
        memory = lugre_update(LAW, memory, kept, slip, True, STEP)
        if abs(coefficient - before) < 1e-12 * abs(coefficient):
            break
    return coefficient


@given(slips, slips, st.floats(1e-6, 1e2))
def test_fluid_friction_grows_with_slip_to_its_limit(slip: float, more: float, characteristic: float) -> None:
    less = fluid_coefficient(slip, characteristic, LIMITING)
    assert 0.0 < less <= fluid_coefficient(slip + more, characteristic, LIMITING) * (1.0 + 1e-10)
    assert less <= LIMITING


@given(st.floats(1e-12, 1e3), st.floats(1e-6, 1e2))
def test_fluid_friction_is_bair_and_winers_to_all_digits(slip: float, characteristic: float) -> None:
    assert fluid_coefficient(slip, characteristic, LIMITING) == pytest.approx(-LIMITING * math.expm1(-slip / characteristic), rel=1e-10)


@given(st.floats(1e6, 2e9), st.floats(1e-9, 1e-5))
def test_at_small_slip_the_shear_stress_is_that_of_a_viscous_film(pressure: float, film: float) -> None:
    viscosity, alpha = 0.023227, 1.9222e-8
    offset = math.log(viscosity) + ROELANDS_OFFSET
    characteristic = characteristic_slip(pressure, film, LIMITING, viscosity, offset, alpha * 1.962e8 / offset)
    slip = 1e-4 * characteristic
    stress = fluid_coefficient(slip, characteristic, LIMITING) * pressure
    assert stress == pytest.approx(viscosity_under(viscosity, alpha, pressure) * slip / film, rel=1e-4)


@given(slips, forces)
def test_friction_is_odd_in_slip(slip: float, force: float) -> None:
    film = inner_film()
    forth, back = settled(film, slip, force, speeds()[0], 20), settled(film, -slip, force, speeds()[0], 20)
    assert back == -forth


@given(slips, slips, forces, st.floats(0.0, 200.0))
def test_steady_friction_grows_with_slip_between_that_of_asperities_and_of_the_film(
    slip: float, more: float, force: float, shaft: float
) -> None:
    film = inner_film(shaft)
    low, high = steady(film, slip, force)[1], steady(film, slip + more, force)[1]
    assert 0.0 < low <= high * (1.0 + 1e-10)
    assert high <= BOUNDARY


def test_gross_sliding_has_the_limiting_coefficient() -> None:
    # Asperities carry 0.0044 of 30 kN, docs/explanation/lubrication.md, "Traction".
    assert settled(inner_film(), 1.0, 30e3, speeds()[0]) == pytest.approx(0.0044 * BOUNDARY + 0.9956 * LIMITING, rel=0.03)


def test_the_page_shows_pressure_film_and_slope_of_traction() -> None:
    for kilonewtons, pressure, thickness, share, stiff, characteristic, *_ in rows_of(PAGE, "Traction"):
        force = float(kilonewtons) * 1e3
        film = inner_film(layer=50e-6, boundary_friction=0.06)
        mean = film.pressure * math.sqrt(force)
        assert mean * 1e-6 == pytest.approx(float(pressure), abs=half_unit(pressure))
        found = characteristic_slip(mean, float(thickness) * 1e-6, LIMITING, film.viscosity, film.stiffening, film.exponent)
        assert found == pytest.approx(float(characteristic), rel=0.03)  # of a film of two digits
        assert viscosity_under(film.viscosity, film.exponent * film.stiffening / 1.962e8, mean) == pytest.approx(float(stiff), rel=0.05)
        assert float(share) < 0.005


# lambda/sigma_0 = s_0/mu_L + kappa V/(2 b sigma_0), VG 100 at 70 deg C: viscous and elastic compliance in series, without asperities.
SLOPES = [(65.0, 0.00089989), (300.0, 0.0012765), (1e3, 0.0030879), (3e3, 0.014594), (1e4, 0.26510), (3e4, 8.4571)]


@pytest.mark.parametrize(("force", "slope"), SLOPES)
def test_the_slope_at_rest_is_that_of_viscous_and_elastic_compliance_in_series(force: float, slope: float) -> None:
    # The same numbers, rounded, are in docs/explanation/lubrication.md, "Traction".
    (printed,) = [row[6] for row in rows_of(PAGE, "Traction") if float(row[0]) * 1e3 == force]
    assert slope == pytest.approx(float(printed), abs=half_unit(printed))
    film = inner_film(layer=50e-6, roughness=1e-9)  # smooth: no load on asperities
    slip = 1e-6 * LIMITING / slope
    # sigma_1 adds its damping to that of the film.
    assert settled(film, slip, force, speeds()[0]) / slip == pytest.approx(slope, rel=0.01)


@given(forces, st.floats(1.0, 15.0))
def test_asperities_hold_a_mixed_contact_at_rest(force: float, shaft: float) -> None:
    # Below the bristle's yield, asperities stick: without convection by rolling the bristle keeps the whole slip.
    film = inner_film(shaft, lubricant="grease", temperature=100.0)
    share = steady(film, 1e-9, force)[1] / BOUNDARY
    speed, coefficient = steady(film, 0.0, force)
    assert share > 0.1
    assert speed / coefficient <= LEAST_SLIP / (0.1 * BOUNDARY)


def test_at_standstill_friction_is_that_of_dry_asperities() -> None:
    film = inner_film(0.0)
    for slip in (1e-9, 1e-6, 1e-3, 1.0):
        assert steady(film, slip, 10e3)[1] == pytest.approx(BOUNDARY, rel=1e-3)


def test_reversed_rolling_has_the_same_traction() -> None:
    forth, back = inner_film(SHAFT), inner_film(-SHAFT)
    assert forth == back._replace(direction=-back.direction)
