"""The contacts of bound rollers: how deep, how hard, and each as a straight line over the mean velocities of the step."""

from __future__ import annotations

import math

from dcrb_ros.core import lanes as at
from dcrb_ros.core.bars import touch_cages
from dcrb_ros.core.contact import LEAST_PENETRATION, johnson_force, loss_coefficient, power_force
from dcrb_ros.core.friction import convection_rate, friction_line
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import JOHNSON, SINK, Floats, Notches, Payload
from dcrb_ros.core.raceway import edge_contact, inner_notch_depth, notch_under, outer_notch_depth, roller_sink
from dcrb_ros.core.state import State
from dcrb_ros.core.work import INNER, OUTER, Workspace

DISPERSION = 1.0 / 12.0
"""Share h^2 k/12 of a stiffness k that is added to the mass: leapfrog then has the right frequency to fourth order."""
LEAST_FORCE = 1e-9
"""What stands for the force of an open contact where it divides [N]."""


@piece
def elastic(depth: float, scale: float, johnson: bool, payload: Payload) -> tuple[float, float]:
    """Return elastic force [N] and stiffness [N/m] at a penetration [m]; zero where the contact is open.

    ``johnson`` chooses the law once for a whole loop.
    """
    closed = max(depth, LEAST_PENETRATION)
    if johnson:
        force, stiffness = johnson_force(closed, payload.contact_modulus, scale)
    else:
        force, stiffness = power_force(closed, payload.power_coefficient, payload.power_exponent)
    return force if depth > 0.0 else 0.0, stiffness if depth > 0.0 else 0.0


@piece
def normal_line(
    force: float, stiffness: float, closing: float, before: float, sink: float, payload: Payload
) -> tuple[float, float, float, float]:
    """Return a normal force as the line push + give * approach [N, N s/m], itself at the speed expected [N] and its damping [N s/m].

    ``closing`` is the speed of penetration expected, ``before`` that of the approach before the step, ``sink`` that at which a
    notch's floor falls away [m/s]. The h^2 k/12 of `DISPERSION` acts on the change of the approach. A contact never pulls: where
    it opens so fast that the loss would outweigh the force, the loss is cut.
    """
    damping = loss_coefficient(force, stiffness * payload.loss_time + (payload.contact_damping if force > 0.0 else 0.0), closing)
    inertia = 2.0 * DISPERSION * payload.step * stiffness
    return force - damping * sink - inertia * before, damping + inertia, force + damping * closing, damping


@piece
def raceway_friction(
    slip: float, bristle: float, along: float, distance: float, ring_speed: float, force: float, inner: bool, payload: Payload
) -> tuple[float, float, float, float]:
    """Return the `friction_line` of a raceway contact; rolling ``along`` the raceway [m/s] carries bristles out of it."""
    raceway, width = payload.outer_raceway_radius, payload.outer_width
    if inner:
        raceway, width = payload.inner_raceway_radius, payload.inner_width
    rolling = (along / distance - ring_speed) * raceway
    convection = convection_rate(rolling, max(force, LEAST_FORCE), width, payload.convection)
    return friction_line(slip, bristle, payload.kinetic_coefficient, payload.static_coefficient, convection, payload)


@piece
def notch_depth(
    payload: Payload, state: State, work: Workspace, row: int, i: int, nx: float, ny: float, orbit: float, spin: float, inner: bool
) -> tuple[float, float]:
    """Return by how much notches lie deeper under a closed contact [m], and how fast that grows [m/s].

    (nx, ny) points from the ring to the roller, ``orbit`` is the roller's angular speed about the ring's centre, ``spin`` its own [rad/s].
    """
    if inner:
        depth, sink = raceway_notch(payload, payload.inner_notches, work.inner_towards, row, nx, ny, orbit - state.shaft[1], True)
        side, raceway = -1.0, payload.inner_raceway_radius
    else:
        depth, sink = raceway_notch(payload, payload.outer_notches, work.outer_towards, row, nx, ny, orbit, False)
        side, raceway = 1.0, payload.outer_raceway_radius
    if payload.roller_notches.row.size > 0:
        angle = state.lanes[at.ANGLE + row * payload.free.shape[1] + i]
        own, slope = roller_sink(payload.roller_notches, row, i, side * nx, side * ny, angle, raceway, payload.roller_radius, inner)
        depth, sink = depth + own, sink + slope * (orbit - spin)
    return depth, sink


