"""The contact of a bound roller with a raceway as a line over the mean velocities of a step."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from dcrb_ros.core.contacts.films import contact_site
from dcrb_ros.core.contacts.force_line import lasting_line
from dcrb_ros.core.jit import piece
from dcrb_ros.core.laws.calls import film_resistance, load_memory, store_kept, store_resistance, traction_line
from dcrb_ros.core.laws.site import Site
from dcrb_ros.core.layout.contacts import RacewayContact
from dcrb_ros.core.layout.rollers import BoundRollers
from dcrb_ros.core.payload import Payload


class RingMotion(NamedTuple):
    """How a ring moves over a step, as its contacts see it."""

    mean: tuple[float, float]
    """Predicted mean velocity [m/s]."""
    before: tuple[float, float]
    """Velocity before the step [m/s]."""
    speed: float
    """Angular speed [rad/s]."""
    surface: float
    """Speed of its raceway's surface [m/s]."""
    inner: bool
    """Whether it is the inner ring."""


@piece
def locate(bound: BoundRollers, contact: RacewayContact, k: int, ring_x: float, ring_y: float, reach: float, side: float) -> None:
    """Write direction, distance and penetration between a roller and a smooth raceway.

    ``reach`` [m] is the distance at which a contact closes, ``side`` is 1 at the inner ring and -1 at the outer.
    """
    dx, dy = bound.x[k] - ring_x, bound.y[k] - ring_y
    distance = math.sqrt(dx * dx + dy * dy)
    nx, ny = dx / distance, dy / distance
    contact.radial_x[k], contact.radial_y[k] = nx, ny
    contact.normal_x[k], contact.normal_y[k] = nx, ny
    contact.distance[k] = distance
    contact.penetration[k] = side * (reach - distance)
    contact.sink_speed[k] = contact.surface_speed_normal[k] = 0.0


@piece
def closing_speeds(bound: BoundRollers, contact: RacewayContact, k: int, ring: RingMotion) -> tuple[float, float, float]:
    """Return the speeds of penetration expected and before the step, and that at which the floor of a notch falls away [m/s]."""
    side = 1.0 if ring.inner else -1.0
    nx, ny = contact.normal_x[k], contact.normal_y[k]
    vx, vy = bound.predicted_vx[k] - ring.mean[0], bound.predicted_vy[k] - ring.mean[1]
    ux, uy = bound.vx[k] - ring.before[0], bound.vy[k] - ring.before[1]
    surface_n, sink = contact.surface_speed_normal[k], contact.sink_speed[k]
    return -side * (vx * nx + vy * ny - surface_n) - sink, -side * (ux * nx + uy * ny - surface_n) - sink, sink


@piece
def write_force_line(contact: RacewayContact, k: int, line: tuple[float, float, float, float, float]) -> None:
    """Write a `force_line`."""
    contact.force_offset[k], contact.force_slope[k], contact.expected_force[k] = line[0], line[1], line[2]
    contact.damping[k], contact.expected_closing[k] = line[3], line[4]


@piece
def replace_lines(
    payload: Payload,
    bound: BoundRollers,
    contact: RacewayContact,
    k: int,
    memory: Any,
    site: Site,
    penetration: float,
    force: float,
    stiffness: float,
    ring: RingMotion,
) -> None:
    """Write normal force and friction of a lasting contact of an elastic ``force`` [N] and ``stiffness`` [N/m] along its own normal."""
    closing, before, sink = closing_speeds(bound, contact, k, ring)
    write_force_line(contact, k, lasting_line(payload, memory, site, penetration, force, stiffness, closing, before, sink))
    linearize_friction(bound, contact, k, ring, site, payload)


@piece
def linearize_friction(bound: BoundRollers, contact: RacewayContact, k: int, ring: RingMotion, site: Site, payload: Payload) -> None:
    """Write the friction of a contact with a ring as a line over the slip, and the resistance of its film."""
    side, law = 1.0 if ring.inner else -1.0, payload.traction_law
    rx, ry = contact.radial_x[k], contact.radial_y[k]
    along = (bound.predicted_vy[k] - ring.mean[1]) * rx - (bound.predicted_vx[k] - ring.mean[0]) * ry
    slip, force = along - side * bound.predicted_rim[k] - ring.surface, contact.expected_force[k]
    here = contact_site(payload, site, contact.film, k)
    rolling = (along / contact.distance[k] - ring.speed) * site.raceway_radius
    offset, slope, kept = traction_line(law, load_memory(law, contact.traction, k), slip, rolling, force, here, payload.step)
    contact.friction_offset[k], contact.friction_slope[k] = offset * force, slope * force
    store_kept(law, contact.kept, k, kept)
    store_resistance(payload.lubrication, contact.film, k, film_resistance(here.film, here.memory, force))
