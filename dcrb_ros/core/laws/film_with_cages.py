"""The oil film of the raceways, and oil on bars, lands and orbiting rollers: `film` and `cage_oil` together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws import film
from dcrb_ros.core.laws.cage_oil import CageOil, bar_damping, bar_shear, cage_oil, churning, land_damping, land_torque
from dcrb_ros.core.laws.film import Film, Oil
from dcrb_ros.core.laws.film import film_at as raceway_film
from dcrb_ros.core.laws.site import Material


class FilmWithCages(NamedTuple):
    """Constants."""

    raceways: Oil
    cage: CageOil


@kernel
def film_at(law: FilmWithCages, number: int, speed: float) -> Film:
    """Return the film of raceway ``number`` at a speed of rolling [m/s], as `film` has it."""
    return raceway_film(law.raceways, number, speed)


def build(values: Mapping[str, Any], material: Material) -> FilmWithCages:
    """Return the constants, with oil of one temperature."""
    return warmed(values, material, values["temperature"], values["temperature"])


def warmed(values: Mapping[str, Any], material: Material, inner: float, outer: float) -> FilmWithCages:
    """Return the constants with oil of different temperatures at inner and outer raceway [deg C]; about the cages that of the outer."""
    raceways = film.warmed(values, material, inner, outer)
    about_cages = {**values, "temperature": outer}
    return FilmWithCages(raceways, cage_oil(about_cages, material, raceways.outer.viscosity, raceways.impedance))


LAW = replace(
    film.LAW,
    name="film_with_cages",
    summary="also oil in pockets, lands and around rollers",
    constants=FilmWithCages,
    build=build,
    warmed=warmed,
    film_at=film_at,
    bar_damping=bar_damping,
    bar_shear=bar_shear,
    land_damping=land_damping,
    land_torque=land_torque,
    churning=churning,
    has_cage_oil=True,
)
