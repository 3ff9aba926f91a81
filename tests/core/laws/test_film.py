"""The film of a raceway's contacts: its parts together, over speeds, layers and oils."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from oil_films import FLOODED, MATERIAL, inner_film, oil, outer_film, resistance, site_of, steady

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.contacts.force_line import elastic, elastic_and_energy, onset, reach
from dcrb_ros.core.jit import loop
from dcrb_ros.core.laws.dry import NoFilm
from dcrb_ros.core.laws.film import film_at, film_lift, film_reach, thickness_under
from dcrb_ros.core.laws.johnson import Johnson
from dcrb_ros.core.laws.lubricants import LAYERS, LUBRICANTS
from dcrb_ros.core.laws.site import NoMemory, Site, outer_site
from dcrb_ros.settings.configuration import Configuration

pytestmark = pytest.mark.kernel

LAW = build_payload(Configuration()).normal_law
shafts = st.floats(-300.0, 300.0)
layers = st.sampled_from([1e-9, 1e-6, 5e-6, 20e-6, 50e-6, FLOODED])
temperatures = st.floats(-20.0, 150.0)


@loop
def gaps(law: Johnson, site: Site) -> tuple[float, float]:
    """Return the gaps at which the elastic contact closes and at which any force begins [m]."""
    return onset(law, site), reach(law, site)


@loop
def force_at(law: Johnson, penetration: float, site: Site) -> tuple[float, float]:
    """Return force [N] and stiffness [N/m] at a penetration [m]."""
    return elastic(law, NoMemory(), penetration, site)


@loop
def force_and_energy(law: Johnson, penetration: float, site: Site) -> tuple[float, float]:
    """Return force [N] and energy [J] at a penetration [m]."""
    return elastic_and_energy(law, NoMemory(), penetration, site)


@given(shafts, layers, temperatures, st.sampled_from(sorted(LUBRICANTS)), st.floats(0.0, 1e5), st.floats(-20.0, 20.0))
def test_a_film_is_finite_at_every_speed_oil_and_layer(
    shaft: float, layer: float, temperature: float, lubricant: str, force: float, slip: float
) -> None:
    film = inner_film(shaft, lubricant=lubricant, temperature=temperature, layer=layer)
    speed, coefficient = steady(film, slip, force)
    assert all(math.isfinite(value) for value in film)
    assert 0.0 < speed / coefficient < 1e6
    assert math.isfinite(resistance(film, force))
    for gap in (-1e-5, 0.0, film.offset, 0.5 * layer, layer, 1.0):
        assert all(math.isfinite(value) and value >= 0.0 for value in film_lift(film, gap))


@given(st.floats(0.0, 300.0), st.floats(1.0, 100.0), layers)
def test_a_film_grows_with_speed(shaft: float, more: float, layer: float) -> None:
    slow, fast = inner_film(shaft, layer=layer), inner_film(shaft + more, layer=layer)
    assert thickness_under(slow, 1e4) <= thickness_under(fast, 1e4) * (1.0 + 1e-9)


@given(st.floats(1.0, 4e4), st.floats(0.0, 1e4))
def test_a_film_is_thinner_under_more_load(force: float, more: float) -> None:
    film = inner_film()
    assert thickness_under(film, force + more) <= thickness_under(film, force)


@given(st.floats(10.0, 300.0), layers)
def test_a_film_lifts_by_less_than_the_layer_and_reaches_to_its_end(shaft: float, layer: float) -> None:
    film = outer_film(shaft, layer=layer)
    assert 0.0 < film.offset <= film.floor <= layer * (1.0 + 1e-12)
    assert film_reach(film) == layer
    assert gaps(LAW, site_of(film, False)) == (film.offset, layer)


def test_a_layer_thinner_than_its_film_starves_the_contact() -> None:
    # docs/explanation/lubrication.md, "Film thickness": 0.70 um flooded, layers of 0.3, 0.5, 1 and 2 um
    found = [thickness_under(inner_film(layer=layer), 30251.0) * 1e6 for layer in (0.3e-6, 0.5e-6, 1e-6, 2e-6)]
    assert found == pytest.approx([0.28, 0.41, 0.57, 0.66], abs=0.0055)


def test_each_lubricant_has_a_layer_of_its_own() -> None:
    for name, layer in LAYERS.items():
        assert oil(lubricant=name, layer=0.0).layer == layer
        assert oil(lubricant=name, layer=3e-6).layer == 3e-6


def test_two_rollers_have_no_film() -> None:
    film = film_at(oil(), 2, 5.0)
    assert film.offset == film.lift == film.squeeze == 0.0
    assert film_lift(film, 1e-10) == (0.0, 0.0)


@given(st.floats(-60e-6, 30e-6), st.floats(1e-8, 1e-6), st.booleans(), layers)
def test_force_is_the_slope_of_the_energy_of_contact_and_film(penetration: float, away: float, inner: bool, layer: float) -> None:
    film = inner_film(layer=layer) if inner else outer_film(layer=layer)
    site = site_of(film, inner)
    energies = [force_and_energy(LAW, penetration + shift, site)[1] for shift in (-away, away)]
    forces = [force_and_energy(LAW, penetration + shift, site)[0] for shift in (-away, 0.0, away)]
    mean = (energies[1] - energies[0]) / (2.0 * away)
    assert min(forces) * (1.0 - 1e-6) - 1e-3 <= mean <= max(forces) * (1.0 + 1e-6) + 1e-3
    assert force_at(LAW, penetration, site)[0] == pytest.approx(forces[1], rel=1e-9, abs=1e-9)


def test_the_contact_closes_on_its_film() -> None:
    film = outer_film()
    site, dry = site_of(film, False), outer_site(MATERIAL, NoFilm())
    for depth in (1e-6, 5e-6, 20e-6):
        lifted = force_at(LAW, depth - film.offset, site)[0] - film_lift(film, film.offset)[0]
        assert lifted == pytest.approx(force_at(LAW, depth, dry)[0], rel=1e-9)
