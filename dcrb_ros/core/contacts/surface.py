"""The heights of raceways and rollers at their contacts.

A contact follows a height H over the angle of its raceway, and the penetration grows by it. Its slope tilts the contact's normal, so that
the contact has a tangential part and the shaft does the work of a climb: with the angle theta about the ring's centre at the distance rho,

    d(penetration)/dt = (v + H'/rho t) n,   force on the roller along n + H'/rho t

The heights of a roller act along the radius alone; they are small.

A defect may take a share of the roller's length only. It has heights of its own then, and the force is the sum of both parts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from dcrb_ros.core.arithmetic import angle_of
from dcrb_ros.core.contacts.films import raceway_site
from dcrb_ros.core.contacts.force_line import elastic, open_below
from dcrb_ros.core.contacts.heights import (
    TURN,
    Profile,
    Smooth,
    between,
    clear_node,
    interpolated,
    marked,
    nodes_ahead,
    place_of,
    read_node,
)
from dcrb_ros.core.contacts.impacts import Impacts, mark_strength, mark_under, write_unequal_part
from dcrb_ros.core.contacts.lines import RingMotion, replace_lines
from dcrb_ros.core.contacts.tilt import write_tilt
from dcrb_ros.core.jit import YES, piece
from dcrb_ros.core.laws.calls import load_memory
from dcrb_ros.core.laws.registry import BY_CONSTANTS, Registered, by_law
from dcrb_ros.core.layout.cages import of_cages, of_row
from dcrb_ros.core.layout.contacts import RacewayContact
from dcrb_ros.core.layout.state import OUTER, SHAFT_ANGLE, SHAFT_SPEED, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.classification import filled

INNER_RING, OUTER_RING = 0, 1


@piece
def write_pinned_velocities(payload: Payload, state: State, work: Workspace) -> None:
    """Write the velocities of pinned rollers before the step, with which their cages carry them."""
    rollers, step, cages, pitch = state.rollers[0], work.rollers[0], of_cages(state.velocity), payload.pitch_radius
    for c in range(filled(payload.free.size)):
        cage_x, cage_y, turn = of_row(cages, rollers.second_row[c])
        free = rollers.free[c] > 0.0
        rollers.vx[c] = rollers.vx[c] if free else cage_x + pitch * turn * step.tangent_x[c]
        rollers.vy[c] = rollers.vy[c] if free else cage_y + pitch * turn * step.tangent_y[c]


@piece
def write_free_profile(profile: Profile | Impacts, payload: Payload, state: State, work: Workspace) -> None:
    """Write height, tilt and sink speed of all rollers at the outer raceway: first the nodes, then their values, then between them."""
    rollers, step, count = state.rollers[0], work.rollers[0], filled(payload.free.size)
    nodes = work.outer[0]
    if not payload.all_free:
        write_pinned_velocities(payload, state, work)
    ring_x, ring_y = state.position[OUTER, 0], state.position[OUTER, 1]
    raceway_nodes, roller_nodes = profile.raceways.shape[2] - 1, profile.rollers.shape[2] - 1
    for c in range(count):
        angle = angle_of(step.x[c] - ring_x, ring_y - step.y[c])
        nodes.node[c], nodes.way[c] = place_of(angle, raceway_nodes)
        nodes.roller_node[c], nodes.roller_way[c] = place_of(angle - rollers.angle[c], roller_nodes)
    ahead = nodes_ahead(state.shaft[SHAFT_SPEED])
    for row in range(payload.free.shape[0]):
        for i in range(payload.free.shape[1]):
            c = row * payload.free.shape[1] + i
            read_node(nodes, c, profile.raceways[OUTER_RING, row], profile.rollers[OUTER_RING, c], ahead, ahead)
    mean_x, mean_y = work.mean_velocity[OUTER, 0], work.mean_velocity[OUTER, 1]
    by_reach, share = 1.0 / (payload.outer_raceway_radius - payload.roller_radius), payload.spin_share
    for c in range(count):
        dx, dy = step.x[c] - ring_x, step.y[c] - ring_y
        # Of rollers near the raceway the distance is its reach within a hundredth: series replace a root and a quotient.
        beyond = (dx * dx + dy * dy) * (by_reach * by_reach) - 1.0
        by_square = by_reach * by_reach * (1.0 - beyond * (1.0 - beyond * (1.0 - beyond)))
        by_distance = by_reach * (1.0 - beyond * (0.5 - beyond * (0.375 - beyond * 0.3125)))
        orbit = ((rollers.vy[c] - mean_y) * dx - (rollers.vx[c] - mean_x) * dy) * by_square
        (height, slope), (roller_height, roller_slope) = between(nodes, c, raceway_nodes, roller_nodes)
        near = step.near_outer[c] > 0.0
        step.height[c] = height + roller_height if near else 0.0
        step.tilt[c] = slope * by_distance if near else 0.0
        step.sink_speed[c] = -roller_slope * (share * (orbit - rollers.spin[c])) if near else 0.0
        over_part = marked(nodes.before[c]) if near else 0.0
        step.over_part[c], step.bound[c] = over_part, max(step.bound[c], over_part)


@piece
def write_free_unequal(impacts: Impacts, payload: Payload, state: State, work: Workspace) -> None:
    """Write the same with marks on balls whose axes of spin change."""
    write_free_profile(impacts, payload, state, work)
    rollers, step, nodes, time = state.rollers[0], work.rollers[0], work.outer[0], state.tick[0] * payload.step
    for mark in range(impacts.marked.size):
        c = impacts.marked[mark]
        strength = mark_strength(impacts, OUTER_RING, mark, time)
        if strength > 0.0 and step.near_outer[c] > 0.0:
            height, slope = mark_under(impacts, OUTER_RING, mark, nodes.roller_node[c], nodes.roller_way[c])
            dx, dy = step.x[c] - state.position[OUTER, 0], step.y[c] - state.position[OUTER, 1]
            vx, vy = rollers.vx[c] - work.mean_velocity[OUTER, 0], rollers.vy[c] - work.mean_velocity[OUTER, 1]
            orbit = (vy * dx - vx * dy) / (dx * dx + dy * dy)
            step.height[c] += strength * height
            step.sink_speed[c] -= strength * slope * (payload.spin_share * (orbit - rollers.spin[c]))


@piece
def add_inner_marks(impacts: Impacts, payload: Payload, state: State, work: Workspace, contact: RacewayContact, ring: RingMotion) -> None:
    """Add marks on balls whose axes of spin change to the penetrations at the inner raceway."""
    bound, step, time = work.bound[0], work.inner[0], state.tick[0] * payload.step
    for mark in range(impacts.marked.size):
        strength = mark_strength(impacts, INNER_RING, mark, time)
        for k in range(work.row_ends[work.row_ends.size - 1]):
            if strength > 0.0 and bound.roller[k] == impacts.marked[mark]:
                height, slope = mark_under(impacts, INNER_RING, mark, step.roller_node[k], step.roller_way[k])
                rx, ry = contact.radial_x[k], contact.radial_y[k]
                orbit = ((bound.predicted_vy[k] - ring.mean[1]) * rx - (bound.predicted_vx[k] - ring.mean[0]) * ry) / contact.distance[k]
                contact.penetration[k] += strength * height
                passing = payload.spin_share * (orbit - bound.predicted_rim[k] / payload.roller_radius)
                contact.sink_speed[k] -= strength * slope * passing


@piece
def add_bound_profile(profile: Profile, payload: Payload, state: State, work: Workspace, contact: RacewayContact, ring: RingMotion) -> None:
    """Add the heights under bound rollers at a raceway to their penetrations, and tilt their normals."""
    if ring.inner:
        add_inner_profile(profile, payload, state, work, contact, ring)
        return
    bound, step, end = work.bound[0], work.rollers[0], work.row_ends[work.row_ends.size - 1]
    for k in range(end):
        c = bound.roller[k]
        contact.penetration[k] += step.height[c]
        contact.sink_speed[k] += step.sink_speed[c]
        contact.tilt[k], contact.share[k] = step.tilt[c], step.over_part[c]
    for k in range(filled(end)):
        write_tilt(contact, k, contact.tilt[k], 0.0)
    nodes = work.outer[0]
    for k in range(end):
        if contact.share[k] > 0.0:
            c = bound.roller[k]
            write_damage(profile, payload, state, contact, k, OUTER_RING, bound.row[k], c, nodes.node[c], nodes.way[c])


@piece
def add_inner_profile(profile: Profile, payload: Payload, state: State, work: Workspace, contact: RacewayContact, ring: RingMotion) -> None:
    """Add the heights under bound rollers at the inner raceway to their penetrations, and tilt their normals, in loops over vectors.

    Idle rollers against a bar are bound, too: a contact that stays open has no heights.
    """
    bound, step, end = work.bound[0], work.inner[0], work.row_ends[work.row_ends.size - 1]
    raceway_nodes, roller_nodes, turn, speed = (
        profile.raceways.shape[2] - 1,
        profile.rollers.shape[2] - 1,
        state.shaft[SHAFT_ANGLE],
        state.shaft[SHAFT_SPEED],
    )
    by_radius, share = 1.0 / payload.roller_radius, payload.spin_share
    for k in range(end):
        step.roller_way[k] = state.rollers[0].angle[bound.roller[k]]
    for k in range(filled(end)):
        azimuth = angle_of(contact.radial_x[k], -contact.radial_y[k])
        rotation = step.roller_way[k]
        step.node[k], step.way[k] = place_of(azimuth - turn, raceway_nodes)
        step.roller_node[k], step.roller_way[k] = place_of(azimuth + 0.5 * TURN - rotation, roller_nodes)
    least, ahead = open_below(payload, raceway_site(payload, state, YES)), nodes_ahead(speed)
    # The inner ring turns faster than the rollers orbit: on it, contacts move back.
    for k in range(end):
        if contact.penetration[k] > least:
            row, c = np.uint64(bound.row[k]), np.uint64(bound.roller[k])
            read_node(step, k, profile.raceways[INNER_RING, row], profile.rollers[INNER_RING, c], -ahead, ahead)
        else:
            clear_node(step, k)
    for k in range(filled(end)):
        rx, ry, by_distance = contact.radial_x[k], contact.radial_y[k], 1.0 / contact.distance[k]
        orbit = ((bound.predicted_vy[k] - ring.mean[1]) * rx - (bound.predicted_vx[k] - ring.mean[0]) * ry) * by_distance
        (height, slope), (roller_height, roller_slope) = between(step, k, raceway_nodes, roller_nodes)
        contact.penetration[k] += height + roller_height
        contact.sink_speed[k] -= roller_slope * (share * (orbit - bound.predicted_rim[k] * by_radius))
        contact.share[k] = marked(step.before[k])
        write_tilt(contact, k, -slope * by_distance, speed)
    for k in range(end, filled(end)):
        contact.penetration[k] = -1.0
    for k in range(end):
        if contact.share[k] > 0.0:
            write_damage(profile, payload, state, contact, k, INNER_RING, bound.row[k], bound.roller[k], step.node[k], step.way[k])
    add_marks(profile, payload, state, work, contact, ring)


@piece
def write_part(
    profile: Profile, payload: Payload, state: State, contact: RacewayContact, k: int, ring: int, row: int, c: int, node: int, way: float
) -> None:
    """Write height and tilt of a defect over a share of the length, between a node and the next one, and that share."""
    parts = profile.parts[ring, row]
    i, j, spacing = node, node + 1 if node + 1 < parts.shape[0] else 0, TURN / parts.shape[0]
    contact.share[k] = max(parts[i, 2], parts[j, 2])
    contact.part_height[k], slope = interpolated(parts[i, 0], parts[j, 0], parts[i, 1], parts[j, 1], spacing, way)
    contact.part_tilt[k] = slope / contact.distance[k]


@piece
def linearize_parts(
    profile: Profile,
    payload: Payload,
    state: State,
    work: Workspace,
    contact: RacewayContact,
    ring: RingMotion,
) -> None:
    """Replace force, normal and friction where a defect takes a part of the roller's length: both parts together."""
    if not profile.partial:
        return
    bound, side, site, law = work.bound[0], 1.0 if ring.inner else -1.0, raceway_site(payload, state, ring.inner), payload.normal_law
    for k in range(work.row_ends[work.row_ends.size - 1]):
        share = contact.share[k]
        if share > 0.0:
            memory, penetration = load_memory(law, contact.normal, k), contact.penetration[k]
            whole, stiffness = elastic(law, memory, penetration, site)
            part, part_stiffness = elastic(law, memory, penetration + contact.part_height[k], site)
            force = whole + share * (part - whole)
            stiffness += share * (part_stiffness - stiffness)
            weight = share * part / force if force > 0.0 else share
            write_tilt(contact, k, contact.tilt[k] - side * weight * contact.part_tilt[k], ring.speed)
            replace_lines(payload, bound, contact, k, memory, site, penetration, force, stiffness, ring)


