"""Resistance of an oil film to rolling: Biboulet and Houpert 2010, Part 1."""

from __future__ import annotations

import math

import pytest
from documented_tables import half_unit, rows_of
from hypothesis import given
from hypothesis import strategies as st
from oil_films import MATERIAL, inner_film, oil, resistance, speeds

from dcrb_ros.core.laws.film import film_at
from dcrb_ros.core.laws.rolling_resistance import directed, flooded_resistance, inlet_cooling, resistance_scale, starvation

pytestmark = pytest.mark.kernel

PAGE = "explanation/lubrication.md"
U, W = 9.28974e-11, 2.19308e-4  # docs/explanation/lubrication.md, "Rolling resistance": VG 100 at 70 deg C, 30 251 N, inner raceway
GROUP = 1.42 * U**0.75


def test_the_resistance_of_the_loaded_roller() -> None:
    modulus = 2.0 * MATERIAL.effective_modulus
    scale = resistance_scale(U, modulus, 12.603e-3, MATERIAL.roller_length)
    assert flooded_resistance(scale, W / math.sqrt(U)) == pytest.approx(6.070, rel=1e-3)


@given(st.floats(1e-12, 1e-8), st.floats(1e-9, 1e-4))
def test_light_loads_follow_their_square_root(speed: float, ratio: float) -> None:
    # Eq. 40: F_R = 1.42 E' R L sqrt(U W) for M = W/sqrt(U) far below one
    load = ratio * math.sqrt(speed)
    assert flooded_resistance(resistance_scale(speed, 1.0, 1.0, 1.0), ratio) == pytest.approx(1.42 * math.sqrt(speed * load), rel=1e-9)


@given(st.floats(1e-12, 1e-8), st.floats(20.0, 1e4))
def test_heavy_loads_do_not_matter(speed: float, ratio: float) -> None:
    # 1.42 * 1.45/1.4 = 1.471, printed 1.47 in the paper
    assert flooded_resistance(resistance_scale(speed, 1.0, 1.0, 1.0), ratio) == pytest.approx(1.4707 * speed**0.75, rel=1e-4)


@given(st.floats(1e-3, 1e3), st.floats(0.0, 10.0))
def test_resistance_does_not_fall_with_load(ratio: float, more: float) -> None:
    assert flooded_resistance(1.0, ratio) <= flooded_resistance(1.0, ratio + more) * (1.0 + 1e-9)


def test_a_starved_inlet_resists_less() -> None:
    # docs/explanation/lubrication.md, "Rolling resistance"
    assert [starvation(s) for s in (1.0, 10.0, 100.0)] == pytest.approx([0.113, 0.525, 0.860], abs=6e-4)
    assert starvation(1e9) == pytest.approx(1.0, rel=1e-6)


@given(st.floats(0.0, 1e3))
def test_a_heated_inlet_resists_less(number: float) -> None:
    assert 0.0 < inlet_cooling(number) <= 1.0


@given(st.floats(-50.0, 50.0))
def test_resistance_opposes_rolling_and_fades_at_standstill(speed: float) -> None:
    assert directed(-speed) == -directed(speed)
    assert directed(speed) * speed >= 0.0
    assert abs(directed(speed)) <= 1.0
    assert directed(0.0) == 0.0


@given(st.floats(0.0, 4e4), st.floats(-50.0, 50.0))
def test_the_resistance_of_a_film_never_drives(force: float, rolling: float) -> None:
    assert resistance(film_at(oil(), 0, rolling), force) * rolling >= 0.0


def test_an_open_contact_and_a_film_without_the_law_do_not_resist() -> None:
    assert resistance(inner_film(), 0.0) == 0.0
    for shaft in (0.0, 5.0, 125.0):
        assert resistance(inner_film(shaft, rolling_resistance=False), 1e4) == 0.0


def test_asperities_add_their_micro_slip() -> None:
    # At standstill asperities carry all: 0.5 * 0.12 * 0.004 of the force, docs/explanation/lubrication.md, "Rolling resistance"
    film = inner_film(0.0)._replace(resistance=0.0, hysteresis=0.0, direction=1.0)
    assert resistance(film, 1e4) == pytest.approx(0.5 * 0.12 * 0.004 * 1e4, rel=1e-3)


def test_the_material_adds_its_hysteresis() -> None:
    # a_v F b/(3 pi R) with b = 0.297 mm under 30 kN at the inner raceway, R = 12.603 mm
    film = inner_film()._replace(resistance=0.0, micro_slip=0.0)
    assert resistance(film, 30e3) == pytest.approx(0.007 * 30e3 * 0.2967e-3 / (3.0 * math.pi * 12.603e-3), rel=2e-3)


def test_the_page_shows_the_resistances() -> None:
    film, oil_of = inner_film(), oil()
    cooling = inlet_cooling(oil_of.inner.heating * speeds()[0] ** 2)
    for kilonewtons, *_, printed in rows_of(PAGE, "Traction"):
        force = float(kilonewtons) * 1e3
        assert flooded_resistance(film.resistance, force * film.by_force) / cooling == pytest.approx(float(printed), abs=half_unit(printed))
