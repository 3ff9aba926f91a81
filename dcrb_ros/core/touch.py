"""The contacts of bound rollers with the raceways: how deep, how hard, and each as a line over the mean velocities of the step."""

from __future__ import annotations

import math

from dcrb_ros.core import lanes as at
from dcrb_ros.core.friction import convection_rate, friction_line
from dcrb_ros.core.jit import piece
from dcrb_ros.core.normal import crosses, crossing_line, elastic, lasting_line
from dcrb_ros.core.payload import JOHNSON, SINK, Floats, Notches, Payload
from dcrb_ros.core.raceway import edge_contact, notch_under, passed, roller_sink
from dcrb_ros.core.state import INNER, OUTER, State
from dcrb_ros.core.work import Workspace

NEARING = 1.0
"""A contact may close within a step when its gap is less than this speed covers [m/s]; idle rollers are slower."""
LEAST_FORCE = 1e-9
"""What stands for the force of an open contact where it divides [N]."""


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
    """Return by how much notches lie deeper under a contact over the step [m], and how fast that grows [m/s].

    (nx, ny) points from the ring to the roller, ``orbit`` is the roller's angular speed about the ring's centre, ``spin`` its own [rad/s].
    """
    if inner:
        passing, side, raceway = orbit - state.shaft[1], -1.0, payload.inner_raceway_radius
        depth, sink = raceway_notch(payload, payload.inner_notches, work.inner_towards, row, nx, ny, passing, True)
    else:
        side, raceway = 1.0, payload.outer_raceway_radius
        depth, sink = raceway_notch(payload, payload.outer_notches, work.outer_towards, row, nx, ny, orbit, False)
    if payload.roller_notches.row.size > 0:
        angle, way = state.lanes[at.ANGLE + row * payload.free.shape[1] + i], payload.step * (orbit - spin)
        own, change = roller_sink(payload.roller_notches, row, i, side * nx, side * ny, angle, way, raceway, payload.roller_radius, inner)
        depth, sink = depth + own, sink + change / payload.step
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
    raceway = payload.inner_raceway_radius if inner else payload.outer_raceway_radius
    depth, change = passed(
        offset,
        passing * payload.step,
        notches.half_angle[k],
        notches.bottom[k],
        notches.kink[k],
        notches.depth[k],
        raceway,
        payload.roller_radius,
        inner,
        False,
    )
    return depth, change / payload.step


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
def approach(
    lanes: Floats, contact: int, c: int, mean: tuple[float, float], old: tuple[float, float], side: float
) -> tuple[float, float, float]:
    """Return the speeds of penetration expected and before the step, and that at which a notch's floor falls away [m/s].

    ``mean`` is the ring's predicted mean velocity, ``old`` that before the step.
    """
    contact, c = max(contact, 0), max(c, 0)
    nx, ny = lanes[contact + at.NORMAL_X + c], lanes[contact + at.NORMAL_Y + c]
    vx, vy = lanes[at.COMING_X + c] - mean[0], lanes[at.COMING_Y + c] - mean[1]
    ux, uy = lanes[at.BEFORE_X + c] - old[0], lanes[at.BEFORE_Y + c] - old[1]
    surface_n, sink = lanes[contact + at.SURFACE_N + c], lanes[contact + at.SINK + c]
    return -side * (vx * nx + vy * ny - surface_n) - sink, -side * (ux * nx + uy * ny - surface_n) - sink, sink


@piece
def write_line(lanes: Floats, contact: int, c: int, line: tuple[float, float, float, float, float]) -> None:
    """Write a normal force as a line over the approach, itself as expected, its damping and the speed expected."""
    contact, c = max(contact, 0), max(c, 0)
    lanes[contact + at.PUSH + c], lanes[contact + at.GIVE + c], lanes[contact + at.KNOWN + c] = line[0], line[1], line[2]
    lanes[contact + at.DAMPING + c], lanes[contact + at.EXPECTED + c] = line[3], line[4]


