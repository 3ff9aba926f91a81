"""The contact of a free roller with the outer raceway, as lines over its mean velocity past the ring."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from dcrb_ros.core.contacts.films import contact_site, raceway_site
from dcrb_ros.core.contacts.force_line import elastic, lasting_line
from dcrb_ros.core.contacts.surface import uneven
from dcrb_ros.core.contacts.tilt import tilted
from dcrb_ros.core.jit import NO, piece
from dcrb_ros.core.laws.calls import film_resistance, load_memory, traction_line
from dcrb_ros.core.laws.site import Site
from dcrb_ros.core.layout.cages import OfCages, Triple, of_cages
from dcrb_ros.core.layout.state import OUTER, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload

LEAST_DISTANCE = 1e-12
"""Least distance from the ring's centre, for elements without a roller [m]."""


class Surroundings(NamedTuple):
    """Outer ring and cages over a step, read once before the loop over rollers."""

    site: Site
    """Contact of a roller with the outer raceway."""
    ring: tuple[float, float]
    """Centre of the outer ring [m]."""
    mean: tuple[float, float]
    """Its mean velocity, as predicted [m/s]."""
    before: tuple[float, float]
    """Its velocity before the step [m/s]."""
    cages: OfCages
    """Centres [m] and angles [rad] of the cages."""
    cage_motion: OfCages
    """Their mean velocities [m/s, m/s, rad/s], as predicted."""


class ContactLine(NamedTuple):
    """A contact with the outer raceway: normal force and friction as lines over the mean velocity of a free roller past the ring."""

    nx: float
    """Normal, away from the ring's centre [-]."""
    ny: float
    sink: float
    """Speed at which the depth of notches grows [m/s]."""
    penetration: float
    """In the middle of the step [m]."""
    force_offset: float
    """Normal force at rest [N]."""
    force_slope: float
    """[N s/m]"""
    expected_force: float
    """Normal force at the speed of approach ``expected_closing`` [N]."""
    damping: float
    """[N s/m]"""
    expected_closing: float
    """[m/s]"""
    friction_offset: float
    """Friction without slip [N]."""
    friction_slope: float
    """[N s/m]"""
    resistance: float
    """Resistance of the film to rolling [N]."""
    normal_memory: Any
    """What the law of the normal force remembers of the contact."""
    traction_memory: Any
    kept: Any
    """What the traction law keeps for the end of the step."""


@piece
def surroundings(payload: Payload, state: State, work: Workspace) -> Surroundings:
    """Return outer ring and cages as free rollers meet them."""
    position, mean, before = state.position, work.mean_velocity, state.velocity
    return Surroundings(
        raceway_site(payload, state, NO),
        (position[OUTER, 0], position[OUTER, 1]),
        (mean[OUTER, 0], mean[OUTER, 1]),
        (before[OUTER, 0], before[OUTER, 1]),
        of_cages(position),
        of_cages(mean),
    )


@piece
def contact_line(payload: Payload, state: State, work: Workspace, around: Surroundings, old: Triple, c: int) -> ContactLine:
    """Return the contact of a free roller with the outer raceway; ``old`` is its velocity [m/s] and spin [rad/s] before the step."""
    rollers, step, outer, site, radius = state.rollers[0], work.rollers[0], state.rollers[0].outer, around.site, payload.roller_radius
    dx, dy = rollers.x[c] - around.ring[0], rollers.y[c] - around.ring[1]
    distance = max(math.sqrt(dx * dx + dy * dy), LEAST_DISTANCE)
    nx, ny, sink, height = dx / distance, dy / distance, step.sink_speed[c], 0.0
    if uneven(payload.surfaces):
        (nx, ny), height = tilted(nx, ny, step.tilt[c]), step.height[c]
    normal_memory, traction_memory = load_memory(payload.normal_law, outer.normal, c), load_memory(payload.traction_law, outer.traction, c)

    vx, vy = old[0] + 0.5 * rollers.change_vx[c] - around.mean[0], old[1] + 0.5 * rollers.change_vy[c] - around.mean[1]
    along = vy * nx - vx * ny
    before = (old[0] - around.before[0]) * nx + (old[1] - around.before[1]) * ny - sink
    penetration = distance - (payload.outer_raceway_radius - radius) - step.notch_depth[c] + height
    force, stiffness = elastic(payload.normal_law, normal_memory, penetration, site)
    force_offset, force_slope, expected_force, damping, expected_closing = lasting_line(
        payload, normal_memory, site, penetration, force, stiffness, vx * nx + vy * ny - sink, before, sink
    )
    slip, rolling = along + radius * old[2] + 0.5 * radius * rollers.change_spin[c], along / distance * site.raceway_radius
    here = contact_site(payload, site, outer.film, c)
    offset, slope, kept = traction_line(payload.traction_law, traction_memory, slip, rolling, expected_force, here, payload.step)
    return ContactLine(
        nx,
        ny,
        sink,
        penetration,
        force_offset,
        force_slope,
        expected_force,
        damping,
        expected_closing,
        offset * expected_force,
        slope * expected_force,
        film_resistance(here.film, here.memory, expected_force),
        normal_memory,
        traction_memory,
        kept,
    )
