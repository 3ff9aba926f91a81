"""Where a law acts: the geometry of the contacts, and the material of rings and rollers."""

from __future__ import annotations

import math
from typing import Any, NamedTuple


class NoMemory(NamedTuple):
    """Memory of a law that has none."""


class Site(NamedTuple):
    """Where a law acts: the geometry of the contact of a roller with a raceway, or with another roller."""

    number: int
    """0 at the inner raceway, 1 at the outer one, 2 between two rollers."""
    raceway_radius: float
    """Radius of the other body in the plane [m]."""
    scale: float
    """4 dR/cos(alpha)^2 [m]; dR is r_I + r_R at the inner raceway, r_O - r_R at the outer one, 2 r_R between two rollers."""
    width: float
    """Square of the contact's half-width over the force in the plane, 4 R/(pi L E* cos(alpha)) [m^2/N]."""
    reduced_radius: float
    """R [m]: 1/R is the sum of both curvatures along the line of contact, whose radii are those in the plane over cos(alpha)."""
    film: Any
    """The film at the present speed, as the bearing's law of lubrication describes it."""
    memory: Any
    """What the film remembers of the contact; see `LubricationLaw.memory`."""


class Material(NamedTuple):
    """Of rings and rollers: what the constants of a law may depend on beside its parameters."""

    effective_modulus: float
    """E* [Pa]."""
    roller_length: float
    """L [m]."""
    roller_radius: float
    """r_R in the plane of the model: the roller's own radius times cos(alpha) [m]."""
    roller_mass: float
    """m_R [kg]."""
    inner_raceway_radius: float
    """r_I [m]."""
    outer_raceway_radius: float
    """r_O [m]."""
    contact_angle: float
    """alpha between the line of contact and the plane [rad]."""


def inner_site(material: Material, film: Any = None) -> Site:
    """Return the contact of a roller with the inner raceway."""
    roller, raceway = material.roller_radius, material.inner_raceway_radius
    return _raceway_site(material, 0, raceway, 4.0 * (raceway + roller), 1.0 / roller + 1.0 / raceway, film)


def outer_site(material: Material, film: Any = None) -> Site:
    """Return the contact of a roller with the outer raceway."""
    roller, raceway = material.roller_radius, material.outer_raceway_radius
    return _raceway_site(material, 1, raceway, 4.0 * (raceway - roller), 1.0 / roller - 1.0 / raceway, film)


def pair_site(material: Material, film: Any = None) -> Site:
    """Return the contact of two rollers, whose line of contact lies in the plane."""
    roller = material.roller_radius / math.cos(material.contact_angle)
    return Site(2, roller, 8.0 * roller, 0.5 * _width(material) * roller, 0.5 * roller, film, NoMemory())


def _raceway_site(material: Material, number: int, raceway: float, scale: float, curvature: float, film: Any) -> Site:
    """Return a contact with a raceway from 4 dR [m] and the sum of curvatures [1/m] in the plane."""
    cosine = math.cos(material.contact_angle)
    square = cosine * cosine
    return Site(number, raceway, scale / square, _width(material) / curvature / square, 1.0 / curvature / cosine, film, NoMemory())


def _width(material: Material) -> float:
    return 4.0 / (math.pi * material.roller_length * material.effective_modulus)
