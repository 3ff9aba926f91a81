"""The raceway contacts of many rollers at once: how deep, how hard, each as a straight line over the mean velocities of the step."""

from __future__ import annotations

import math

from dcrb_ros.core import lanes as at
from dcrb_ros.core.contact import LEAST_PENETRATION, johnson_force, loss_coefficient, power_force
from dcrb_ros.core.friction import convection_rate, friction_line
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import JOHNSON, SINK, Floats, Integers, Notches, Payload
from dcrb_ros.core.raceway import edge_contact, inner_notch_depth, notch_under, outer_notch_depth, roller_sink
from dcrb_ros.core.state import State
from dcrb_ros.core.work import INNER, OUTER, Workspace

DISPERSION = 1.0 / 12.0
"""Share h^2 k/12 of a stiffness k that is added to the mass: leapfrog then has the right frequency to fourth order."""


@piece
def face(lanes: Floats, contact: int, c: int, ring_x: float, ring_y: float, reach: float, side: float) -> None:
    """Write direction, distance and penetration between a roller and a smooth raceway.

    ``reach`` [m] is the distance at which a contact closes, ``side`` is 1 at the inner ring and -1 at the outer.
    """
    # Places count from the front: said once more, or every access would be checked for a negative one.
    contact, c = max(contact, 0), max(c, 0)
    dx, dy = lanes[at.PLACE_X + c] - ring_x, lanes[at.PLACE_Y + c] - ring_y
    distance = math.sqrt(dx * dx + dy * dy)
    nx, ny = dx / distance, dy / distance
    lanes[contact + at.RADIAL_X + c], lanes[contact + at.RADIAL_Y + c] = nx, ny
    lanes[contact + at.NORMAL_X + c], lanes[contact + at.NORMAL_Y + c] = nx, ny
    lanes[contact + at.DISTANCE + c] = distance
    lanes[contact + at.PENETRATION + c] = side * (reach - distance)
    lanes[contact + at.SINK + c] = lanes[contact + at.SURFACE_N + c] = 0.0


@piece
def press(lanes: Floats, contact: int, c: int, scale: float, payload: Payload) -> None:
    """Write elastic force and stiffness by Johnson's law; zero where the contact is open."""
    contact, c = max(contact, 0), max(c, 0)
    depth = lanes[contact + at.PENETRATION + c]
    force, stiffness = johnson_force(max(depth, LEAST_PENETRATION), payload.contact_modulus, scale)
    lanes[contact + at.FORCE + c] = force if depth > 0.0 else 0.0
    lanes[contact + at.STIFFNESS + c] = stiffness if depth > 0.0 else 0.0


@piece
def press_by_power(lanes: Floats, contact: int, count: int, payload: Payload) -> None:
    """Write elastic forces and stiffnesses by the power law; zero where a contact is open."""
    for c in range(count):
        depth = lanes[contact + at.PENETRATION + c]
        if depth > 0.0:
            force, stiffness = power_force(depth, payload.power_coefficient, payload.power_exponent)
            lanes[contact + at.FORCE + c], lanes[contact + at.STIFFNESS + c] = force, stiffness
        else:
            lanes[contact + at.FORCE + c] = lanes[contact + at.STIFFNESS + c] = 0.0


@piece
def convect(
    lanes: Floats, contact: int, count: int, mean: tuple[float, float], ring_speed: float, width: float, raceway: float, payload: Payload
) -> None:
    """Write at what rate rolling carries bristles out of the contacts."""
    contact = max(contact, 0)
    for c in range(count):
        rx, ry = lanes[contact + at.RADIAL_X + c], lanes[contact + at.RADIAL_Y + c]
        along = (lanes[at.COMING_Y + c] - mean[1]) * rx - (lanes[at.COMING_X + c] - mean[0]) * ry
        rolling = (along / lanes[contact + at.DISTANCE + c] - ring_speed) * raceway
        force = max(lanes[contact + at.FORCE + c], 1e-9)
        lanes[contact + at.CONVECTION + c] = convection_rate(rolling, force, width, payload.convection)


