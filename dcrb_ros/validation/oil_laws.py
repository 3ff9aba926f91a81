"""Comparisons of the laws of the oil film with numbers worked out by hand; they need no simulation.

The numbers are those of `docs/explanation/lubrication.md`: VG 100 at 70 deg C, the default bearing at 1200 rpm, flooded contacts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from dcrb_ros.bearing.payload import cage_speed
from dcrb_ros.core.laws import film, film_thickness, fluid_traction, lubricants, rolling_resistance, squeeze, viscosity
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import material_of
from dcrb_ros.validation.report_row import ReportRow, about, between

CHAPTER = "Oil film: laws"
SPEED = 40.0 * math.pi
"""1200 rpm [rad/s]."""
LOADED = 30251.0
"""Force of the roller on the load line [N]."""
FLOODED = 1e-3
"""A layer that floods the contacts [m]."""
CENTRIFUGAL = 64.9
"""Force that holds an idle roller against the outer raceway [N]."""


def film_of(inner: bool, speed: float = SPEED, **parameters: Any) -> film.Film:
    """Return the film at a raceway of the default bearing at a shaft speed [rad/s], with some parameters of lubrication."""
    values = {"lubricant": "vg100", "temperature": 70.0, "layer": FLOODED} | parameters
    bench = Configuration.model_validate({"lubrication": values})
    orbit, radii = cage_speed(bench, speed), bench.bearing
    rolling = (speed - orbit) * radii.inner_raceway_radius if inner else orbit * radii.outer_raceway_radius
    film_constants: film.Film = film.film_at(film.build(dict(bench.lubrication), material_of(bench.bearing)), 0 if inner else 1, rolling)
    return film_constants


def oil_law_rows() -> Iterator[ReportRow]:
    """Yield the comparisons of viscosity, film, asperities, traction, rolling resistance, squeeze film and wedge."""
    yield from _viscosity()
    yield from _thickness()
    yield from _traction()
    yield from _rolling()
    yield from _squeeze()


def _viscosity() -> Iterator[ReportRow]:
    oil = lubricants.LUBRICANTS["vg100"]
    kinematic = [viscosity.kinematic_viscosity(oil, temperature) for temperature in (40.0, 100.0)]
    yield about(CHAPTER, "Kinematic viscosity of VG 100 at 40 and 100 deg C", kinematic, (100.0, 11.2), 1e-6, "mm^2/s")
    yield about(CHAPTER, "Viscosity of VG 100 at 70 deg C", 1e3 * viscosity.dynamic_viscosity(oil, 70.0), 23.227, 1e-4, "mPa s")
    alpha = viscosity.pressure_coefficient(oil, 70.0)
    slope = math.log(viscosity.viscosity_under(0.0232, alpha, 1e4) / 0.0232) / 1e4
    yield about(CHAPTER, "Slope of the viscosity over the pressure, at none", slope / alpha, 1.0, 1e-3)
    # Roelands by hand: Z = 0.6419, exp(5.906*((1 + 1054/196.2)^0.6419 - 1)) times 23.2 mPa s, docs/explanation/lubrication.md, "Traction"
    yield about(CHAPTER, "Viscosity under 1054 MPa", viscosity.viscosity_under(0.023227, alpha, 1.054e9), 1.5e4, 0.05, "Pa s")


def _thickness() -> Iterator[ReportRow]:
    inner, outer = film_of(True), film_of(False)
    films = [1e6 * film.thickness_under(site, LOADED) for site in (inner, outer)]
    yield about(CHAPTER, "Central film under 30.25 kN, inner and outer raceway", films, (0.7027, 0.8032), 1e-3, "um")
    slopes = [math.log2(film.thickness_under(inner, 2e4) / film.thickness_under(inner, 1e4))]
    slopes.append(
        math.log2(film_thickness.central_per_load(2e-11, 4e3, 1.0, 1.0, 1.0) / film_thickness.central_per_load(1e-11, 4e3, 1.0, 1.0, 1.0))
    )
    slopes.append(
        math.log2(film_thickness.central_per_load(1e-11, 8e3, 1.0, 1.0, 1.0) / film_thickness.central_per_load(1e-11, 4e3, 1.0, 1.0, 1.0))
    )
    yield about(CHAPTER, "Exponents of the central film over load, speed and material", slopes, (-0.10, 0.69, 0.56), 1e-3)
    layers = (0.3e-6, 0.5e-6, 1e-6, 2e-6)
    starved = [1e6 * film.thickness_under(film_of(True, layer=layer), LOADED) for layer in layers]
    yield about(CHAPTER, "Central film that layers of 0.3, 0.5, 1 and 2 um feed", starved, (0.276, 0.407, 0.575, 0.663), 2e-3, "um")
    shares = [film_thickness.asperity_share(ratio) for ratio in (1e-9, 1.0, 3.0)]
    yield about(CHAPTER, "Load on asperities at Lambda 0, 1 and 3", shares, (1.0, math.exp(-1.8), 0.001198), 1e-3)


def _traction() -> Iterator[ReportRow]:
    inner = film_of(True)
    slips = [film.film_memory(inner, force).characteristic_slip for force in (65.0, 1e3, 1e4, 3e4)]
    yield about(CHAPTER, "Characteristic slip of the film under 65 N, 1, 10 and 30 kN", slips, (67.0, 19.4, 0.22, 3.03e-3), 0.01, "m/s")
    expected = (0.06 * 1e-5, 0.06 * (1.0 - math.exp(-1.0)), 0.06)
    coefficients = [fluid_traction.fluid_coefficient(2.0 * share, 2.0, 0.06) for share in (1e-5, 1.0, 100.0)]
    yield about(CHAPTER, "Traction at 1e-5, 1 and 100 times that slip", coefficients, expected, 1e-4)
    # At standstill asperities carry all: the contact is a dry one with the boundary coefficient.
    still = film_of(True, 0.0)
    memory = film.film_memory(still, LOADED)
    yield about(CHAPTER, "Friction coefficient at standstill, at 1 m/s of slip", film.film_steady(still, memory, None, 1.0)[1], 0.12, 1e-2)  # type: ignore[arg-type]
    yield between(CHAPTER, "Resistance to rolling at standstill", abs(memory.resistance), -math.inf, 1e-3, "N")


def _rolling() -> Iterator[ReportRow]:
    inner = film_of(True)
    oil = film.build(
        dict(Configuration.model_validate({"lubrication": {"lubricant": "vg100", "temperature": 70.0}}).lubrication),
        material_of(Configuration().bearing),
    )
    orbit = cage_speed(Configuration(), SPEED)
    cooled = rolling_resistance.inlet_cooling(oil.inner.heating * ((SPEED - orbit) * Configuration().bearing.inner_raceway_radius) ** 2)
    forces = [force * inner.by_force for force in (65.0, 1e3, LOADED)]
    resistances = [rolling_resistance.flooded_resistance(inner.resistance, force) / cooled for force in forces]
    yield about(CHAPTER, "Resistance to rolling under 65 N, 1 and 30.25 kN, isothermal", resistances, (1.30, 5.00, 6.070), 5e-3, "N")
    shares = [rolling_resistance.starvation(ratio) for ratio in (1.0, 10.0, 100.0)]
    yield about(CHAPTER, "Its share in a starved inlet, meniscus over film 1, 10 and 100", shares, (0.1129, 0.5251, 0.8601), 2e-3)


def _squeeze() -> Iterator[ReportRow]:
    outer = film_of(False)
    damping = [squeeze.squeeze_at(gap * 1e-6, outer.squeeze, 1e-9, 1.0) for gap in (1.0, 10.0, 100.0)]
    yield about(CHAPTER, "Damping of a gap of 1, 10 and 100 um", damping, (34080.0, 1078.0, 34.08), 1e-3, "N s/m")
    mass, layer = Configuration().bearing.roller_mass, 20e-6
    floor = film_of(False, layer=layer).floor
    taken, gap = 0.0, layer
    for _ in range(100):
        part = 0.19e-6
        taken += squeeze.squeeze_damping(gap, part, outer.squeeze, floor, layer) * part / mass
        gap -= part
    # The layer's integral from 1 um, by hand: A (2/sqrt(q) - 3/sqrt(H) + q H^-1.5) above the floor of 1.49 um, and A q^-1.5 below it
    yield about(CHAPTER, "Speed that a layer of 20 um takes from a roller down to 1 um", taken, 0.169, 0.01, "m/s")
    forces = []
    for thick, rest in ((2e-6, 1.235e-6), (5e-6, 2.357e-6), (20e-6, 4.845e-6)):
        forces.append(squeeze.wedge_force(rest, outer.lift, 0.8e-6, thick)[0])
    yield about(CHAPTER, "Lift of the wedge at the gaps at which an idle roller rests", forces, (CENTRIFUGAL,) * 3, 5e-3, "N")
