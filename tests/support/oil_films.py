"""Films of the default bearing, built from parameters of lubrication as the simulation builds them."""

from __future__ import annotations

from typing import Any

from dcrb_ros.core.laws.film import Film, Oil, build, film_at, film_memory, film_resistance, film_steady
from dcrb_ros.core.laws.lugre import LuGre
from dcrb_ros.core.laws.site import Site, inner_site, outer_site
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import cage_speed, material_of

FLOODED = 1e-3
"""A layer so thick that the contacts are flooded [m]."""
SHAFT = 125.66370614359172
"""1200 rpm [rad/s]"""
BENCH = Configuration()
FRICTION = LuGre(0.05, 0.06, 0.01, 1e5, 0.0133, 0.0, 0.7)
MATERIAL = material_of(BENCH.bearing)


def oil(**parameters: Any) -> Oil:
    """Return the constants for parameters of ``lubrication``: VG 100 at 70 deg C that floods the contacts, unless given."""
    values = {"lubricant": "vg100", "temperature": 70.0, "layer": FLOODED} | parameters
    constants: Oil = build(dict(Configuration.model_validate({"lubrication": values}).lubrication), MATERIAL)
    return constants


def speeds(shaft: float = SHAFT) -> tuple[float, float]:
    """Return the speeds at which both surfaces pass the contacts at inner and outer raceway in pure rolling [m/s]."""
    orbit = cage_speed(BENCH, shaft)
    return (shaft - orbit) * BENCH.bearing.inner_raceway_radius, orbit * BENCH.bearing.outer_raceway_radius


def inner_film(shaft: float = SHAFT, **parameters: Any) -> Film:
    """Return the film at the inner raceway."""
    film: Film = film_at(oil(**parameters), 0, speeds(shaft)[0])
    return film


def outer_film(shaft: float = SHAFT, **parameters: Any) -> Film:
    """Return the film at the outer raceway."""
    film: Film = film_at(oil(**parameters), 1, speeds(shaft)[1])
    return film


def site_of(film: Film, inner: bool, force: float = 0.0) -> Site:
    """Return the contact of a roller and a raceway with a film, which remembers a force [N]."""
    site = inner_site(MATERIAL, film) if inner else outer_site(MATERIAL, film)
    return site._replace(memory=film_memory(film, force))


def steady(film: Film, slip: float, force: float) -> tuple[float, float]:
    """Return speed [m/s] and coefficient [-] of steady sliding at a slip [m/s] under a force [N]."""
    speed, coefficient = film_steady(film, film_memory(film, force), FRICTION, slip)
    return float(speed), float(coefficient)


def resistance(film: Film, force: float) -> float:
    """Return the resistance to rolling [N] under a force [N]."""
    return float(film_resistance(film, film_memory(film, force), force))
