"""What temperatures and lost lubricant change of the kernels' constants: the oil, friction at the cage, and the radii of the raceways.

Rings and rollers expand freely by alpha r (T - 20 deg C); a seat may restrain the outer ring. The films of both rows have the mean
temperature of their inlets, and both rows the mean radii, since the kernels have one film and one radius for each raceway.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from dcrb_ros.bearing.heat_network import HeatNetwork
from dcrb_ros.bearing.lubricant_condition import cage_friction_of, lubrication_at
from dcrb_ros.core.laws.calls import film_at
from dcrb_ros.core.laws.site import Material
from dcrb_ros.core.layout.state import State
from dcrb_ros.core.payload import Payload
from dcrb_ros.settings.configuration import Configuration

EXPANSION = 11.9e-6
"""alpha of bearing steel [1/K]."""
MEASURED_AT = 20.0
"""Temperature at which the bearing has its configured radii [deg C]."""
OIL_RESOLUTION = 2.0**-4
"""Step of the temperature at which the oil's constants are evaluated [K]: 0.2 % of a viscosity."""
LOSS_RESOLUTION = 2.0**-8
"""Step of the share of lost lubricant [-]."""
RADIUS_RESOLUTION = 2.0**-30
"""Step of a radius [m]; with the two above, the last bits of a temperature reach no sample."""


class OilState(NamedTuple):
    """What the constants of lubrication depend on."""

    loss: float
    """Share of the lubricant that is lost [-]."""
    inner: float
    """Temperature at the inlets of the inner raceway [deg C]."""
    outer: float
    """The same of the outer raceway."""
    overfill: float
    """Share of grease about the rollers of an overfilled bearing, otherwise 0 [-]."""


class Growth(NamedTuple):
    """By how much radii are larger than configured [m]."""

    inner: float
    outer: float
    roller: float

    @property
    def clearance(self) -> float:
        """By how much the radial gap is larger [m]."""
        return self.outer - self.inner - 2.0 * self.roller


def oil_state(loss: float, inner: float, outer: float, overfill: float) -> OilState:
    """Return the state of the oil, loss and temperatures rounded to the resolutions above."""
    return OilState(
        round(loss / LOSS_RESOLUTION) * LOSS_RESOLUTION,
        round(inner / OIL_RESOLUTION) * OIL_RESOLUTION,
        round(outer / OIL_RESOLUTION) * OIL_RESOLUTION,
        overfill,
    )


def expansion(configuration: Configuration, network: HeatNetwork, temperatures: Sequence[float]) -> Growth:
    """Return by how much the radii grow at the temperatures of the nodes [deg C], the means of the rows."""
    b, rows = configuration.bearing, network.rows
    inner, rollers, outer = (
        EXPANSION * (sum(temperatures[node(row)] for row in range(rows)) / rows - MEASURED_AT)
        for node in (network.inner, network.rollers, network.outer)
    )
    free = 1.0 - configuration.thermal.seat_restraint
    return Growth(inner * b.inner_raceway_radius, outer * b.outer_raceway_radius * free, rollers * b.roller_radius)


def rounded(growth: Growth) -> Growth:
    """Return a growth rounded to `RADIUS_RESOLUTION`."""
    return Growth(*(round(part / RADIUS_RESOLUTION) * RADIUS_RESOLUTION for part in growth))


def oiled(configuration: Configuration, material: Material, payload: Payload, oil: OilState, rolling: tuple[float, float]) -> Payload:
    """Return the payload with the oil in a state; ``rolling`` are the speeds at which the rollers roll over both raceways [m/s]."""
    law = lubrication_at(configuration, material, oil.loss, oil.inner, oil.outer)
    return payload._replace(
        lubrication=law,
        cage_traction_law=cage_friction_of(configuration, material, oil.loss),
        inner=payload.inner._replace(film=film_at(law, 0, rolling[0])),
        outer=payload.outer._replace(film=film_at(law, 1, rolling[1])),
    )


def resized(configuration: Configuration, payload: Payload, growth: Growth) -> Payload:
    """Return the payload with radii that have grown."""
    b = configuration.bearing
    return payload._replace(
        inner_raceway_radius=b.inner_raceway_radius + growth.inner,
        outer_raceway_radius=b.outer_raceway_radius + growth.outer,
        roller_radius=b.roller_radius + growth.roller,
    )


def work_of_growth(state: State, change: Growth) -> float:
    """Return the work that a change of the radii does on the contacts under their present forces [J]."""
    inner, outer = (sum(force.ravel().tolist()) for force in (state.inner_force, state.outer_force))
    return float(inner * (change.inner + change.roller) + outer * (change.roller - change.outer))