@piece
def raceway_notch(
    payload: Payload, notches: Notches, towards: Floats, row: int, nx: float, ny: float, passing: float, inner: bool
) -> tuple[float, float]:
    """Return depth [m] and how fast it grows [m/s] of a raceway's notch that a roller passes at an angular speed ``passing`` [rad/s]."""
    if payload.notch_law != SINK or notches.row.size == 0:
        return 0.0, 0.0
    k, offset = notch_under(notches, towards, row, nx, ny)
    if k < 0:
        return 0.0, 0.0
    edge = notches.half_angle[k] - abs(offset)
    if inner:
        depth, slope = inner_notch_depth(edge, notches.depth[k], payload.inner_raceway_radius, payload.roller_radius)
    else:
        depth, slope = outer_notch_depth(edge, notches.depth[k], payload.outer_raceway_radius, payload.roller_radius)
    return depth, (-slope if offset > 0.0 else slope) * passing


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
def draw_line(
    lanes: Floats,
    contact: int,
    c: int,
    mean: tuple[float, float],
    old: tuple[float, float],
    ring_speed: float,
    surface: float,
    inner: bool,
    payload: Payload,
) -> None:
    """Write normal force and friction of a contact with a ring as lines over approach and slip.

    ``mean`` is the ring's predicted mean velocity, ``old`` that before the step, ``surface`` the speed of its surface [m/s].
    """
    contact, c, side = max(contact, 0), max(c, 0), 1.0 if inner else -1.0
    nx, ny = lanes[contact + at.NORMAL_X + c], lanes[contact + at.NORMAL_Y + c]
    rx, ry = lanes[contact + at.RADIAL_X + c], lanes[contact + at.RADIAL_Y + c]
    vx, vy = lanes[at.COMING_X + c] - mean[0], lanes[at.COMING_Y + c] - mean[1]
    ux, uy = lanes[at.BEFORE_X + c] - old[0], lanes[at.BEFORE_Y + c] - old[1]
    surface_n, sink = lanes[contact + at.SURFACE_N + c], lanes[contact + at.SINK + c]
    closing, before = -side * (vx * nx + vy * ny - surface_n) - sink, -side * (ux * nx + uy * ny - surface_n)
    force, stiffness = lanes[contact + at.FORCE + c], lanes[contact + at.STIFFNESS + c]
    push, give, known, damping = normal_line(force, stiffness, closing, before, sink, payload)
    along = vy * rx - vx * ry
    slip = along - side * lanes[at.COMING_RIM + c] - surface
    bristle, distance = lanes[contact + at.BRISTLE + c], lanes[contact + at.DISTANCE + c]
    constant, slope, rate, phi = raceway_friction(slip, bristle, along, distance, ring_speed, force, inner, payload)
    lanes[contact + at.PUSH + c], lanes[contact + at.GIVE + c] = push, give
    lanes[contact + at.DAMPING + c], lanes[contact + at.KNOWN + c] = damping, known
    lanes[contact + at.CONSTANT + c], lanes[contact + at.SLOPE + c] = constant * known, slope * known
    lanes[contact + at.RATE + c], lanes[contact + at.PHI + c] = rate, phi


@piece
def sink_in(payload: Payload, state: State, work: Workspace, contact: int, mean: tuple[float, float], inner: bool) -> None:
    """Take the depth of notches off the penetrations of closed contacts, and write how fast the floor falls away."""
    contact, lanes = max(contact, 0), work.bound
    for k in range(work.ends[work.ends.size - 1]):
        if lanes[contact + at.PENETRATION + k] > 0.0:
            row = work.rows[k]
            nx, ny = lanes[contact + at.RADIAL_X + k], lanes[contact + at.RADIAL_Y + k]
            orbit = (lanes[at.COMING_Y + k] - mean[1]) * nx - (lanes[at.COMING_X + k] - mean[0]) * ny
            orbit, spin = orbit / lanes[contact + at.DISTANCE + k], lanes[at.COMING_RIM + k] / payload.roller_radius
            i = work.order[k] - row * payload.free.shape[1]
            depth, sink = notch_depth(payload, state, work, row, i, nx, ny, orbit, spin, inner)
            lanes[contact + at.PENETRATION + k] -= depth
            lanes[contact + at.SINK + k] = sink


