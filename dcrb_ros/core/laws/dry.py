"""No lubricant: rollers and raceways touch, and LuGre's Stribeck curve is the steady friction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.interface import LubricationLaw
from dcrb_ros.core.laws.lugre import LuGre, stribeck_coefficient
from dcrb_ros.core.laws.site import Material, NoMemory


class Dry(NamedTuple):
    """Without constants."""


class NoFilm(NamedTuple):
    """No film."""


@kernel
def dry_film_at(law: Dry, number: int, speed: float) -> NoFilm:
    """Return no film."""
    return NoFilm()


@kernel
def dry_length(film: NoFilm) -> float:
    """Return 0, for reach and thickness [m]."""
    return 0.0


@kernel
def dry_lift(film: NoFilm, gap: float) -> tuple[float, float]:
    """Return no force and no stiffness."""
    return 0.0, 0.0


@kernel
def dry_lift_energy(film: NoFilm, gap: float) -> float:
    """Return no energy."""
    return 0.0


@kernel
def dry_damping(film: NoFilm, gap: float, way: float) -> float:
    """Return no damping."""
    return 0.0


@kernel
def dry_squeeze(film: NoFilm, gap: float, closing: float) -> float:
    """Return no damping."""
    return 0.0


@kernel
def dry_memory(film: NoFilm, force: float) -> NoMemory:
    """Return no memory."""
    return NoMemory()


@kernel
def dry_steady_friction(film: NoFilm, memory: NoMemory, friction: LuGre, slip: float) -> tuple[float, float]:
    """Return the slip's size [m/s] and the Stribeck curve there [-]."""
    return abs(slip), stribeck_coefficient(slip, friction.kinetic_coefficient, friction.static_coefficient, friction.stribeck_speed)


@kernel
def dry_resistance(film: NoFilm, memory: NoMemory, force: float) -> float:
    """Return no resistance."""
    return 0.0


def build(values: Mapping[str, Any], material: Material) -> Dry:
    """Return the constants."""
    return Dry()


LAW = LubricationLaw(
    name="dry",
    summary="no lubricant (the paper)",
    constants=Dry,
    film=NoFilm,
    build=build,
    film_at=dry_film_at,
    film_reach=dry_length,
    film_offset=dry_length,
    film_lift=dry_lift,
    film_lift_energy=dry_lift_energy,
    film_damping=dry_damping,
    film_floor=dry_length,
    film_squeeze=dry_squeeze,
    film_memory=dry_memory,
    steady_friction=dry_steady_friction,
    film_resistance=dry_resistance,
)
