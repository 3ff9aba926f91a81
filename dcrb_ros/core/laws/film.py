"""Oil-lubricated contacts of rollers and raceways: film, wedge, squeeze, traction and rolling resistance together.

The film lifts the bodies by its thickness, so that the elastic contact closes at a gap. Between that and the end of the oil layer the wedge
carries and the squeeze film resists approach. Traction is the bristle law with the steady coefficient of `fluid_traction`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.film_thickness import (
    LEAST_FORCE,
    asperity_share,
    central_per_load,
    inlet_heating,
    minimum_per_load,
    power,
    starved,
)
from dcrb_ros.core.laws.fluid_traction import LEAST_SLIP, characteristic_slip, fluid_coefficient
from dcrb_ros.core.laws.interface import LubricationLaw
from dcrb_ros.core.laws.lubricants import LAYERS, lubricant_of
from dcrb_ros.core.laws.lugre import LuGre
from dcrb_ros.core.laws.rolling_resistance import directed, flooded_resistance, inlet_cooling, resistance_scale, starvation
from dcrb_ros.core.laws.site import Material, Site, inner_site, outer_site
from dcrb_ros.core.laws.squeeze import squeeze_coefficient, squeeze_damping, squeeze_floor, squeeze_near, wedge_energy, wedge_force
from dcrb_ros.core.laws.viscosity import (
    ROELANDS_OFFSET,
    Lubricant,
    dynamic_viscosity,
    pressure_coefficient,
    roelands_exponent,
    temperature_coefficient,
)

OIL_CONDUCTIVITY = 0.14
"""k_f [W/(m K)]."""
OFFSET_FORCE = 10e3
"""Force at which the thickness of the film is taken that lifts the bodies [N]; over 1 to 30 kN it changes by a seventh."""
WEDGE = 4.9
"""Martin's factor [-]."""
IMPACT_STIFFNESS = 1.2e9 / 0.048
"""Stiffness of a contact in a blow over the length of a roller [N/m^2], for the largest damping of a squeeze film."""
MENISCUS_LAYERS = 2.0
"""Height of the inlet meniscus over the thickness of the layer [-]: both surfaces bring oil."""
HYSTERESIS = 0.007
"""Share a_v of the elastic energy that rolling loses in the material [-] (Johnson 1985)."""
MICRO_SLIP = 0.004
"""Slip of asperities in rolling that a planar model lacks: skew, crown, profile [-]."""
LEAST_SPEED = 1e-6
"""Least speed for which a film is evaluated [m/s]."""
NO_LAYER = 1e-9
"""Layer between two rollers of a row, where no film is described [m]."""


class RacewayOil(NamedTuple):
    """What does not depend on speed, of one raceway: geometry, and the oil at the temperature of its inlets."""

    viscosity: float
    """eta [Pa s]."""
    material: float
    """G = alpha E' [-]."""
    offset: float
    """ln eta + 9.67 [-]."""
    exponent: float
    """Z [-]."""
    heating: float
    """L_t/u^2 [s^2/m^2]."""
    radius: float
    """Reduced radius R [m]."""
    pressure: float
    """Mean pressure over the square root of the force [Pa/N^(1/2)]."""
    squeeze: float
    """A [N s m^(1/2)]."""
    hysteresis: float
    """Resistance of the material over F^(3/2), a_v (2 b/(3 pi))/(2 R) for b = 1 N^(1/2) [N^(-1/2)]."""


class Oil(NamedTuple):
    """Constants."""

    layer: float
    """H [m]."""
    roughness: float
    """sigma [m]."""
    boundary: float
    """mu_b [-]."""
    micro_slip: float
    """epsilon, slip of asperities in rolling [-]."""
    limiting: float
    """mu_L [-]."""
    squeezes: float
    """1 with a squeeze film, otherwise 0 [-]."""
    resists: float
    """1 with rolling resistance, otherwise 0 [-]."""
    modulus: float
    """E' [Pa]."""
    length: float
    """L [m]."""
    impedance: float
    """Largest damping of a squeeze film [N s/m]: a blow meets film and elastic contact in series."""
    inner: RacewayOil
    outer: RacewayOil