@piece
def draw_line(
    lanes: Floats,
    contact: int,
    c: int,
    mean: tuple[float, float],
    old: tuple[float, float],
    surface: float,
    side: float,
    payload: Payload,
) -> None:
    """Write normal force and friction of a contact with a ring as lines over approach and slip.

    ``mean`` is the ring's predicted mean velocity, ``old`` that before the step, ``surface`` the speed of its surface [m/s]. The h^2 k/12
    of `DISPERSION` acts on the change of the approach. A contact never pulls: where it opens so fast that the loss would
    outweigh the force, the loss is cut.
    """
    contact, c = max(contact, 0), max(c, 0)
    nx, ny = lanes[contact + at.NORMAL_X + c], lanes[contact + at.NORMAL_Y + c]
    rx, ry = lanes[contact + at.RADIAL_X + c], lanes[contact + at.RADIAL_Y + c]
    vx, vy = lanes[at.COMING_X + c] - mean[0], lanes[at.COMING_Y + c] - mean[1]
    ux, uy = lanes[at.BEFORE_X + c] - old[0], lanes[at.BEFORE_Y + c] - old[1]
    surface_n, sink = lanes[contact + at.SURFACE_N + c], lanes[contact + at.SINK + c]
    closing, before = -side * (vx * nx + vy * ny - surface_n) - sink, -side * (ux * nx + uy * ny - surface_n)
    force, stiffness = lanes[contact + at.FORCE + c], lanes[contact + at.STIFFNESS + c]
    damping = loss_coefficient(force, stiffness * payload.loss_time + (payload.contact_damping if force > 0.0 else 0.0), closing)
    inertia = 2.0 * DISPERSION * payload.step * stiffness
    known = force + damping * closing
    lanes[contact + at.PUSH + c] = force - damping * sink - inertia * before
    lanes[contact + at.GIVE + c] = damping + inertia
    lanes[contact + at.DAMPING + c], lanes[contact + at.KNOWN + c] = damping, known
    slip = vy * rx - vx * ry - side * lanes[at.COMING_RIM + c] - surface
    constant, slope, rate, phi = friction_line(
        slip,
        lanes[contact + at.BRISTLE + c],
        payload.kinetic_coefficient,
        payload.static_coefficient,
        lanes[contact + at.CONVECTION + c],
        payload,
    )
    lanes[contact + at.CONSTANT + c], lanes[contact + at.SLOPE + c] = constant * known, slope * known
    lanes[contact + at.RATE + c], lanes[contact + at.PHI + c] = rate, phi


@piece
def sink_in(
    lanes: Floats,
    contact: int,
    count: int,
    order: Integers,
    notches: Notches,
    towards: Floats,
    state: State,
    mean: tuple[float, float],
    inner: bool,
    payload: Payload,
) -> None:
    """Take the depth of notches off the penetrations of closed contacts, and write how fast the floor falls away."""
    contact = max(contact, 0)
    raceway, ring_speed, side = payload.outer_raceway_radius, 0.0, 1.0
    if inner:
        raceway, ring_speed, side = payload.inner_raceway_radius, state.shaft[1], -1.0
    rollers, radius = payload.free.shape[1], payload.roller_radius
    for c in range(count):
        if lanes[contact + at.PENETRATION + c] <= 0.0:
            continue
        row, i = order[c] // rollers, order[c] % rollers
        nx, ny = lanes[contact + at.RADIAL_X + c], lanes[contact + at.RADIAL_Y + c]
        orbit = (lanes[at.COMING_Y + c] - mean[1]) * nx - (lanes[at.COMING_X + c] - mean[0]) * ny
        orbit /= lanes[contact + at.DISTANCE + c]
        k, offset = -1, 0.0
        if payload.notch_law == SINK and notches.row.size > 0:
            k, offset = notch_under(notches, towards, row, nx, ny)
        if k >= 0:
            edge = notches.half_angle[k] - abs(offset)
            if inner:
                depth, slope = inner_notch_depth(edge, notches.depth[k], raceway, radius)
            else:
                depth, slope = outer_notch_depth(edge, notches.depth[k], raceway, radius)
            lanes[contact + at.PENETRATION + c] -= depth
            lanes[contact + at.SINK + c] += (-slope if offset > 0.0 else slope) * (orbit - ring_speed)
        if payload.roller_notches.row.size > 0:
            depth, slope = roller_sink(
                payload.roller_notches, row, i, side * nx, side * ny, state.spin_angle[row, i], raceway, radius, inner
            )
            lanes[contact + at.PENETRATION + c] -= depth
            lanes[contact + at.SINK + c] += slope * (orbit - lanes[at.COMING_RIM + c] / radius)


@piece
def cut_edges(
    lanes: Floats,
    contact: int,
    count: int,
    order: Integers,
    notches: Notches,
    towards: Floats,
    surface: float,
    ring_x: float,
    ring_y: float,
    inner: bool,
    payload: Payload,
) -> None:
    """Put force, stiffness and normal of a notch with edges in the place of the smooth raceway's."""
    contact = max(contact, 0)
    for c in range(count):
        gap = -lanes[contact + at.PENETRATION + c]
        if gap >= 0.0:
            continue
        row = order[c] // payload.free.shape[1]
        rx, ry = lanes[contact + at.RADIAL_X + c], lanes[contact + at.RADIAL_Y + c]
        k, _ = notch_under(notches, towards, row, rx, ry)
        if k >= 0:
            dx, dy = lanes[at.PLACE_X + c] - ring_x, lanes[at.PLACE_Y + c] - ring_y
            force, stiffness, nx, ny = edge_contact(
                dx, dy, towards[k, 0], towards[k, 1], notches.half_angle[k], notches.depth[k], gap, inner, payload
            )
            lanes[contact + at.FORCE + c], lanes[contact + at.STIFFNESS + c] = force, stiffness
            lanes[contact + at.NORMAL_X + c], lanes[contact + at.NORMAL_Y + c] = nx, ny
            lanes[contact + at.SURFACE_N + c] = surface * (rx * ny - ry * nx)