def _no_parts(
    profile: Smooth,
    payload: Payload,
    state: State,
    work: Workspace,
    contact: RacewayContact,
    ring: RingMotion,
) -> None:
    return None


def _nothing_free(profile: Smooth, payload: Payload, state: State, work: Workspace) -> None:
    return None


def _nothing_bound(profile: Smooth, payload: Payload, state: State, work: Workspace, contact: RacewayContact, ring: RingMotion) -> None:
    return None


def _no_marks(profile: Profile, payload: Payload, state: State, work: Workspace, contact: RacewayContact, ring: RingMotion) -> None:
    return None


def _false(profile: Smooth) -> bool:
    return False


def _true(profile: Profile) -> bool:
    return True


_OF_SMOOTH: dict[str, Callable[..., Any]] = {
    "write_free_heights": _nothing_free,
    "add_bound_heights": _nothing_bound,
    "add_parts": _no_parts,
    "uneven": _false,
}
_OF_PROFILE: dict[str, Callable[..., Any]] = {
    "write_free_heights": write_free_profile,
    "add_bound_heights": add_bound_profile,
    "add_parts": linearize_parts,
    "write_damage": write_part,
    "add_marks": _no_marks,
    "uneven": _true,
}
_OF_IMPACTS: dict[str, Callable[..., Any]] = _OF_PROFILE | {
    "write_free_heights": write_free_unequal,
    "write_damage": write_unequal_part,
    "add_marks": add_inner_marks,
}
BY_CONSTANTS[Smooth], BY_CONSTANTS[Profile] = Registered(None, _OF_SMOOTH), Registered(None, _OF_PROFILE)
BY_CONSTANTS[Impacts] = Registered(None, _OF_IMPACTS)