class Film(NamedTuple):
    """The film of a raceway's contacts at a speed."""

    offset: float
    """h_f, by which the film lifts the bodies [m]."""
    layer: float
    """H [m]."""
    lift: float
    """4.9 eta u R L [N m]."""
    squeeze: float
    """A [N s m^(1/2)], 0 without a squeeze film."""
    floor: float
    """h_s, always below H [m]."""
    thickness: float
    """Flooded central film times F^0.10 [m N^0.10]."""
    least: float
    """Flooded minimum film times F^0.13 [m N^0.13]."""
    resistance: float
    """Factor on sqrt(M) in the resistance of light loads, inlet heating included [N]; 0 without rolling resistance."""
    by_force: float
    """M over the force [1/N]."""
    hysteresis: float
    """Resistance of the material over F^(3/2) [N^(-1/2)]; 0 without rolling resistance."""
    micro_slip: float
    """Resistance of asperities over their load [-]; 0 without rolling resistance."""
    pressure: float
    """Mean pressure over the square root of the force [Pa/N^(1/2)]."""
    viscosity: float
    stiffening: float
    """ln eta + 9.67 [-]."""
    exponent: float
    roughness: float
    boundary: float
    limiting: float
    direction: float
    """Sign of the speed of rolling, smoothed about standstill [-]."""


class FilmMemory(NamedTuple):
    """What a contact remembers of its film."""

    characteristic_slip: float
    """s_0 [m/s]."""
    asperity_share: float
    """phi_a [-]."""
    resistance: float
    """F_R, with the sign of the speed of rolling [N]."""


@kernel
def film_at(law: Oil, number: int, speed: float) -> Film:
    """Return the film of a raceway's contacts at the speed at which they roll over it [m/s], the mean speed of both surfaces past them."""
    oil, present = law.inner if number == 0 else law.outer, 0.0 if number == 2 else 1.0
    u = max(abs(speed), LEAST_SPEED)
    group = oil.viscosity * u / (law.modulus * oil.radius)
    loading = oil.heating * u * u
    thickness = central_per_load(group, oil.material, law.modulus, oil.radius, law.length) * inlet_heating(loading)
    least = minimum_per_load(group, oil.material, law.modulus, oil.radius, law.length) * inlet_heating(loading)
    offset = starved(thickness * power(OFFSET_FORCE, -0.10), law.layer)
    floor = max(offset, squeeze_floor(oil.squeeze, law.impedance, law.layer))
    double = 2.0 * group
    return Film(
        offset * present,
        law.layer if present > 0.0 else NO_LAYER,
        WEDGE * oil.viscosity * u * oil.radius * law.length * present,
        oil.squeeze * law.squeezes * present,
        floor,
        thickness,
        least,
        resistance_scale(double, law.modulus, oil.radius, law.length) * inlet_cooling(loading) * law.resists,
        1.0 / (law.modulus * oil.radius * law.length * math.sqrt(double)),
        oil.hysteresis * law.resists,
        0.5 * law.micro_slip * law.boundary * law.resists,
        oil.pressure,
        oil.viscosity,
        oil.offset,
        oil.exponent,
        law.roughness,
        law.boundary,
        law.limiting,
        directed(speed),
    )


@kernel
def film_reach(film: Film) -> float:
    """Return the gap up to which the film acts [m]."""
    return film.layer


@kernel
def film_offset(film: Film) -> float:
    """Return by how much the film lifts the bodies [m]."""
    return film.offset


@kernel
def film_lift(film: Film, gap: float) -> tuple[float, float]:
    """Return force [N] and stiffness [N/m] of the wedge at a gap [m]."""
    return wedge_force(gap, film.lift, film.offset, film.layer)


@kernel
def film_lift_energy(film: Film, gap: float) -> float:
    """Return the integral of the wedge's force from a gap to the end of the layer [J]."""
    return wedge_energy(gap, film.lift, film.offset, film.layer)


@kernel
def film_damping(film: Film, gap: float, way: float) -> float:
    """Return the mean damping [N s/m] of a step from a gap to one smaller by ``way`` [m]."""
    return squeeze_damping(gap, way, film.squeeze, film.floor, film.layer)


@kernel
def thickness_under(film: Film, force: float) -> float:
    """Return the central film [m] under a force above zero [N]."""
    return starved(film.thickness * power(max(force, LEAST_FORCE), -0.10), film.layer)


@kernel
def thickness_and_ratio(film: Film, force: float) -> tuple[float, float]:
    """Return the central film [m] under a force [N], and its ratio Lambda to the roughness [-]."""
    thickness = thickness_under(film, force)
    return thickness, thickness / film.roughness


@kernel
def film_floor(film: Film) -> float:
    """Return the gap below which the damping grows no more [m]."""
    return film.floor


@kernel
def film_squeeze(film: Film, gap: float, closing: float) -> float:
    """Return the damping [N s/m] at a gap [m] that closes at a speed [m/s]; a gap that opens has none."""
    return squeeze_near(gap, film.squeeze if closing > 0.0 else 0.0, film.floor, film.offset, film.layer)


