"""Squeeze film and wedge between a roller and a raceway that do not touch."""

from __future__ import annotations

import itertools
import math

import pytest
from documented_tables import half_unit, rows_of
from hypothesis import given
from hypothesis import strategies as st
from oil_films import FLOODED, MATERIAL, outer_film

from dcrb_ros.core.laws.film import film_damping
from dcrb_ros.core.laws.squeeze import (
    squeeze_at,
    squeeze_coefficient,
    squeeze_damping,
    squeeze_floor,
    squeeze_impulse,
    squeeze_near,
    wedge_energy,
    wedge_force,
)

pytestmark = pytest.mark.kernel

PAGE = "explanation/lubrication.md"
A = 3.40778e-5  # of the outer raceway, VG 100 at 70 deg C: docs/explanation/lubrication.md, "Squeeze film"
LIFT, FILM = 5.4736e-4, 0.8e-6
IMPEDANCE = 17251.0
gaps = st.floats(1e-8, 60e-6)
layers = st.floats(1e-6, 50e-6)


def test_the_constant_of_a_squeezed_line_contact() -> None:
    # Reynolds' equation of a parabolic gap, both sides wet: the integral of 6/(1 + x^2/2)^2 is 3 sqrt(2) pi = 13.3286.
    by_sum = sum(6.0 / (1.0 + 0.5 * (0.01 * n) ** 2) ** 2 * 0.01 for n in range(-5000, 5001))
    assert squeeze_coefficient(1.0, 1.0, 1.0) == pytest.approx(by_sum, rel=1e-5)
    assert outer_film().squeeze == pytest.approx(A, rel=1e-4)


def test_the_page_shows_the_damping() -> None:
    for gap, damping in rows_of(PAGE, "Squeeze film"):
        found = squeeze_at(float(gap) * 1e-6, A, 1e-9, 1.0)
        assert found == pytest.approx(float(damping), abs=10.0 * half_unit(damping))


@given(gaps, layers, st.floats(1e-7, 0.9e-6))
def test_the_impulse_is_the_integral_of_the_damping(gap: float, layer: float, floor: float) -> None:
    # Simpson's rule over pieces in which the damping is smooth
    total = 0.0
    for low, high in ((gap, min(floor, layer)), (max(gap, floor), layer)):
        if high <= low:
            continue
        count = 400
        # Points equally apart in the inverse square root, in which the damping varies evenly.
        ends = [(low**-0.5 + (high**-0.5 - low**-0.5) * n / count) ** -2 for n in range(count + 1)]
        for a, b in itertools.pairwise(ends):
            at = [squeeze_at(g, A, floor, layer) for g in (a, 0.5 * (a + b), b)]
            total += (b - a) / 6.0 * (at[0] + 4.0 * at[1] + at[2])
    assert squeeze_impulse(gap, A, floor, layer) == pytest.approx(total, rel=1e-4, abs=1e-9)


@given(gaps, st.floats(1e-10, 1e-4), st.integers(2, 20), layers)
def test_the_momentum_taken_does_not_depend_on_the_step(gap: float, way: float, pieces: int, layer: float) -> None:
    floor = squeeze_floor(A, IMPEDANCE, layer)
    whole = squeeze_damping(gap, way, A, floor, layer) * way
    part = way / pieces
    taken = sum(squeeze_damping(gap - n * part, part, A, floor, layer) * part for n in range(pieces))
    assert taken == pytest.approx(whole, rel=1e-6, abs=1e-9)


@given(gaps, st.floats(-1e-4, 1e-4), layers)
def test_damping_is_never_negative_nor_above_the_impedance_of_a_blow(gap: float, way: float, layer: float) -> None:
    damping = squeeze_damping(gap, way, A, squeeze_floor(A, IMPEDANCE, layer), layer)
    assert 0.0 <= damping <= IMPEDANCE * (1.0 + 1e-6)
    if way <= 0.0 or gap - way >= layer:
        assert damping == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("layer", [1e-12, 1e-8, 1e-6, 5e-6, FLOODED])
