"""Film of a line contact: Dowson and Toyoda 1979, Dowson and Higginson 1966, Wilson and Sheu 1983, Chevalier et al. 1998."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from documented_tables import half_unit, rows_of
from hypothesis import given
from hypothesis import strategies as st
from oil_films import inner_film, oil, outer_film, speeds

from dcrb_ros.core.laws.film import thickness_under
from dcrb_ros.core.laws.film_thickness import asperity_share, central_per_load, inlet_heating, minimum_per_load, power, starved
from dcrb_ros.core.laws.lubricants import LAYERS

pytestmark = pytest.mark.kernel

PAGE = "explanation/lubrication.md"
positive = st.floats(1e-9, 1e-3)


def test_the_film_of_the_loaded_roller() -> None:
    # docs/explanation/lubrication.md, "Film thickness": VG 100 at 70 deg C, 1200 rpm, 30 251 N at the inner raceway
    assert thickness_under(inner_film(), 30251.0) == pytest.approx(0.7027e-6, rel=1e-4)
    # Dowson and Toyoda's formula by hand, for U = 4.645e-11, G = 4383, W = 2.193e-4 and R = 12.603 mm
    by_hand = 3.06 * 12.603e-3 * 4.64487e-11**0.69 * 4382.98**0.56 * 2.19308e-4**-0.10
    assert by_hand == pytest.approx(0.72725e-6, rel=1e-4)
    length = 0.048
    modulus = 30251.0 / (length * 12.603e-3 * 2.19308e-4)
    found = central_per_load(4.64487e-11, 4382.98, modulus, 12.603e-3, length) * 30251.0**-0.10
    assert found == pytest.approx(by_hand, rel=1e-9)


@pytest.mark.parametrize(("law", "speed", "material", "load"), [(central_per_load, 0.69, 0.56, 0.10), (minimum_per_load, 0.70, 0.54, 0.13)])
def test_the_exponents_of_speed_material_and_load(law: object, speed: float, material: float, load: float) -> None:
    assert callable(law)
    at = law(1e-11, 4000.0, 2e11, 0.01, 0.05)
    assert law(2e-11, 4000.0, 2e11, 0.01, 0.05) / at == pytest.approx(2.0**speed, rel=1e-12)
    assert law(1e-11, 8000.0, 2e11, 0.01, 0.05) / at == pytest.approx(2.0**material, rel=1e-12)
    # The force enters as F^-load outside of this factor, times the reference E' R L.
    assert law(1e-11, 4000.0, 4e11, 0.01, 0.05) / at == pytest.approx(2.0**load, rel=1e-12)


@given(positive, positive)
def test_a_starved_film_is_thinner_than_the_flooded_one_and_than_the_layer(flooded: float, layer: float) -> None:
    film = starved(flooded, layer)
    assert 0.0 < film <= min(flooded, layer)
    assert film >= min(flooded, layer) / math.sqrt(2.0) * (1.0 - 1e-12)


def test_starvation_has_both_limits() -> None:
    assert starved(1e-6, 1.0) == pytest.approx(1e-6, rel=1e-9)
    assert starved(1.0, 1e-6) == pytest.approx(1e-6, rel=1e-9)


@given(st.floats(0.0, 20.0), st.floats(0.0, 1.0))
def test_asperities_carry_less_under_a_thicker_film(ratio: float, more: float) -> None:
    assert 0.0 <= asperity_share(ratio + more) <= asperity_share(ratio) <= 1.0


def test_asperities_carry_all_without_a_film_and_next_to_nothing_under_a_thick_one() -> None:
    assert asperity_share(0.0) == pytest.approx(1.0, abs=1e-9)
    # Zhou and Hoeprich 1991 by hand: exp(-1.8 3^1.2)
    assert asperity_share(3.0) == pytest.approx(math.exp(-1.8 * 3.0**1.2), rel=1e-9)


@given(st.floats(0.0, 1e3))
def test_a_heated_inlet_makes_the_film_thinner(number: float) -> None:
    assert 0.0 < inlet_heating(number) <= 1.0


@given(st.floats(1e-12, 1e12), st.floats(-2.0, 2.0))
def test_powers_are_those_of_python(base: float, exponent: float) -> None:
    assert power(base, exponent) == pytest.approx(base**exponent, rel=1e-12)


def test_the_page_shows_the_films() -> None:
    for name, temperature, _, _, _, inner, outer, ratio, share in rows_of(PAGE, "Film thickness"):
        parameters: dict[str, Any] = {"lubricant": name, "temperature": float(temperature), "layer": LAYERS[name]}
        film = thickness_under(inner_film(**parameters), 30e3)
        assert film * 1e6 == pytest.approx(float(inner), abs=half_unit(inner))
        assert thickness_under(outer_film(**parameters), 30e3) * 1e6 == pytest.approx(float(outer), abs=half_unit(outer))
        assert film / 2.8e-7 == pytest.approx(float(ratio), abs=half_unit(ratio))
        assert asperity_share(film / 2.8e-7) == pytest.approx(float(share), abs=half_unit(share))


def test_the_page_shows_the_films_over_speed() -> None:
    for rpm, *cells in rows_of(PAGE, "Film over speed"):
        for name, cell in zip(("grease", "vg100", "vg220"), cells, strict=True):
            thickness, share = cell.rstrip(")").split(" (")
            film = thickness_under(inner_film(float(rpm) * math.pi / 30.0, lubricant=name, temperature=60.0, layer=LAYERS[name]), 30e3)
            assert film * 1e6 == pytest.approx(float(thickness), abs=half_unit(thickness))
            assert asperity_share(film / 2.8e-7) == pytest.approx(float(share), abs=half_unit(share))


@pytest.mark.parametrize(("force", "least", "most"), [(1e3, 0.04, 0.09), (3e3, 0.11, 0.17), (1e4, 0.21, 0.27), (3e4, 0.30, 0.36)])
def test_the_film_exceeds_that_of_pan_and_hamrock_as_documented(force: float, least: float, most: float) -> None:
    """docs/explanation/lubrication.md, "Limits": Pan and Hamrock 1989, J. Tribol. 111:246, h_c/R = 2.922 U^0.692 G^0.470 W^-0.166."""
    excess = []
    for lubricant, temperature, rpm in itertools.product(LAYERS, (40.0, 100.0), (300.0, 2500.0)):
        law = oil(lubricant=lubricant, temperature=temperature)
        for raceway, speed in zip((law.inner, law.outer), speeds(rpm * math.pi / 30.0), strict=True):
            group, reference = raceway.viscosity * speed / (law.modulus * raceway.radius), law.modulus * raceway.radius * law.length
            film = central_per_load(group, raceway.material, law.modulus, raceway.radius, law.length) * force**-0.10
            other = 2.922 * raceway.radius * group**0.692 * raceway.material**0.470 * (force / reference) ** -0.166
            excess.append(film / other - 1.0)
    assert (round(min(excess), 2), round(max(excess), 2)) == (least, most)
