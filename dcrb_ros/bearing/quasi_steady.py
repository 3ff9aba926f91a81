"""A bearing that runs steadily, without the time loop: what its films lose at a speed and load, and the temperatures that follow.

The forces on the rollers are those of rigid rings, the cages turn as in pure rolling, and each contact loses 2 F_R V by the resistance of
its film to rolling (`dcrb_ros.core.laws.rolling_resistance`). Sliding, some 3 % of the losses of the default bearing, is left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dcrb_ros.bearing.heat_network import GREASE_EXCHANGE, Conductances, Vector, contact_conductance, heat_network, idle_conductance
from dcrb_ros.bearing.load_distribution import roller_forces
from dcrb_ros.bearing.lubricant_condition import lubrication_at
from dcrb_ros.core.laws.cage_oil import DRAG_COEFFICIENT
from dcrb_ros.core.laws.calls import churning, film_at, film_memory, film_offset, film_thickness, has_cage_oil, land_torque
from dcrb_ros.core.laws.lubricants import lubricant_of
from dcrb_ros.core.laws.registry import law_of
from dcrb_ros.core.laws.site import Site, inner_site, outer_site
from dcrb_ros.core.laws.viscosity import density
from dcrb_ros.core.observation import LOADED_FORCE
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import cage_speed, load_and_weight, material_of

Heat = tuple[float, float, float]
"""Of a row: at the inner raceway, at the outer one, and the rest (cage, oil about the rollers, seals) [W]."""
DAMPED_STEPS = 60
"""Steps towards the steady state, each half of the way: the heat falls with temperature, so that whole steps would overshoot."""
SETTLED = 1e-9
"""Change of temperature at which the search ends [K]."""
LEAST_FORCE = 1.0
"""Force below which a roller does not touch a raceway [N]."""


def lost_in_grease(configuration: Configuration, orbit: float, loss: float) -> float:
    """Return the power that the rollers of a row lose in an overfill [W], 0.5 rho f C_d 2 r_R L v^3 each, as they orbit [rad/s] after a
    loss of lubricant [-]; 0 where the law of lubrication has that drag in its motion."""
    c, b = configuration, configuration.bearing
    share = c.faults.condition.oil_share * (1.0 - loss)
    if share == 0.0 or c.lubrication.law == "film_with_cages":
        return 0.0
    mass = density(lubricant_of(dict(c.lubrication)), c.lubrication.temperature) * share
    return float(DRAG_COEFFICIENT * mass * b.roller_radius * b.roller_length * abs(orbit * b.pitch_radius) ** 3 * b.rollers_per_row)


def seal_heat(configuration: Configuration, speed: float) -> float:
    """Return the heat of the seals of a row [W] at a speed of the shaft [rad/s], rubbing ones included."""
    return float((configuration.thermal.seal_torque + configuration.faults.condition.seal_torque) * abs(speed))


def vehicle_speed(configuration: Configuration, speed: float) -> float:
    """Return the speed of the vehicle [m/s] at a speed of the shaft [rad/s]."""
    return float(0.5 * configuration.operating.wheel_diameter * abs(speed))


def air_speed(configuration: Configuration, speed: float) -> float:
    """Return the speed of the air at the axle box [m/s] at a speed of the shaft [rad/s]."""
    thermal = configuration.thermal
    return float(thermal.exposure * (thermal.air_speed or vehicle_speed(configuration, speed)))


def raceway_conductance(forces: Floats, site: Site, length: float, speed: float) -> float:
    """Return the conductance of a row's contacts with a raceway [W/K], for the forces on its rollers [N] and a speed of rolling [m/s]."""
    touching = [force for force in forces.tolist() if force > LEAST_FORCE]
    # The conductance of a contact goes with the fourth root of its force.
    loaded = [math.sqrt(math.sqrt(force)) for force in touching if force > LOADED_FORCE]
    idle, roots = len(touching) - len(loaded), sum(loaded)
    return contact_conductance(math.sqrt(site.width), length, speed) * roots + idle * idle_conductance(length) + GREASE_EXCHANGE


@dataclass(frozen=True)
class Running:
    """A bearing that runs at one speed under one load."""

    speed: float
    """Of the shaft [rad/s]."""
    orbit: float
    """Speed of the cages [rad/s]."""
    rolling: tuple[float, float]
    """Speeds at which the rollers roll over inner and outer raceway [m/s]."""
    forces: tuple[Floats, Floats]
    """Forces at inner and outer raceway, shape (phases, rollers) [N]."""


