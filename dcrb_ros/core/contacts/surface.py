"""The heights of raceways and rollers as the rollers feel them.

A contact follows a height H over the angle of its raceway, and the penetration grows by it. Its slope tilts the contact's normal, so that
the contact has a tangential part and the shaft pays for every climb: with the angle theta about the ring's centre at the distance rho,

    d(penetration)/dt = (v + H'/rho t) n,   force on the roller along n + H'/rho t

The heights of a roller act along the radius alone; they are small.

A defect may take a share of the roller's length only. It has heights of its own then, and the force is the sum of both parts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.core.arithmetic import INTEGER_BITS, INTEGERS, angle_of, bits_of
from dcrb_ros.core.contacts.films import raceway_site
from dcrb_ros.core.contacts.force_line import elastic, lasting_line
from dcrb_ros.core.contacts.lines import closing_speeds, linearize_friction, write_force_line
from dcrb_ros.core.jit import kernel, piece
from dcrb_ros.core.laws.interface import BY_CONSTANTS, Registered, by_law, load_memory
from dcrb_ros.core.layout.records import SingleFloats
from dcrb_ros.core.layout.rollers import Nodes, RacewayContact
from dcrb_ros.core.layout.state import OUTER, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.classification import filled

HEIGHT, SLOPE, PART_HEIGHT, PART_SLOPE, SHARE = range(5)
"""Columns of a raceway's table: height [m] and its slope [m/rad] over the whole length of a roller, those of a part of it added there, and
the share of that part [-]."""
TURN = 2.0 * math.pi
INNER_RING, OUTER_RING = 0, 1
LEAST_SQUARE = 1e-24
"""Least square of a distance from the ring's centre, for elements without a roller [m^2]."""


class Smooth(NamedTuple):
    """Raceways and rollers without heights."""


class Profile(NamedTuple):
    """Heights of raceways and rollers, at equal angles over a turn; in single precision, a hundredth of a nanometre, for the cache."""

    raceways: SingleFloats
    """Height [m], its slope [m/rad], and the share of the length that a defect takes [-], of inner and outer raceway, row by row, shape
    (2, rows, nodes, 4); the last column is unused."""
    parts: SingleFloats
    """Height [m] and slope [m/rad] of defects over that share of the length, shape (2, rows, nodes, 2)."""
    rollers: SingleFloats
    """Height [m] and slope [m/rad] of each roller, as the inner raceway feels it and then as the outer one does, shape
    (rows * rollers, nodes, 4)."""


@kernel
def place_of(angle: float, nodes: int) -> tuple[int, float]:
    """Return the node before an angle [rad] on a table of a turn, and the way from there [nodes]; in arithmetic of vectors."""
    turns = angle * (1.0 / TURN)
    place = (turns - np.floor(turns)) * nodes
    node = min(np.floor(place), nodes - 1.0)
    return bits_of(node + INTEGERS) - INTEGER_BITS, place - node


@kernel
def interpolated(before: float, after: float, rise: float, rise_after: float, spacing: float, u: float) -> tuple[float, float]:
    """Return value and slope of the cubic between two nodes, from values and slopes at both; continuous with its slope."""
    chord = after - before
    start, end = rise * spacing, rise_after * spacing
    square, cube = 3.0 * chord - 2.0 * start - end, start + end - 2.0 * chord
    value = before + u * (start + u * (square + u * cube))
    slope = (start + u * (2.0 * square + 3.0 * u * cube)) * (1.0 / spacing)
    return value, slope


@kernel
def felt_at(table: SingleFloats, angle: float, column: int) -> tuple[float, float]:
    """Return height [m] and slope [m/rad] at an angle [rad] of a table over a turn, from two of its columns; for single contacts."""
    nodes = table.shape[0]
    i, u = place_of(angle, nodes)
    j = i + 1 if i + 1 < nodes else 0
    return interpolated(table[i, column], table[j, column], table[i, column + 1], table[j, column + 1], TURN / nodes, u)


@kernel
def tilted(nx: float, ny: float, slope: float) -> tuple[float, float]:
    """Return a unit vector turned towards its left by a small slope [-]."""
    square = slope * slope
    by_length = 1.0 - square * (0.5 - 0.375 * square)
    return (nx - slope * ny) * by_length, (ny + slope * nx) * by_length


