"""Hertz's point contact of a ball in a groove."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipe, ellipk

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.contacts.arrays import normal_forces
from dcrb_ros.core.laws.hertz import (
    contact_ellipse,
    curvature_difference,
    curvatures,
    elliptic_integrals,
    hertz_energy,
    hertz_force,
    hertz_penetration,
    hertz_stiffness,
    semiaxes,
    stiffness_coefficient,
)
from dcrb_ros.core.laws.site import NoMemory
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.loaded_contacts import material_of
from dcrb_ros.validation.balls import angular_bench

pytestmark = pytest.mark.kernel

BENCH = load_configuration("ball_bearing_6205", ["lubrication.law=dry", "surfaces.law=smooth"])
PAYLOAD, NONE = build_payload(BENCH), NoMemory()
LAW = PAYLOAD.normal_law
SITES = st.sampled_from((PAYLOAD.inner, PAYLOAD.outer, PAYLOAD.pair))
depths = st.floats(1e-9, 1e-4)


@given(st.floats(0.0, 0.999999))
def test_elliptic_integrals_are_those_of_scipy(m: float) -> None:
    assert elliptic_integrals(m) == pytest.approx((float(ellipk(m)), float(ellipe(m))), rel=1e-12)


@given(st.floats(1e-3, 0.999))
def test_the_ellipse_has_the_curvature_difference(difference: float) -> None:
    ellipse = contact_ellipse(difference)
    assert curvature_difference(ellipse.semimajor / ellipse.semiminor) == pytest.approx(difference, abs=1e-6)


def test_a_nearly_round_contact_is_that_of_a_ball_on_a_plane() -> None:
    assert contact_ellipse(1e-10) == pytest.approx((1.0, 1.0, 1.0))
    assert contact_ellipse(1e-5) == pytest.approx((1.0, 1.0, 1.0), abs=1e-4)


def test_a_ball_on_a_plane_has_the_stiffness_of_the_textbook() -> None:
    # Johnson 1985, eq. 4.23: F = 4/3 E' sqrt(R) delta^1.5 with E' = E/(2 (1 - nu^2)); two balls of 3.97 mm have R = r/2.
    expected = 4.0 / 3.0 * BENCH.bearing.effective_modulus * math.sqrt(0.5 * BENCH.bearing.roller_radius)
    assert LAW.pair == pytest.approx(expected, rel=1e-9)


@given(depths, SITES)
def test_force_stiffness_energy_and_penetration_agree(depth: float, site: object) -> None:
    force, stiffness = hertz_force(LAW, NONE, depth, site)
    assert hertz_penetration(LAW, force, site) == pytest.approx(depth)
    assert hertz_stiffness(LAW, force, site) == pytest.approx(stiffness)
    before, after = (hertz_force(LAW, NONE, share * depth, site)[0] for share in (0.999, 1.001))
    assert stiffness == pytest.approx((after - before) / (0.002 * depth), rel=1e-5)
    ways = np.linspace(0.0, depth, 2001)
    forces = np.array([hertz_force(LAW, NONE, float(way), site)[0] for way in ways])
    assert hertz_energy(LAW, NONE, depth, force) == pytest.approx(float(np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(ways))), rel=1e-4)


def test_open_contacts_have_no_force() -> None:
    forces, slopes = normal_forces(LAW, np.array([-1e-6, 0.0, 1e-6]), PAYLOAD.inner)
    assert forces[:2].tolist() == [0.0, 0.0]
    assert forces[2] == pytest.approx(LAW.inner * 1e-9)
    assert slopes[2] > 0.0


def test_the_ellipse_carries_the_force_with_hertz_pressure() -> None:
    # The approach follows from both semiaxes: the largest pressure is 3 Q/(2 pi a b), and a circle of sqrt(a b) has delta near a b/R.
    curvature, _ = curvatures(dict(BENCH.contact), material_of(BENCH.bearing))
    major, minor = semiaxes(curvature, 130.0, BENCH.bearing.effective_modulus)
    ellipse = contact_ellipse(curvature.difference)
    assert major / minor == pytest.approx(ellipse.semimajor / ellipse.semiminor)
    depth = (130.0 / stiffness_coefficient(curvature, BENCH.bearing.effective_modulus)) ** (2.0 / 3.0)
    # Harris and Kotzalas 2007, eq. 6.42: delta = delta* (size)^2 sum(rho)/2, with a = a* size.
    assert depth == pytest.approx(ellipse.approach * (major / ellipse.semimajor) ** 2 * 0.5 * curvature.total)


def test_a_contact_angle_turns_force_and_way_into_the_line_of_contact() -> None:
    angular = angular_bench()
    cosine = math.cos(angular.bearing.contact_angle)
    law = build_payload(angular).normal_law
    inner, _ = curvatures(dict(angular.contact), material_of(angular.bearing))
    along = stiffness_coefficient(inner, angular.bearing.effective_modulus)
    depth = 3e-6
    assert law.inner * depth**1.5 == pytest.approx(along * (depth * cosine) ** 1.5 * cosine)