class QuasiSteady:
    """The films and the thermal network of a configured bearing, at any speed, load and loss of lubricant."""

    def __init__(self, configuration: Configuration) -> None:
        self.configuration = configuration
        self.network = heat_network(configuration.bearing, configuration.thermal)
        self._material = material_of(configuration.bearing)
        self._sites = inner_site(self._material), outer_site(self._material)

    def running(self, speed: float | None = None, load: float | None = None, clearance: float | None = None) -> Running:
        """Return the bearing at a speed [rad/s], under a load [N] with a radial clearance [m]; by default the configured ones."""
        c, b = self.configuration, self.configuration.bearing
        speed = c.operating.speed if speed is None else speed
        carried = load_and_weight(c) if load is None else load
        gap = b.radial_gap - c.faults.condition.clearance if clearance is None else clearance
        orbit = cage_speed(c, speed)
        inner = roller_forces(c, carried, gap)
        outer = inner + b.roller_mass * orbit**2 * b.pitch_radius
        rolling = (orbit - speed) * b.inner_raceway_radius, orbit * b.outer_raceway_radius
        return Running(speed, orbit, rolling, (inner, outer))

    def power(self, running: Running, temperatures: Sequence[float], loss: float = 0.0) -> list[Heat]:
        """Return the heat of each row at the temperatures of the network's nodes [deg C] after a loss of lubricant [-]."""
        conductances = []
        for row in range(self.network.rows):
            inlets = self.inlets(temperatures, row)
            oil = lubrication_at(self.configuration, self._material, loss, *inlets)
            raceways = [self._rolling(oil, running, number) for number in (0, 1)]
            conductances.append((*raceways, self._rest(oil, running, loss)))
        return conductances  # type: ignore[return-value]

    def inlets(self, temperatures: Sequence[float], row: int) -> tuple[float, float]:
        """Return the temperatures of the oil at the inlets of a row's inner and outer contacts [deg C]: means of ring and rollers."""
        n = self.network
        rollers = temperatures[n.rollers(row)]
        return 0.5 * (temperatures[n.inner(row)] + rollers), 0.5 * (temperatures[n.outer(row)] + rollers)

    def film(self, running: Running, temperatures: Sequence[float], loss: float = 0.0) -> tuple[float, float]:
        """Return the central film [m] of the most loaded contact of row 1 at the inner raceway, and its ratio to the roughness [-]."""
        oil = lubrication_at(self.configuration, self._material, loss, *self.inlets(temperatures, 0))
        thickness, ratio = film_thickness(film_at(oil, 0, running.rolling[0]), float(running.forces[0].max()))
        return float(thickness), float(ratio)

    def refuse_thick_films(self, running: Running, temperatures: Sequence[float], loss: float = 0.0) -> None:
        """Refuse films that fill the radial gap of a row at the temperatures of the network's nodes [deg C] after a loss of lubricant [-].

        Raises:
            Refusal: they do.
        """
        for row in range(self.network.rows):
            inlets = self.inlets(temperatures, row)
            oil, gap = lubrication_at(self.configuration, self._material, loss, *inlets), self.configuration.bearing.radial_gap
            films = [film_offset(film_at(oil, number, running.rolling[number])) for number in (0, 1)]
            if sum(films) >= gap:
                raise Refusal(
                    f"bearing: films of {films[0]:.3g} m, {films[1]:.3g} m of oil at {inlets[0]:.3g} and {inlets[1]:.3g} deg C at the "
                    f"start fill the radial gap of {gap:.3g} m: raise thermal.ambient, or take a warm start, or a thinner oil"
                )

    def conductances(self, running: Running) -> Conductances:
        """Return how heat flows."""
        c, length = self.configuration, self.configuration.bearing.roller_length
        both = []
        for site, forces, speed in zip(self._sites, running.forces, running.rolling, strict=True):
            phases = [raceway_conductance(force, site, length, speed) for force in forces]
            both.append(sum(phases) / len(phases))
        raceways = [(both[0], both[1])] * self.network.rows
        return self.network.conductances(raceways, vehicle_speed(c, running.speed), air_speed(c, running.speed))

    def steady(self, running: Running, loss: float = 0.0, start: Sequence[float] | None = None) -> Vector:
        """Return the temperatures at which the bearing makes as much heat as it loses [deg C]; the search begins at ``start``."""
        thermal, flow = self.configuration.thermal, self.conductances(running)
        temperatures = list(start) if start is not None else [thermal.ambient] * (self.network.box + 1)
        for _ in range(DAMPED_STEPS):
            heat = self.network.heat(self.power(running, temperatures, loss), thermal.sun)
            wanted = self.network.steady(flow, heat, thermal.ambient)
            change = [0.5 * (value - present) for value, present in zip(wanted, temperatures, strict=True)]
            temperatures = [present + step for present, step in zip(temperatures, change, strict=True)]
            if max(map(abs, change)) < SETTLED:
                break
        return temperatures

    def after(self, running: Running, temperatures: Sequence[float], duration: float, loss: float = 0.0) -> Vector:
        """Return the temperatures after a step over a duration [s], with the heat of the temperatures before; some 20 s are a good step."""
        thermal = self.configuration.thermal
        heat = self.network.heat(self.power(running, temperatures, loss), thermal.sun)
        return self.network.after(temperatures, self.conductances(running), heat, thermal.ambient, duration)

    def _rolling(self, oil: Any, running: Running, number: int) -> float:
        """Return the power that a row loses in the resistance of a raceway's contacts to rolling [W]: 2 F_R V each."""
        speed = running.rolling[number]
        film, forces = film_at(oil, number, speed), running.forces[number]
        values, counts = np.unique(np.round(forces[forces > LEAST_FORCE], 3), return_counts=True)
        lost = 0.0
        for force, count in zip(values.tolist(), counts.tolist(), strict=True):
            lost += count * 2.0 * film_memory(film, force).resistance * speed
        return float(lost) / len(forces)

    def _rest(self, oil: Any, running: Running, loss: float) -> float:
        """Return what a row loses about its cage and in its seals [W], after a loss of lubricant [-]."""
        c, b = self.configuration, self.configuration.bearing
        rest = seal_heat(c, running.speed) + lost_in_grease(c, running.orbit, loss)
        if law_of(oil).has_cage_oil and has_cage_oil(oil):
            orbit = abs(running.orbit)
            radius = c.cage.land_radius or 0.5 * (b.pitch_radius + b.outer_raceway_radius)
            if c.cage.joint == "pocket":  # pinned rollers are not dragged
                rest += churning(oil) * (orbit * b.pitch_radius) ** 3 * b.rollers_per_row
            rest += land_torque(oil, c.cage.land_clearance, radius) * orbit**2
        return float(rest)
