"""The oil at bars and lands, and about the rollers: its formulas against numbers worked out, integrals and limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dcrb_ros.core.laws.cage_oil import LAND_SHARE
from dcrb_ros.core.laws.calls import bar_damping, bar_shear, churning, has_cage_oil, land_damping, land_torque
from dcrb_ros.core.laws.dry import Dry
from dcrb_ros.core.laws.film_with_cages import FilmWithCages, build
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import material_of

RADIUS, LENGTH = 0.015, 0.048  # of a roller, m
VISCOSITY = 23.227e-3  # VG 100 at 70 deg C, Pa s
LAND_RADIUS, LAND_CLEARANCE = 0.10157, 3e-4  # m


def oil(**lubrication: object) -> FilmWithCages:
    given = {"law": "film_with_cages", "lubricant": "vg100", "temperature": 70.0, "land_fill": 1.0, **lubrication}
    made = Configuration.model_validate({"lubrication": given})
    return build(dict(made.lubrication), material_of(made.bearing))


def test_the_damping_at_a_bar_is_that_of_a_plane() -> None:
    """Spec: 863 N s/m at 10 um and 27 at 100 um from a deep layer."""
    deep = oil(pocket_layer=1e-3)
    assert bar_damping(deep, 1e-5) == pytest.approx(863.0, rel=0.005)
    assert bar_damping(deep, 1e-4) == pytest.approx(27.0 * (1.0 - 0.1**1.5), rel=0.02)


@settings(deadline=None)
@given(st.floats(-1e-4, 2e-4), st.floats(0.0, 1e-3), st.sampled_from(["grease", "vg220"]), st.floats(20.0, 100.0))
def test_a_bar_resists_more_the_nearer_it_is_and_never_above_a_blow(gap: float, layer: float, lubricant: str, temperature: float) -> None:
    found = oil(pocket_layer=layer, lubricant=lubricant, temperature=temperature)
    for resistance in (bar_damping, bar_shear):
        near, far = resistance(found, gap), resistance(found, gap + 1e-6)
        assert 0.0 <= far <= near
        assert resistance(found, max(layer, 2e-6)) == pytest.approx(0.0, abs=1e-9)
    assert bar_damping(found, gap) <= found.raceways.impedance * (1.0 + 1e-9)


def test_shear_at_a_bar_is_couette_flow_in_its_gap() -> None:
    x = np.linspace(-0.2, 0.2, 4000001)
    for gap in (5e-6, 1e-5, 2e-5):
        exact = VISCOSITY * LENGTH * np.trapezoid(1.0 / (gap + x**2 / (2.0 * RADIUS)), x)
        # The end of the layer takes its share sqrt(g/H).
        assert bar_shear(oil(pocket_layer=1e-3), gap) == pytest.approx(exact * (1.0 - math.sqrt(gap / 1e-3)), rel=0.01)


def test_lands_damp_and_drag_as_short_bearings() -> None:
    """Two lands 10 mm wide, filled with oil: Reynolds' equation of a short bearing, without the half in which the film cavitates."""
    found, turn = oil(), np.linspace(0.0, 2.0 * math.pi, 200001)
    for eccentricity in (0.0, 0.5, 0.9):
        gap = LAND_CLEARANCE * (1.0 - eccentricity * np.cos(turn))
        for sign, damping in zip((1.0, -1.0), land_damping(found, eccentricity * LAND_CLEARANCE, LAND_CLEARANCE, LAND_RADIUS), strict=True):
            opening = -sign * np.cos(turn)
            # At the distance z from the middle of a land and 1 m/s: p = 6 eta dh/dt (z^2 - B^2/4)/h^3.
            force = np.where(opening < 0.0, VISCOSITY * (LAND_SHARE * RADIUS) ** 3 * opening * np.cos(turn) / gap**3, 0.0)
            exact = 2.0 * LAND_RADIUS * abs(np.trapezoid(force, turn))
            assert damping == pytest.approx(exact, rel=1e-3)
    assert land_damping(found, 2.0 * LAND_CLEARANCE, LAND_CLEARANCE, LAND_RADIUS) == land_damping(
        found, 0.95 * LAND_CLEARANCE, LAND_CLEARANCE, LAND_RADIUS
    )
    assert 52.7 * land_torque(found, LAND_CLEARANCE, LAND_RADIUS) == pytest.approx(0.54, rel=0.01)
    half = oil(land_fill=0.5)
    assert land_torque(half, LAND_CLEARANCE, LAND_RADIUS) == 0.5 * land_torque(found, LAND_CLEARANCE, LAND_RADIUS)


def test_lands_and_blows_of_other_rollers_are_in_proportion() -> None:
    made = Configuration.model_validate({"lubrication": {"law": "film_with_cages"}})
    usual = material_of(made.bearing)
    values = dict(made.lubrication)
    large, thin, short = (
        build(values, usual._replace(**size)) for size in ({}, {"roller_radius": RADIUS / 4}, {"roller_length": LENGTH / 4})
    )
    away, thin_away = (land_damping(law, 1e-4, LAND_CLEARANCE, LAND_RADIUS)[0] for law in (large, thin))
    assert thin_away == pytest.approx(away / 4.0**3)
    assert short.raceways.impedance == pytest.approx(0.5 * large.raceways.impedance)


def test_a_mist_of_oil_takes_some_watts_from_orbiting_rollers() -> None:
    """32 rollers at 4.95 m/s in a mist of 0.5 % take 13 W."""
    speed = 4.95
    assert 32.0 * churning(oil(lubricant="grease")) * speed**3 == pytest.approx(13.0, rel=0.05)
    assert churning(oil(oil_share=0.04)) == pytest.approx(2.0 * churning(oil()))


def test_without_oil_nothing_acts_on_cages() -> None:
    assert has_cage_oil(oil())
    assert not has_cage_oil(Dry())
    assert bar_damping(oil(squeeze=False), 1e-5) == 0.0
    assert land_damping(oil(squeeze=False), 0.0, LAND_CLEARANCE, LAND_RADIUS) == (0.0, 0.0)
    assert bar_shear(oil(pocket_layer=0.0), 1e-7) == 0.0
    assert bar_damping(Dry(), 1e-7) == bar_shear(Dry(), 1e-7) == churning(Dry()) == 0.0
