"""Lubricants, temperatures and films that the equations of the oil film do not describe."""

from __future__ import annotations

import functools
from collections.abc import Iterator

from dcrb_ros.core.laws.calls import film_at, film_offset
from dcrb_ros.core.laws.film import build
from dcrb_ros.core.laws.lubricants import CUSTOM, lubricant_of
from dcrb_ros.core.laws.site import Material
from dcrb_ros.core.laws.viscosity import (
    COLDEST,
    HOTTEST,
    LEAST_VISCOSITY,
    Lubricant,
    dynamic_viscosity,
    pressure_coefficient,
    roelands_exponent,
)
from dcrb_ros.settings.groups import ParameterGroups

MOST_VISCOSITY = 100.0
"""Viscosity above which an oil does not flow into the contacts [Pa s]: a mineral oil is at its pour point."""
STIFFEST = {"film_with_cages": 30.0}
"""Largest viscosity of laws that take less than that [Pa s]: at 44 Pa s and 3000 rpm the oil between rollers and cages causes impulses
that depend on the step."""
LEAST_EXPONENT, MOST_EXPONENT = 0.2, 1.1
"""Range of Roelands' exponent Z [-]; lubricants have 0.3 to 0.9."""
PROPERTIES = ("viscosity_40", "viscosity_100", "density", "pressure_coefficient")
"""Parameters of ``lubrication`` that describe a custom lubricant."""


def most_viscosity(law: str) -> float:
    """Return the largest viscosity that a law of lubrication takes [Pa s]."""
    return STIFFEST.get(law, MOST_VISCOSITY)


@functools.lru_cache(maxsize=64)
def coldest_flow(lubricant: Lubricant, law: str) -> float:
    """Return the lowest temperature at which a law of lubrication takes a lubricant [deg C], within the range of the formulas."""
    low, high = COLDEST, HOTTEST
    most = most_viscosity(law)
    if dynamic_viscosity(lubricant, low) <= most:
        return low
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if dynamic_viscosity(lubricant, middle) > most else (low, middle)
    return high


def held(lubricant: Lubricant, law: str, temperature: float) -> float:
    """Return a temperature within the range of the formulas for a lubricant and a law of lubrication [deg C]."""
    return min(max(temperature, coldest_flow(lubricant, law)), HOTTEST)


def oil_limits(c: ParameterGroups, material: Material) -> Iterator[str]:
    """Yield a sentence for each reason why the film cannot be computed; a dry bearing has none.

    As with other laws, the parameters of a film that is not chosen may have any value, so that a bench is made dry by one setting.
    """
    if c.lubrication.law == "dry":
        return
    named = list(_lubricant(c))
    yield from named or _state_of_oil(c)
    if c.contact.notch == "edge" and c.surfaces.law == "smooth":
        yield "contact.notch = 'edge' has no oil film: take sink or surfaces.law = profile, or lubrication.law = dry"
    if not named:
        yield from _thick_films(c, material)


def _lubricant(c: ParameterGroups) -> Iterator[str]:
    oil = c.lubrication
    if oil.lubricant != CUSTOM:
        for name in PROPERTIES:
            if getattr(oil, name) != type(oil).model_fields[name].default:
                yield (
                    f"lubrication.{name} = {getattr(oil, name):g} describes a custom lubricant, but lubrication.lubricant = "
                    f"{oil.lubricant!r}: remove it, or take lubricant = custom"
                )
    elif oil.viscosity_100 >= oil.viscosity_40:
        yield (
            f"lubrication.viscosity_100 = {oil.viscosity_100:g} mm^2/s is not below lubrication.viscosity_40 = "
            f"{oil.viscosity_40:g} mm^2/s: oils are thinner at 100 deg C than at 40 deg C; exchange the values"
        )


def _state_of_oil(c: ParameterGroups) -> Iterator[str]:
    lubricant, temperature = lubricant_of(dict(c.lubrication)), c.lubrication.temperature
    viscosity = dynamic_viscosity(lubricant, temperature)
    most = most_viscosity(c.lubrication.law)
    if not LEAST_VISCOSITY < viscosity <= most:
        remedy = "raise the temperature, or take a thinner oil" if viscosity > 1.0 else "lower the temperature, or take a thicker oil"
        at_most = "at most " if viscosity <= LEAST_VISCOSITY else ""
        yield (
            f"lubrication.temperature = {temperature:g} deg C gives lubricant {c.lubrication.lubricant!r} a viscosity of {at_most}"
            f"{viscosity:.3g} Pa s, outside {LEAST_VISCOSITY:g} .. {most:g} Pa s: {remedy}"
        )
        return
    exponent = roelands_exponent(viscosity, pressure_coefficient(lubricant, temperature))
    if not LEAST_EXPONENT <= exponent <= MOST_EXPONENT:
        yield (
            f"lubrication.pressure_coefficient = {lubricant.pressure_coefficient_40:g} 1/Pa with a viscosity of {viscosity:.3g} Pa s gives "
            f"Roelands' exponent {exponent:.3g}, outside {LEAST_EXPONENT:g} .. {MOST_EXPONENT:g}: oils have 1.5e-8 to 2.5e-8 1/Pa"
        )


def _thick_films(c: ParameterGroups, material: Material) -> Iterator[str]:
    """Compare the films at the speed of the shaft in pure rolling with the radial gap; those of a thermal network are left to its start."""
    if c.thermal.law == "network":
        return
    b, oil = c.bearing, build(dict(c.lubrication), material)
    surface = 0.5 * abs(c.operating.speed) * b.inner_raceway_radius
    speed = surface * b.outer_raceway_radius / (b.inner_raceway_radius + b.roller_radius)
    films = [film_offset(film_at(oil, number, speed)) for number in (0, 1)]
    if sum(films) >= b.radial_gap:
        yield (
            f"bearing: films of {films[0]:.3g} m, {films[1]:.3g} m at lubrication.temperature = {c.lubrication.temperature:g} deg C fill "
            f"the radial gap of {b.radial_gap:.3g} m: raise the temperature, or take a thinner oil or layer"
        )
