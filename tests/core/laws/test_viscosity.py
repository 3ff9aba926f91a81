"""Viscosity of oils over temperature (Walther, ASTM D341) and pressure (Roelands 1966)."""

from __future__ import annotations

import math

import pytest
from documented_tables import half_unit, rows_of
from hypothesis import assume, given
from hypothesis import strategies as st
from roelands import viscosity_under

from dcrb_ros.core.laws.lubricants import LUBRICANTS
from dcrb_ros.core.laws.viscosity import (
    Lubricant,
    dynamic_viscosity,
    kinematic_viscosity,
    pressure_coefficient,
    roelands_exponent,
    temperature_coefficient,
    walther_constants,
)

VG100 = LUBRICANTS["vg100"]
lubricants = st.builds(Lubricant, st.floats(20.0, 1000.0), st.floats(4.0, 15.0), st.floats(800.0, 1000.0), st.floats(1e-8, 3e-8))


def test_the_viscosity_of_vg_100_at_70_degrees() -> None:
    # docs/explanation/lubrication.md, "Viscosity"
    assert walther_constants(100.0, 11.2) == pytest.approx((9.1548, 3.5473), abs=6e-5)
    assert dynamic_viscosity(VG100, 70.0) == pytest.approx(23.227e-3, rel=3e-5)


@given(lubricants)
def test_the_given_viscosities_return(lubricant: Lubricant) -> None:
    assume(lubricant.viscosity_40 > lubricant.viscosity_100)
    assert kinematic_viscosity(lubricant, 40.0) == pytest.approx(lubricant.viscosity_40, rel=1e-10)
    assert kinematic_viscosity(lubricant, 100.0) == pytest.approx(lubricant.viscosity_100, rel=1e-10)


@given(lubricants, st.floats(-20.0, 149.0), st.floats(0.1, 50.0))
def test_warmer_oil_is_thinner(lubricant: Lubricant, temperature: float, warmer: float) -> None:
    assume(lubricant.viscosity_40 > lubricant.viscosity_100)
    assert dynamic_viscosity(lubricant, temperature + warmer) <= dynamic_viscosity(lubricant, temperature)


@pytest.mark.parametrize("name", sorted(LUBRICANTS))
@pytest.mark.parametrize("temperature", [-40.0, 20.0, 70.0, 250.0])
def test_the_temperature_coefficient_is_the_slope_of_the_logarithm(name: str, temperature: float) -> None:
    lubricant, away = LUBRICANTS[name], 5.0
    inside = min(max(temperature, -40.0 + away), 250.0 - away)
    ratio = kinematic_viscosity(lubricant, inside - away) / kinematic_viscosity(lubricant, inside + away)
    assert temperature_coefficient(lubricant, inside) == pytest.approx(math.log(ratio) / (2.0 * away), rel=0.01)
    assert temperature_coefficient(lubricant, temperature) > 0.0


@given(st.floats(2e-3, 10.0), st.floats(1e-8, 3e-8))
def test_viscosity_begins_to_rise_with_pressure_as_barus_says(viscosity: float, alpha: float) -> None:
    # Roelands' exponent is chosen so that both have the slope alpha eta at p = 0.
    pressure = 1e3
    assert math.log(viscosity_under(viscosity, alpha, pressure) / viscosity) == pytest.approx(alpha * pressure, rel=1e-4)


@given(st.floats(5e-3, 1.0), st.floats(1e7, 2e9))
def test_viscosity_rises_more_slowly_than_barus_says(viscosity: float, pressure: float) -> None:
    alpha = 2.2e-8
    assume(roelands_exponent(viscosity, alpha) < 1.0)
    assert 0.0 < math.log(viscosity_under(viscosity, alpha, pressure) / viscosity) < alpha * pressure


def test_the_page_shows_the_viscosities() -> None:
    for name, temperature, kinematic, dynamic, alpha, *_ in rows_of("explanation/lubrication.md", "Film thickness"):
        lubricant, t = LUBRICANTS[name], float(temperature)
        assert kinematic_viscosity(lubricant, t) == pytest.approx(float(kinematic), abs=half_unit(kinematic))
        assert dynamic_viscosity(lubricant, t) * 1e3 == pytest.approx(float(dynamic), abs=half_unit(dynamic))
        assert pressure_coefficient(lubricant, t) * 1e9 == pytest.approx(float(alpha), abs=half_unit(alpha))