@piece
def feel_free_profile(profile: Profile, payload: Payload, state: State, work: Workspace) -> None:
    """Write what all rollers feel at the outer raceway: nodes first, then the values there, then what lies between."""
    rollers, step, count = state.rollers[0], work.rollers[0], filled(payload.free.size)
    nodes = work.outer[0]
    ring_x, ring_y = state.position[OUTER, 0], state.position[OUTER, 1]
    raceway_nodes, roller_nodes = profile.raceways.shape[2], profile.rollers.shape[1]
    for c in range(count):
        angle = angle_of(step.x[c] - ring_x, ring_y - step.y[c])
        nodes.node[c], nodes.way[c] = place_of(angle, raceway_nodes)
        nodes.roller_node[c], nodes.roller_way[c] = place_of(angle - rollers.angle[c], roller_nodes)
    for row in range(payload.free.shape[0]):
        for i in range(payload.free.shape[1]):
            c = row * payload.free.shape[1] + i
            if step.near_outer[c] > 0.0:
                read_node(nodes, c, profile.raceways[OUTER_RING, row], profile.rollers[c], OUTER_RING)
                if nodes.share[c] > 0.0:
                    step.bound[c] = 1.0
    mean_x, mean_y = work.mean_velocity[OUTER, 0], work.mean_velocity[OUTER, 1]
    for c in range(count):
        dx, dy = step.x[c] - ring_x, step.y[c] - ring_y
        by_square = 1.0 / max(dx * dx + dy * dy, LEAST_SQUARE)
        orbit = ((rollers.vy[c] - mean_y) * dx - (rollers.vx[c] - mean_x) * dy) * by_square
        (height, slope), (own, own_slope) = between(nodes, c, raceway_nodes, roller_nodes)
        near = step.near_outer[c] > 0.0
        step.height[c] = height + own if near else 0.0
        step.tilt[c] = slope * math.sqrt(by_square) if near else 0.0
        step.sink_speed[c] = -own_slope * (orbit - rollers.spin[c]) if near else 0.0
        step.share[c] = nodes.share[c] if near else 0.0


@piece
def read_node(nodes: Nodes, k: int, raceway: SingleFloats, roller: SingleFloats, ring: int) -> None:
    """Copy the heights on both sides of a contact from the tables of a raceway and of a roller."""
    i, n, column = nodes.node[k], nodes.roller_node[k], 2 * ring
    j, m = i + 1 if i + 1 < raceway.shape[0] else 0, n + 1 if n + 1 < roller.shape[0] else 0
    nodes.height_before[k], nodes.slope_before[k] = raceway[i, 0], raceway[i, 1]
    nodes.height_after[k], nodes.slope_after[k] = raceway[j, 0], raceway[j, 1]
    nodes.share[k] = max(raceway[i, 2], raceway[j, 2])
    nodes.own_before[k], nodes.own_slope_before[k] = roller[n, column], roller[n, column + 1]
    nodes.own_after[k], nodes.own_slope_after[k] = roller[m, column], roller[m, column + 1]