@piece
def face_raceways(payload: Payload, state: State, lanes: Floats, used: int, count: int, inner_too: bool) -> None:
    """Write how ``used`` rollers in ``count`` lanes lie to the outer raceway, and to the inner one if asked."""
    radius = payload.roller_radius
    outer_reach, inner_reach = payload.outer_raceway_radius - radius, payload.inner_raceway_radius + radius
    outer_x, outer_y, inner_x, inner_y = state.outer_position[0], state.outer_position[1], state.inner_position[0], state.inner_position[1]
    for c in range(count):
        face(lanes, at.OUTER, c, outer_x, outer_y, outer_reach, -1.0)
        if inner_too:
            face(lanes, at.INNER, c, inner_x, inner_y, inner_reach, 1.0)
    for c in range(used, count):
        lanes[at.OUTER + at.PENETRATION + c] = lanes[at.INNER + at.PENETRATION + c] = -1.0


@piece
def press_raceways(
    payload: Payload, state: State, work: Workspace, lanes: Floats, order: Integers, used: int, count: int, inner_too: bool
) -> None:
    """Write elastic forces and stiffnesses of the raceway contacts, notches included."""
    if payload.any_notch:
        notch_raceways(payload, state, work, lanes, order, used, inner_too)
    if payload.contact_law == JOHNSON:
        for c in range(count):
            press(lanes, at.OUTER, c, payload.outer_scale, payload)
            if inner_too:
                press(lanes, at.INNER, c, payload.inner_scale, payload)
    else:
        press_by_power(lanes, at.OUTER, count, payload)
        if inner_too:
            press_by_power(lanes, at.INNER, count, payload)
    if payload.any_notch and payload.notch_law != SINK:
        cut_raceways(payload, state, work, lanes, order, used, inner_too)


@piece
def draw_raceways(payload: Payload, state: State, work: Workspace, lanes: Floats, count: int, inner_too: bool) -> None:
    """Write normal forces with their loss and friction of the raceway contacts as lines."""
    surface = state.shaft[1] * payload.inner_raceway_radius
    outer_mean, inner_mean = (work.mean[OUTER, 0], work.mean[OUTER, 1]), (work.mean[INNER, 0], work.mean[INNER, 1])
    outer_old, inner_old = (state.outer_velocity[0], state.outer_velocity[1]), (state.inner_velocity[0], state.inner_velocity[1])
    if payload.convection > 0.0:
        convect(lanes, at.OUTER, count, outer_mean, 0.0, payload.outer_width, payload.outer_raceway_radius, payload)
        if inner_too:
            convect(lanes, at.INNER, count, inner_mean, state.shaft[1], payload.inner_width, payload.inner_raceway_radius, payload)
    for c in range(count):
        draw_line(lanes, at.OUTER, c, outer_mean, outer_old, 0.0, -1.0, payload)
        if inner_too:
            draw_line(lanes, at.INNER, c, inner_mean, inner_old, surface, 1.0, payload)


@piece
def notch_raceways(payload: Payload, state: State, work: Workspace, lanes: Floats, order: Integers, used: int, inner_too: bool) -> None:
    """Take the depth of notches on raceways and rollers off the penetrations."""
    outer_mean, inner_mean = (work.mean[OUTER, 0], work.mean[OUTER, 1]), (work.mean[INNER, 0], work.mean[INNER, 1])
    sink_in(lanes, at.OUTER, used, order, payload.outer_notches, work.outer_towards, state, outer_mean, False, payload)
    if inner_too:
        sink_in(lanes, at.INNER, used, order, payload.inner_notches, work.inner_towards, state, inner_mean, True, payload)


@piece
def cut_raceways(payload: Payload, state: State, work: Workspace, lanes: Floats, order: Integers, used: int, inner_too: bool) -> None:
    """Put what notches with edges do in the place of smooth raceways."""
    outer_x, outer_y, inner_x, inner_y = state.outer_position[0], state.outer_position[1], state.inner_position[0], state.inner_position[1]
    cut_edges(lanes, at.OUTER, used, order, payload.outer_notches, work.outer_towards, 0.0, outer_x, outer_y, False, payload)
    if inner_too:
        surface = state.shaft[1] * payload.inner_raceway_radius
        cut_edges(lanes, at.INNER, used, order, payload.inner_notches, work.inner_towards, surface, inner_x, inner_y, True, payload)
