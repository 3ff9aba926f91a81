"""Hertz's point contact of a ball in the groove of a raceway: Harris and Kotzalas 2007, Essential Concepts of Bearing Technology, ch. 6.

    Q = (2^2.5/3) E* (sum rho)^-0.5 (delta/delta*)^1.5,    delta* = (2 F/pi) (pi/(2 kappa^2 E))^(1/3)

with the curvature sum rho [1/m], the complete elliptic integrals F and E at m = 1 - 1/kappa^2, and the ellipticity kappa, at which the
curvature difference is ((kappa^2 + 1) E - 2 F)/((kappa^2 - 1) E). For steel the first factor is the handbooks' 2.15e5 N/mm^1.5.

The model is planar. With a contact angle alpha a ball gives way along the line of contact by cos(alpha) of its way in the plane, and
cos(alpha) of its force acts there: F = Q(delta cos(alpha)) cos(alpha). Radii of the model are those in the plane, r cos(alpha) of a ball.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.interface import NormalLaw, Parameter
from dcrb_ros.core.laws.site import Material, NoMemory, Site

EXPONENT = 1.5
STEEPEST = 1e6
"""Largest ellipticity that is looked for [-]."""
HALVINGS = 12
"""Steps of the arithmetic-geometric mean [-]: it doubles its digits in each, and has all of them by then."""
ROUND = 1e-9
"""Curvature difference below which a contact is taken as circular [-]."""


class Hertz(NamedTuple):
    """Constants: F = K delta^1.5 in the plane of the model."""

    inner: float
    """K at the inner raceway [N/m^1.5]."""
    outer: float
    """K at the outer raceway [N/m^1.5]."""
    pair: float
    """K between two balls [N/m^1.5]."""


class Curvature(NamedTuple):
    """Curvatures of a contact."""

    total: float
    """Curvature sum [1/m]."""
    difference: float
    """Curvature difference F(rho) [-]."""


class Ellipse(NamedTuple):
    """Dimensionless contact ellipse, as tabulated by Harris and Kotzalas (Table 6.1)."""

    semimajor: float
    """a* [-]."""
    semiminor: float
    """b* [-]."""
    approach: float
    """delta* [-]."""


def elliptic_integrals(m: float) -> tuple[float, float]:
    """Return the complete elliptic integrals F and E at the parameter ``m`` below 1 [-].

    By the arithmetic-geometric mean: Abramowitz and Stegun 1964, 17.6.
    """
    a, b, c, power, total = 1.0, math.sqrt(1.0 - m), math.sqrt(m), 1.0, 0.5 * m
    for _ in range(HALVINGS):
        a, b, c = 0.5 * (a + b), math.sqrt(a * b), 0.5 * (a - b)
        total += power * c * c
        power *= 2.0
    first = 0.5 * math.pi / a
    return first, first * (1.0 - total)


def curvature_difference(kappa: float) -> float:
    """Return the curvature difference [-] that has a contact ellipse of an ellipticity ``kappa`` above 1 [-]."""
    first, second = elliptic_integrals(1.0 - 1.0 / kappa**2)
    return ((kappa**2 + 1.0) * second - 2.0 * first) / ((kappa**2 - 1.0) * second)


def contact_ellipse(difference: float) -> Ellipse:
    """Return a*, b* and delta* [-] for a curvature difference from 0 to below 1 [-]."""
    if difference < ROUND:
        return Ellipse(1.0, 1.0, 1.0)
    low, high = 0.0, math.log(STEEPEST)
    for _ in range(100):
        middle = 0.5 * (low + high)
        # The difference of a nearly round contact is lost in rounding; it is 3/4 of ln kappa there.
        trial = curvature_difference(math.exp(middle)) if middle > 1e-4 else 0.75 * middle
        low, high = (middle, high) if trial < difference else (low, middle)
    kappa = math.exp(0.5 * (low + high))
    first, second = elliptic_integrals(1.0 - 1.0 / kappa**2)
    semiminor = (2.0 * second / (math.pi * kappa)) ** (1.0 / 3.0)
    return Ellipse(kappa * semiminor, semiminor, 2.0 * first / math.pi * (0.5 * math.pi / (kappa**2 * second)) ** (1.0 / 3.0))


def raceway_curvature(ball: float, raceway: float, groove: float, contact_angle: float) -> Curvature:
    """Return the curvatures of a ball in a groove: Harris and Kotzalas 2007, eqs. 2.28 to 2.31.

    ``ball`` is its radius [m], ``raceway`` the radius of the raceway in the plane [m], below zero at an outer ring, ``groove`` the radius
    of the groove over the ball's diameter [-], ``contact_angle`` in [rad].
    """
    rolling, across = math.cos(contact_angle) / raceway, 1.0 / (2.0 * groove * ball)
    total = 2.0 / ball + rolling - across
    return Curvature(total, (across + rolling) / total)


def stiffness_coefficient(curvature: Curvature, effective_modulus: float) -> float:
    """Return K of Q = K delta^1.5 along the line of contact [N/m^1.5]; ``effective_modulus`` E/(2 (1 - nu^2)) [Pa]."""
    approach = contact_ellipse(curvature.difference).approach
    return math.pow(2.0, 2.5) / 3.0 * effective_modulus / math.sqrt(curvature.total) / math.pow(approach, EXPONENT)


def semiaxes(curvature: Curvature, force: float, effective_modulus: float) -> tuple[float, float]:
    """Return semimajor and semiminor axis of the contact ellipse [m] under a force [N]: eqs. 6.38 and 6.40."""
    size = (1.5 * force / (curvature.total * effective_modulus)) ** (1.0 / 3.0)
    ellipse = contact_ellipse(curvature.difference)
    return ellipse.semimajor * size, ellipse.semiminor * size


def curvatures(values: Mapping[str, float], material: Material) -> tuple[Curvature, Curvature]:
    """Return the curvatures at inner and outer raceway."""
    angle = material.contact_angle
    ball = material.roller_radius / math.cos(angle)
    inner = raceway_curvature(ball, material.inner_raceway_radius, values["hertz_inner_groove"], angle)
    return inner, raceway_curvature(ball, -material.outer_raceway_radius, values["hertz_outer_groove"], angle)


@kernel
def coefficient_at(law: Hertz, number: int) -> float:
    """Return K of the contact with the number of its `Site` [N/m^1.5]."""
    return law.inner if number == 0 else (law.outer if number == 1 else law.pair)


@kernel
def hertz_force(law: Hertz, memory: NoMemory, penetration: float, site: Site) -> tuple[float, float]:
    """Return the normal force [N] and its slope [N/m] at a penetration [m] above zero."""
    root = coefficient_at(law, site.number) * math.sqrt(penetration)
    return root * penetration, 1.5 * root


@kernel
def hertz_energy(law: Hertz, memory: NoMemory, penetration: Any, force: Any) -> Any:
    """Return the energy stored [J]: 2 F delta/5."""
    return 0.4 * force * penetration


def _coefficient(law: Hertz, site: Site) -> float:
    return (law.inner, law.outer, law.pair)[site.number]


def hertz_penetration(law: Hertz, force: Any, site: Site) -> Any:
    """Return the penetration [m] under a normal force [N] above zero."""
    return (force / _coefficient(law, site)) ** (1.0 / EXPONENT)


def hertz_stiffness(law: Hertz, force: Any, site: Site) -> Any:
    """Return the slope [N/m] under a normal force [N] above zero."""
    return EXPONENT * force ** (1.0 / 3.0) * _coefficient(law, site) ** (2.0 / 3.0)


def build(values: Mapping[str, float], material: Material) -> Hertz:
    """Return the constants."""
    cosine, modulus = math.cos(material.contact_angle), material.effective_modulus
    inner, outer = (cosine ** (1.0 + EXPONENT) * stiffness_coefficient(curvature, modulus) for curvature in curvatures(values, material))
    ball = material.roller_radius / cosine
    return Hertz(inner, outer, stiffness_coefficient(Curvature(4.0 / ball, 0.0), modulus))


LAW = NormalLaw(
    name="hertz",
    summary="the point contact of balls in grooves",
    constants=Hertz,
    build=build,
    force=hertz_force,
    energy=hertz_energy,
    penetration=hertz_penetration,
    stiffness=hertz_stiffness,
    parameters=(
        Parameter(
            "hertz_inner_groove",
            0.515,
            "-",
            "Radius of the inner groove over the ball's diameter",
            0.501,
            0.6,
            symbol="f_i",
            remedy="catalogue bearings have 0.51 to 0.53",
        ),
        Parameter(
            "hertz_outer_groove",
            0.525,
            "-",
            "Radius of the outer groove over the ball's diameter",
            0.501,
            0.6,
            symbol="f_o",
            remedy="catalogue bearings have 0.51 to 0.53",
        ),
    ),
)