@kernel
def between(nodes: Nodes, k: int, raceway_nodes: int, roller_nodes: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return height [m] and slope [m/rad] of a raceway, and those of a roller, at a contact between two nodes."""
    raceway = interpolated(
        nodes.height_before[k], nodes.height_after[k], nodes.slope_before[k], nodes.slope_after[k], TURN / raceway_nodes, nodes.way[k]
    )
    before, after, rise, rise_after = nodes.own_before[k], nodes.own_after[k], nodes.own_slope_before[k], nodes.own_slope_after[k]
    return raceway, interpolated(before, after, rise, rise_after, TURN / roller_nodes, nodes.roller_way[k])


@piece
def feel_bound_profile(
    profile: Profile, payload: Payload, state: State, work: Workspace, contact: RacewayContact, mean: tuple[float, float], inner: bool
) -> None:
    """Add what bound rollers feel at a raceway to their penetrations, and tilt their normals."""
    if inner:
        feel_inner(profile, payload, state, work, contact, mean)
        return
    bound, step = work.bound[0], work.rollers[0]
    for k in range(work.row_ends[work.row_ends.size - 1]):
        c = bound.roller[k]
        contact.penetration[k] += step.height[c]
        contact.sink_speed[k] += step.sink_speed[c]
        contact.share[k] = step.share[c]
        write_tilt(contact, k, step.tilt[c], 0.0)
        if step.share[c] > 0.0:
            azimuth = angle_of(contact.radial_x[k], -contact.radial_y[k])
            contact.part_height[k], contact.part_slope[k] = felt_at(profile.parts[OUTER_RING, bound.row[k]], azimuth, 0)


@piece
def feel_inner(
    profile: Profile, payload: Payload, state: State, work: Workspace, contact: RacewayContact, mean: tuple[float, float]
) -> None:
    """Add what bound rollers feel at the inner raceway to their penetrations, and tilt their normals; by vectors, as for the outer one."""
    bound, step, found = work.bound[0], work.inner[0], work.row_ends[work.row_ends.size - 1]
    raceway_nodes, roller_nodes, turn, speed = profile.raceways.shape[2], profile.rollers.shape[1], state.shaft[0], state.shaft[1]
    for k in range(found):
        step.roller_way[k] = state.rollers[0].angle[bound.roller[k]]
    for k in range(filled(found)):
        azimuth = angle_of(contact.radial_x[k], -contact.radial_y[k])
        rotation = step.roller_way[k]
        step.node[k], step.way[k] = place_of(azimuth - turn, raceway_nodes)
        step.roller_node[k], step.roller_way[k] = place_of(azimuth + 0.5 * TURN - rotation, roller_nodes)
    for k in range(found):
        read_node(step, k, profile.raceways[INNER_RING, bound.row[k]], profile.rollers[bound.roller[k]], INNER_RING)
    for k in range(filled(found)):
        rx, ry, by_distance = contact.radial_x[k], contact.radial_y[k], 1.0 / contact.distance[k]
        orbit = ((bound.predicted_vy[k] - mean[1]) * rx - (bound.predicted_vx[k] - mean[0]) * ry) * by_distance
        (height, slope), (own, own_slope) = between(step, k, raceway_nodes, roller_nodes)
        contact.penetration[k] += height + own
        contact.sink_speed[k] -= own_slope * (orbit - bound.predicted_rim[k] / payload.roller_radius)
        contact.share[k] = step.share[k]
        write_tilt(contact, k, -slope * by_distance, speed)
    for k in range(found, filled(found)):
        contact.penetration[k] = -1.0
    for k in range(found):
        if contact.share[k] > 0.0:
            azimuth = angle_of(contact.radial_x[k], -contact.radial_y[k])
            contact.part_height[k], contact.part_slope[k] = felt_at(profile.parts[INNER_RING, bound.row[k]], azimuth - turn, 0)


@piece
def write_tilt(contact: RacewayContact, k: int, slope: float, speed: float) -> None:
    """Tilt the normal of a contact by a slope [-] along the raceway, which turns at a speed [rad/s]."""
    contact.tilt[k] = slope
    nx, ny = tilted(contact.radial_x[k], contact.radial_y[k], slope)
    contact.normal_x[k], contact.normal_y[k] = nx, ny
    contact.surface_speed_normal[k] = speed * contact.distance[k] * (contact.radial_x[k] * ny - contact.radial_y[k] * nx)


@piece
def linearize_parts(
    profile: Profile,
    payload: Payload,
    state: State,
    work: Workspace,
    contact: RacewayContact,
    mean: tuple[float, float],
    old: tuple[float, float],
    ring_speed: float,
    inner: bool,
) -> None:
    """Replace force, normal and friction where a defect takes a part of the roller's length: both parts together."""
    bound, side, site, law = work.bound[0], 1.0 if inner else -1.0, raceway_site(payload, work, inner), payload.normal_law
    surface = ring_speed * payload.inner_raceway_radius
    for k in range(work.row_ends[work.row_ends.size - 1]):
        share = contact.share[k]
        if share > 0.0:
            memory, penetration = load_memory(law, contact.normal, k), contact.penetration[k]
            whole, stiffness = elastic(law, memory, penetration, site)
            part, part_stiffness = elastic(law, memory, penetration + contact.part_height[k], site)
            force = (1.0 - share) * whole + share * part
            stiffness = (1.0 - share) * stiffness + share * part_stiffness
            weight = share * part / force if force > 0.0 else share
            write_tilt(contact, k, contact.tilt[k] - side * weight * contact.part_slope[k] / contact.distance[k], ring_speed)
            closing, before, sink = closing_speeds(bound, contact, k, mean, old, side)
            write_force_line(contact, k, lasting_line(payload, memory, site, penetration, force, stiffness, closing, before, sink))
            linearize_friction(bound, contact, k, mean, ring_speed, surface, inner, site, payload)


def _no_parts(
    profile: Smooth,
    payload: Payload,
    state: State,
    work: Workspace,
    contact: RacewayContact,
    mean: tuple[float, float],
    old: tuple[float, float],
    ring_speed: float,
    inner: bool,
) -> None:
    return None


def _nothing_free(profile: Smooth, payload: Payload, state: State, work: Workspace) -> None:
    return None


def _nothing_bound(
    profile: Smooth, payload: Payload, state: State, work: Workspace, contact: RacewayContact, mean: tuple[float, float], inner: bool
) -> None:
    return None


def _false(profile: Smooth) -> bool:
    return False


def _true(profile: Profile) -> bool:
    return True


_OF_SMOOTH: dict[str, Callable[..., Any]] = {
    "feel_free": _nothing_free,
    "feel_bound": _nothing_bound,
    "add_parts": _no_parts,
    "uneven": _false,
}
_OF_PROFILE: dict[str, Callable[..., Any]] = {
    "feel_free": feel_free_profile,
    "feel_bound": feel_bound_profile,
    "add_parts": linearize_parts,
    "uneven": _true,
}
BY_CONSTANTS[Smooth], BY_CONSTANTS[Profile] = Registered(None, _OF_SMOOTH), Registered(None, _OF_PROFILE)


@by_law
def feel_free(surfaces: Any, payload: Payload, state: State, work: Workspace) -> None:
    """Write what all rollers near the outer raceway feel there."""


@by_law
def feel_bound(
    surfaces: Any, payload: Payload, state: State, work: Workspace, contact: RacewayContact, mean: tuple[float, float], inner: bool
) -> None:
    """Add what bound rollers feel at a raceway to their penetrations, and tilt their normals."""


@by_law
def add_parts(
    surfaces: Any,
    payload: Payload,
    state: State,
    work: Workspace,
    contact: RacewayContact,
    mean: tuple[float, float],
    old: tuple[float, float],
    ring_speed: float,
    inner: bool,
) -> None:
    """Replace force, normal and friction where a defect takes a part of the roller's length."""


@by_law
def uneven(surfaces: Any) -> bool:  # type: ignore[empty-body]
    """Return whether surfaces have heights: a constant for the compiler."""