@pytest.mark.parametrize("lubricant", ["vg100", "vg220"])
@pytest.mark.parametrize("temperature", [-20.0, 70.0, 150.0])
@pytest.mark.parametrize("shaft", [0.0, 125.0])
def test_no_layer_makes_a_squeeze_film_stiffer_than_a_blow(layer: float, lubricant: str, temperature: float, shaft: float) -> None:
    film = outer_film(shaft, lubricant=lubricant, temperature=temperature, layer=layer)
    most = math.sqrt(MATERIAL.roller_mass * 1.2e9)
    assert 0.0 <= film.offset <= film.floor <= layer * (1.0 + 1e-12)
    for gap in (-1e-6, 0.0, 0.5 * layer, 0.99 * layer):
        for way in (1e-14, 0.1 * layer, 1e-6):
            assert 0.0 <= film_damping(film, gap, way) <= most * (1.0 + 1e-6)


def test_the_floor_of_a_deep_layer() -> None:
    # docs/explanation/lubrication.md, "Squeeze film": (A/Z)^(2/3) = 1.57 um
    assert squeeze_floor(A, IMPEDANCE, 1.0) == pytest.approx(1.574e-6, rel=1e-3)
    assert squeeze_at(0.0, A, squeeze_floor(A, IMPEDANCE, 5e-6), 5e-6) == pytest.approx(IMPEDANCE, rel=1e-9)


def test_a_still_contact_has_the_damping_of_its_gap() -> None:
    at = squeeze_at(3e-6, A, 1e-6, 20e-6)
    assert squeeze_damping(3e-6, 1e-14, A, 1e-6, 20e-6) == pytest.approx(at, rel=1e-12)
    assert squeeze_damping(3e-6, 1e-10, A, 1e-6, 20e-6) == pytest.approx(at, rel=1e-4)


def test_a_film_without_the_law_does_not_resist_approach() -> None:
    assert film_damping(outer_film(squeeze=False), 3e-6, 1e-7) == 0.0


@given(st.floats(1e-8, 60e-6), layers)
def test_the_wedge_is_the_slope_of_its_energy(gap: float, layer: float) -> None:
    away = 1e-3 * gap
    slope = (wedge_energy(gap - away, LIFT, FILM, layer) - wedge_energy(gap + away, LIFT, FILM, layer)) / (2.0 * away)
    force, stiffness = wedge_force(gap, LIFT, FILM, layer)
    assert slope == pytest.approx(force, rel=2e-3, abs=1e-3)
    assert force >= 0.0
    assert stiffness >= 0.0
    if not (gap - away < FILM < gap + away or gap - away < layer < gap + away):
        change = wedge_force(gap - away, LIFT, FILM, layer)[0] - wedge_force(gap + away, LIFT, FILM, layer)[0]
        assert change / (2.0 * away) == pytest.approx(stiffness, rel=2e-3, abs=1.0)


def test_the_gap_at_which_an_idle_roller_rests() -> None:
    # docs/explanation/lubrication.md, "Wedge": gaps under the centrifugal force of 64.9 N
    for layer, gap in ((2e-6, 1.235e-6), (5e-6, 2.357e-6), (20e-6, 4.845e-6)):
        assert wedge_force(gap, LIFT, FILM, layer)[0] == pytest.approx(64.9, rel=2e-3)


def test_nothing_acts_beyond_the_layer() -> None:
    assert wedge_force(20e-6, LIFT, FILM, 20e-6) == pytest.approx((0.0, 0.0), abs=1e-20)
    assert wedge_energy(25e-6, LIFT, FILM, 20e-6) == pytest.approx(0.0, abs=1e-15)
    assert squeeze_impulse(25e-6, A, 1e-6, 20e-6) == pytest.approx(0.0, abs=1e-12)


@given(layers, st.floats(1.0, 3.0))
def test_there_is_no_force_beyond_the_layer_by_rounding(layer: float, beyond: float) -> None:
    """A contact counts as closed under any force above zero."""
    assert wedge_force(beyond * layer, LIFT, FILM, layer) == (0.0, 0.0)
    assert squeeze_near(beyond * layer, A, FILM, FILM, layer) == 0.0