@piece
def draw_friction(
    lanes: Floats, contact: int, c: int, mean: tuple[float, float], ring_speed: float, surface: float, inner: bool, payload: Payload
) -> None:
    """Write the friction of a contact with a ring as a line over the slip.

    ``mean`` is the ring's predicted mean velocity, ``surface`` the speed of its surface [m/s].
    """
    contact, c, side = max(contact, 0), max(c, 0), 1.0 if inner else -1.0
    rx, ry = lanes[contact + at.RADIAL_X + c], lanes[contact + at.RADIAL_Y + c]
    along = (lanes[at.COMING_Y + c] - mean[1]) * rx - (lanes[at.COMING_X + c] - mean[0]) * ry
    slip, known = along - side * lanes[at.COMING_RIM + c] - surface, lanes[contact + at.KNOWN + c]
    bristle, distance = lanes[contact + at.BRISTLE + c], lanes[contact + at.DISTANCE + c]
    constant, slope, rate, phi = raceway_friction(slip, bristle, along, distance, ring_speed, known, inner, payload)
    lanes[contact + at.CONSTANT + c], lanes[contact + at.SLOPE + c] = constant * known, slope * known
    lanes[contact + at.RATE + c], lanes[contact + at.PHI + c] = rate, phi


@piece
def sink_in(payload: Payload, state: State, work: Workspace, contact: int, mean: tuple[float, float], inner: bool) -> None:
    """Take the depth of notches off the penetrations of contacts that are closed or near it, and write how fast the floor falls away."""
    contact, lanes = max(contact, 0), work.bound
    for k in range(work.ends[work.ends.size - 1]):
        if lanes[contact + at.PENETRATION + k] > -NEARING * payload.step:
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
    state: State,
    work: Workspace,
    contact: int,
    mean: tuple[float, float],
    old: tuple[float, float],
    ring_speed: float,
    inner: bool,
) -> None:
    """Put force, normal and friction of a notch with edges in the place of the smooth raceway's."""
    contact, lanes, side = max(contact, 0), work.bound, 1.0 if inner else -1.0
    surface = ring_speed * payload.inner_raceway_radius
    ring, notches, towards = OUTER, payload.outer_notches, work.outer_towards
    if inner:
        ring, notches, towards = INNER, payload.inner_notches, work.inner_towards
    for c in range(work.ends[work.ends.size - 1]):
        gap = -lanes[contact + at.PENETRATION + c]
        if gap >= NEARING * payload.step:
            continue
        rx, ry = lanes[contact + at.RADIAL_X + c], lanes[contact + at.RADIAL_Y + c]
        k, _ = notch_under(notches, towards, work.rows[c], rx, ry)
        if k >= 0:
            dx, dy = lanes[at.PLACE_X + c] - state.position[ring, 0], lanes[at.PLACE_Y + c] - state.position[ring, 1]
            force, stiffness, nx, ny = edge_contact(
                dx, dy, towards[k, 0], towards[k, 1], notches.half_angle[k], notches.depth[k], gap, inner, payload
            )
            lanes[contact + at.NORMAL_X + c], lanes[contact + at.NORMAL_Y + c] = nx, ny
            lanes[contact + at.SURFACE_N + c] = surface * (rx * ny - ry * nx)
            closing, before, sink = approach(lanes, contact, c, mean, old, side)
            write_line(lanes, contact, c, lasting_line(force, stiffness, closing, before, sink, payload))
            draw_friction(lanes, contact, c, mean, ring_speed, surface, inner, payload)