@by_law
def write_free_heights(surfaces: Any, payload: Payload, state: State, work: Workspace) -> None:
    """Write height, tilt and sink speed of all rollers near the outer raceway."""


@by_law
def add_bound_heights(surfaces: Any, payload: Payload, state: State, work: Workspace, contact: RacewayContact, ring: RingMotion) -> None:
    """Add the heights under bound rollers at a raceway to their penetrations, and tilt their normals."""


@by_law
def add_parts(
    surfaces: Any,
    payload: Payload,
    state: State,
    work: Workspace,
    contact: RacewayContact,
    ring: RingMotion,
) -> None:
    """Replace force, normal and friction where a defect takes a part of the roller's length."""


@by_law
def write_damage(
    surfaces: Any, payload: Payload, state: State, contact: RacewayContact, k: int, ring: int, row: int, c: int, node: int, way: float
) -> None:
    """Write height and tilt of the damage under contact ``k`` of roller ``c`` with a raceway, and the share of the length it takes."""


@by_law
def add_marks(surfaces: Any, payload: Payload, state: State, work: Workspace, contact: RacewayContact, ring: RingMotion) -> None:
    """Add damage of rollers that has tables of its own to the penetrations at the inner raceway."""


@by_law
def uneven(surfaces: Any) -> bool:  # type: ignore[empty-body]
    """Return whether surfaces have heights: a constant for the compiler."""