@piece
def cut_edges(
    payload: Payload,
    work: Workspace,
    contact: int,
    ring_x: float,
    ring_y: float,
    surface: float,
    notches: Notches,
    towards: Floats,
    inner: bool,
) -> None:
    """Put force, stiffness and normal of a notch with edges in the place of the smooth raceway's."""
    contact, lanes = max(contact, 0), work.bound
    for c in range(work.ends[work.ends.size - 1]):
        gap = -lanes[contact + at.PENETRATION + c]
        if gap >= 0.0:
            continue
        rx, ry = lanes[contact + at.RADIAL_X + c], lanes[contact + at.RADIAL_Y + c]
        k, _ = notch_under(notches, towards, work.rows[c], rx, ry)
        if k >= 0:
            dx, dy = lanes[at.PLACE_X + c] - ring_x, lanes[at.PLACE_Y + c] - ring_y
            force, stiffness, nx, ny = edge_contact(
                dx, dy, towards[k, 0], towards[k, 1], notches.half_angle[k], notches.depth[k], gap, inner, payload
            )
            lanes[contact + at.FORCE + c], lanes[contact + at.STIFFNESS + c] = force, stiffness
            lanes[contact + at.NORMAL_X + c], lanes[contact + at.NORMAL_Y + c] = nx, ny
            lanes[contact + at.SURFACE_N + c] = surface * (rx * ny - ry * nx)


@piece
def face_raceways(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write how bound rollers, in ``count`` lanes, lie to the raceways."""
    lanes, radius = work.bound, payload.roller_radius
    outer_reach, inner_reach = payload.outer_raceway_radius - radius, payload.inner_raceway_radius + radius
    outer_x, outer_y, inner_x, inner_y = state.outer_position[0], state.outer_position[1], state.inner_position[0], state.inner_position[1]
    for c in range(count):
        face(lanes, at.OUTER, c, outer_x, outer_y, outer_reach, -1.0)
        face(lanes, at.INNER, c, inner_x, inner_y, inner_reach, 1.0)
    for c in range(work.ends[work.ends.size - 1], count):
        lanes[at.OUTER + at.PENETRATION + c] = lanes[at.INNER + at.PENETRATION + c] = -1.0


@piece
def press(payload: Payload, lanes: Floats, count: int, johnson: bool) -> None:
    """Write elastic forces and stiffnesses of both raceways."""
    for c in range(count):
        force, stiffness = elastic(lanes[at.OUTER + at.PENETRATION + c], payload.outer_scale, johnson, payload)
        lanes[at.OUTER + at.FORCE + c], lanes[at.OUTER + at.STIFFNESS + c] = force, stiffness
        force, stiffness = elastic(lanes[at.INNER + at.PENETRATION + c], payload.inner_scale, johnson, payload)
        lanes[at.INNER + at.FORCE + c], lanes[at.INNER + at.STIFFNESS + c] = force, stiffness


@piece
def press_raceways(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write the elastic forces of bound rollers, notches included."""
    if payload.any_notch:
        sink_in(payload, state, work, at.OUTER, (work.mean[OUTER, 0], work.mean[OUTER, 1]), False)
        sink_in(payload, state, work, at.INNER, (work.mean[INNER, 0], work.mean[INNER, 1]), True)
    if payload.contact_law == JOHNSON:
        press(payload, work.bound, count, True)
    else:
        press(payload, work.bound, count, False)
    if payload.any_notch and payload.notch_law != SINK:
        outer, inner, surface = state.outer_position, state.inner_position, state.shaft[1] * payload.inner_raceway_radius
        cut_edges(payload, work, at.OUTER, outer[0], outer[1], 0.0, payload.outer_notches, work.outer_towards, False)
        cut_edges(payload, work, at.INNER, inner[0], inner[1], surface, payload.inner_notches, work.inner_towards, True)


@piece
def draw_contacts(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write all contacts of bound rollers as lines over the mean velocities of the step."""
    speed, surface = state.shaft[1], state.shaft[1] * payload.inner_raceway_radius
    outer_mean, inner_mean = (work.mean[OUTER, 0], work.mean[OUTER, 1]), (work.mean[INNER, 0], work.mean[INNER, 1])
    outer_old, inner_old = (state.outer_velocity[0], state.outer_velocity[1]), (state.inner_velocity[0], state.inner_velocity[1])
    for c in range(count):
        draw_line(work.bound, at.OUTER, c, outer_mean, outer_old, 0.0, 0.0, False, payload)
        draw_line(work.bound, at.INNER, c, inner_mean, inner_old, speed, surface, True, payload)
    touch_cages(payload, state, work, count)