@piece
def face_raceways(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write how bound rollers, in ``count`` lanes, lie to the raceways."""
    lanes, radius = work.bound, payload.roller_radius
    outer_reach, inner_reach = payload.outer_raceway_radius - radius, payload.inner_raceway_radius + radius
    outer_x, outer_y, inner_x, inner_y = (
        state.position[OUTER, 0],
        state.position[OUTER, 1],
        state.position[INNER, 0],
        state.position[INNER, 1],
    )
    for c in range(count):
        face(lanes, at.OUTER, c, outer_x, outer_y, outer_reach, -1.0)
        face(lanes, at.INNER, c, inner_x, inner_y, inner_reach, 1.0)
    for c in range(work.ends[work.ends.size - 1], count):
        lanes[at.OUTER + at.PENETRATION + c] = lanes[at.INNER + at.PENETRATION + c] = -1.0


@piece
def draw_smooth(
    payload: Payload,
    work: Workspace,
    count: int,
    contact: int,
    mean: tuple[float, float],
    old: tuple[float, float],
    ring_speed: float,
    inner: bool,
    johnson: bool,
) -> None:
    """Write the contacts with a smooth raceway as lines, and which of them close or open within the step."""
    contact, lanes, side = max(contact, 0), work.bound, 1.0 if inner else -1.0
    scale, surface = payload.inner_scale if inner else payload.outer_scale, ring_speed * payload.inner_raceway_radius
    for c in range(count):
        closing, before, sink = approach(lanes, contact, c, mean, old, side)
        depth = lanes[contact + at.PENETRATION + c]
        force, stiffness = elastic(depth, scale, johnson, payload)
        lanes[at.CROSSES + c] = 1.0 if crosses(depth, closing, before, payload.step) else 0.0
        lanes[at.LAST_FORCE + c] = lanes[contact + at.KNOWN + c]
        write_line(lanes, contact, c, lasting_line(force, stiffness, closing, before, sink, payload))
        draw_friction(lanes, contact, c, mean, ring_speed, surface, inner, payload)


@piece
def draw_crossing(
    payload: Payload, work: Workspace, contact: int, mean: tuple[float, float], old: tuple[float, float], ring_speed: float, inner: bool
) -> None:
    """Write the lines of the contacts that close or open within the step."""
    contact, lanes, side = max(contact, 0), work.bound, 1.0 if inner else -1.0
    scale, surface, found = payload.inner_scale if inner else payload.outer_scale, ring_speed * payload.inner_raceway_radius, 0
    for c in range(work.ends[work.ends.size - 1]):
        if lanes[at.CROSSES + c] > 0.0:
            work.touched[found] = c
            found += 1
    for k in range(found):
        c = work.touched[k]
        closing, before, sink = approach(lanes, contact, c, mean, old, side)
        # A pinned roller yields with its whole cage, next to nothing.
        yielding = 0.5 * payload.step / payload.roller_mass * lanes[at.MOVING + c]
        depth, last = lanes[contact + at.PENETRATION + c], lanes[at.LAST_FORCE + c]
        write_line(lanes, contact, c, crossing_line(depth, closing, before, sink, last, yielding, scale, payload))
        draw_friction(lanes, contact, c, mean, ring_speed, surface, inner, payload)


@piece
def draw_raceway(
    payload: Payload,
    state: State,
    work: Workspace,
    count: int,
    contact: int,
    mean: tuple[float, float],
    old: tuple[float, float],
    ring_speed: float,
    inner: bool,
) -> None:
    """Write the contacts of bound rollers with a raceway as lines over the mean velocities of the step, notches included."""
    if payload.any_notch:
        sink_in(payload, state, work, contact, mean, inner)
    if payload.contact_law == JOHNSON:
        draw_smooth(payload, work, count, contact, mean, old, ring_speed, inner, True)
    else:
        draw_smooth(payload, work, count, contact, mean, old, ring_speed, inner, False)
    draw_crossing(payload, work, contact, mean, old, ring_speed, inner)
    if payload.any_notch and payload.notch_law != SINK:
        cut_edges(payload, state, work, contact, mean, old, ring_speed, inner)


@piece
def draw_raceways(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write the contacts of bound rollers with both raceways as lines over the mean velocities of the step."""
    outer_mean, inner_mean = (work.mean[OUTER, 0], work.mean[OUTER, 1]), (work.mean[INNER, 0], work.mean[INNER, 1])
    outer_old, inner_old = (state.velocity[OUTER, 0], state.velocity[OUTER, 1]), (state.velocity[INNER, 0], state.velocity[INNER, 1])
    draw_raceway(payload, state, work, count, at.OUTER, outer_mean, outer_old, 0.0, False)
    draw_raceway(payload, state, work, count, at.INNER, inner_mean, inner_old, state.shaft[1], True)