@kernel
def film_memory(film: Film, force: float) -> FilmMemory:
    """Return what a contact under a normal force [N] remembers."""
    loaded = max(force, LEAST_FORCE)
    thickness = thickness_under(film, loaded)
    pressure = film.pressure * math.sqrt(loaded)
    characteristic = characteristic_slip(pressure, thickness, film.limiting, film.viscosity, film.stiffening, film.exponent)
    share = asperity_share(thickness / film.roughness)
    flooded = flooded_resistance(film.resistance, loaded * film.by_force)
    meniscus = MENISCUS_LAYERS * film.layer / film.least * power(loaded, 0.13)
    dry = loaded * (film.micro_slip * share + film.hysteresis * math.sqrt(loaded))
    return FilmMemory(characteristic, share, (flooded * starvation(meniscus) + dry) * film.direction)


@kernel
def film_steady(film: Film, memory: FilmMemory, friction: LuGre, slip: float) -> tuple[float, float]:
    """Return slip [m/s] and coefficient g [-] of steady sliding, whose ratio is finite at rest, too; ``friction`` has no part in it."""
    sliding, share = max(abs(slip), LEAST_SLIP), memory.asperity_share
    return sliding, share * film.boundary + (1.0 - share) * fluid_coefficient(sliding, memory.characteristic_slip, film.limiting)


@kernel
def film_resistance(film: Film, memory: FilmMemory, force: float) -> float:
    """Return the resistance F_R of the contact to rolling [N], with the sign of the speed of rolling; zero without a normal force [N]."""
    return memory.resistance if force > 0.0 else 0.0


def raceway_oil(material: Material, site: Site, lubricant: Lubricant, temperature: float) -> RacewayOil:
    """Return what does not depend on speed, of one raceway with oil of a temperature [deg C]."""
    viscosity, alpha = dynamic_viscosity(lubricant, temperature), pressure_coefficient(lubricant, temperature)
    # The force of the plane over this length is the normal force over that of the roller.
    half_width, length = math.sqrt(site.width), material.roller_length * math.cos(material.contact_angle)
    return RacewayOil(
        viscosity=viscosity,
        material=alpha * 2.0 * material.effective_modulus,
        offset=math.log(viscosity) + ROELANDS_OFFSET,
        exponent=roelands_exponent(viscosity, alpha),
        heating=temperature_coefficient(lubricant, temperature) * viscosity / OIL_CONDUCTIVITY,
        radius=site.reduced_radius,
        pressure=1.0 / (2.0 * half_width * length),
        squeeze=squeeze_coefficient(viscosity, length, site.reduced_radius),
        hysteresis=HYSTERESIS * half_width / (3.0 * math.pi * site.reduced_radius),
    )


def build(values: Mapping[str, Any], material: Material) -> Oil:
    """Return the constants, with oil of one temperature."""
    return warmed(values, material, values["temperature"], values["temperature"])


def warmed(values: Mapping[str, Any], material: Material, inner: float, outer: float) -> Oil:
    """Return the constants with oil of different temperatures at the inlets of inner and outer raceway [deg C]."""
    lubricant = lubricant_of(values)
    return Oil(
        layer=values["layer"] or LAYERS[values["lubricant"]],
        roughness=values["roughness"],
        boundary=values["boundary_friction"],
        micro_slip=values.get("micro_slip", MICRO_SLIP),
        limiting=values["limiting_friction"],
        squeezes=float(values["squeeze"]),
        resists=float(values["rolling_resistance"]),
        modulus=2.0 * material.effective_modulus,
        length=material.roller_length * math.cos(material.contact_angle),
        impedance=math.sqrt(material.roller_mass * IMPACT_STIFFNESS * material.roller_length),
        inner=raceway_oil(material, inner_site(material), lubricant, inner),
        outer=raceway_oil(material, outer_site(material), lubricant, outer),
    )


LAW = LubricationLaw(
    name="film",
    summary="an oil film",
    constants=Oil,
    film=Film,
    build=build,
    warmed=warmed,
    film_at=film_at,
    film_reach=film_reach,
    film_offset=film_offset,
    film_lift=film_lift,
    film_lift_energy=film_lift_energy,
    film_damping=film_damping,
    film_floor=film_floor,
    film_squeeze=film_squeeze,
    steady_friction=film_steady,
    film_memory=film_memory,
    film_resistance=film_resistance,
    memory=FilmMemory,
    resists=True,
    thickness=thickness_and_ratio,
)
