"""The contacts of bound rollers with the raceways: penetration, force and friction, each as a line over the mean velocities of the step."""

from __future__ import annotations

from dcrb_ros.core.contacts.films import raceway_site
from dcrb_ros.core.contacts.force_line import LARGEST_CLOSING, crosses, crossing_line, elastic, lasting_line, open_below
from dcrb_ros.core.contacts.lines import RingMotion, closing_speeds, linearize_friction, locate, replace_lines, write_force_line
from dcrb_ros.core.contacts.notch import edge_contact, notch_under, passed, roller_notch_under
from dcrb_ros.core.contacts.surface import add_bound_heights, add_parts
from dcrb_ros.core.jit import NO, YES, piece
from dcrb_ros.core.laws.calls import load_memory, normal_range
from dcrb_ros.core.layout.contacts import RacewayContact
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.layout.state import INNER, OUTER, SHAFT_SPEED, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import SINK, Notches, Payload


@piece
def notch_depth(
    payload: Payload, state: State, work: Workspace, row: int, i: int, nx: float, ny: float, orbit: float, spin: float, inner: bool
) -> tuple[float, float]:
    """Return the depth of notches under a contact, for the step [m], and how fast it grows [m/s].

    (nx, ny) points from the ring to the roller, ``orbit`` is the roller's angular speed about the ring's centre, ``spin`` its own [rad/s].
    """
    if inner:
        passing, side, raceway = orbit - state.shaft[SHAFT_SPEED], -1.0, payload.inner_raceway_radius
        depth, sink = raceway_notch_depth(payload, payload.inner_notches, work.inner_notch_direction, row, nx, ny, passing, YES)
    else:
        side, raceway = 1.0, payload.outer_raceway_radius
        depth, sink = raceway_notch_depth(payload, payload.outer_notches, work.outer_notch_direction, row, nx, ny, orbit, NO)
    if payload.roller_notches.row.size > 0:
        angle, way = state.rollers[0].angle[row * payload.free.shape[1] + i], payload.step * (orbit - spin)
        share, radius = payload.spin_share, payload.roller_radius
        roller_depth, change = roller_notch_under(
            payload.roller_notches, row, i, side * nx, side * ny, angle, share, way, raceway, radius, inner
        )
        depth, sink = depth + roller_depth, sink + change / payload.step
    return depth, sink


@piece
def raceway_notch_depth(
    payload: Payload, notches: Notches, direction: Floats, row: int, nx: float, ny: float, passing: float, inner: bool
) -> tuple[float, float]:
    """Return depth [m] and its growth [m/s] of a raceway's notch that a roller passes at an angular speed ``passing`` [rad/s]."""
    if payload.notch_law != SINK or notches.row.size == 0:
        return 0.0, 0.0
    k, offset = notch_under(notches, direction, row, nx, ny)
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
        NO,
    )
    return depth, change / payload.step


@piece
def apply_notches(payload: Payload, state: State, work: Workspace, contact: RacewayContact, ring: RingMotion) -> None:
    """Subtract the depth of notches from the penetrations of contacts that are closed or nearly so, and write how fast it grows."""
    bound, least = work.bound[0], open_below(payload, raceway_site(payload, state, ring.inner))
    for k in range(work.row_ends[work.row_ends.size - 1]):
        if contact.penetration[k] > least:
            row = bound.row[k]
            nx, ny = contact.radial_x[k], contact.radial_y[k]
            orbit = (bound.predicted_vy[k] - ring.mean[1]) * nx - (bound.predicted_vx[k] - ring.mean[0]) * ny
            orbit, spin = orbit / contact.distance[k], bound.predicted_rim[k] / payload.roller_radius
            i = bound.roller[k] - row * payload.free.shape[1]
            depth, sink = notch_depth(payload, state, work, row, i, nx, ny, orbit, spin, ring.inner)
            contact.penetration[k] -= depth
            contact.sink_speed[k] = sink


@piece
def linearize_edges(
    payload: Payload,
    state: State,
    work: Workspace,
    contact: RacewayContact,
    ring: RingMotion,
) -> None:
    """Replace force, normal and friction of the smooth raceway where a roller is over a notch with edges."""
    bound, site = work.bound[0], raceway_site(payload, state, ring.inner)
    body, notches, direction = OUTER, payload.outer_notches, work.outer_notch_direction
    if ring.inner:
        body, notches, direction = INNER, payload.inner_notches, work.inner_notch_direction
    for k in range(work.row_ends[work.row_ends.size - 1]):
        gap = -contact.penetration[k]
        if gap >= LARGEST_CLOSING * payload.step + normal_range(payload.normal_law):
            continue
        rx, ry = contact.radial_x[k], contact.radial_y[k]
        notch, _ = notch_under(notches, direction, bound.row[k], rx, ry)
        if notch >= 0:
            memory = load_memory(payload.normal_law, contact.normal, k)
            dx, dy = bound.x[k] - state.position[body, 0], bound.y[k] - state.position[body, 1]
            force, stiffness, nx, ny = edge_contact(
                dx,
                dy,
                direction[notch, 0],
                direction[notch, 1],
                notches.half_angle[notch],
                notches.depth[notch],
                gap,
                memory,
                ring.inner,
                payload,
            )
            contact.normal_x[k], contact.normal_y[k] = nx, ny
            contact.surface_speed_normal[k] = ring.surface * (rx * ny - ry * nx)
            replace_lines(payload, bound, contact, k, memory, site, -gap, force, stiffness, ring)


@piece
def locate_raceways(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write direction, distance and penetration of ``count`` bound rollers at both raceways."""
    bound, radius = work.bound[0], payload.roller_radius
    outer_reach, inner_reach = payload.outer_raceway_radius - radius, payload.inner_raceway_radius + radius
    outer_x, outer_y, inner_x, inner_y = (
        state.position[OUTER, 0],
        state.position[OUTER, 1],
        state.position[INNER, 0],
        state.position[INNER, 1],
    )
    for k in range(count):
        locate(bound, bound.outer, k, outer_x, outer_y, outer_reach, -1.0)
        locate(bound, bound.inner, k, inner_x, inner_y, inner_reach, 1.0)
    for k in range(work.row_ends[work.row_ends.size - 1], count):
        bound.outer.penetration[k] = bound.inner.penetration[k] = -1.0


@piece
def linearize_smooth(
    payload: Payload,
    state: State,
    work: Workspace,
    contact: RacewayContact,
    count: int,
    ring: RingMotion,
) -> None:
    """Write the contacts with a smooth raceway as lines, and which of them close or open within the step."""
    bound, site, law = work.bound[0], raceway_site(payload, state, ring.inner), payload.normal_law
    for k in range(count):
        closing, before, sink = closing_speeds(bound, contact, k, ring)
        penetration = contact.penetration[k]
        memory = load_memory(law, contact.normal, k)
        force, stiffness = elastic(law, memory, penetration, site)
        contact.crossing[k] = 1.0 if crosses(law, site, penetration, closing, before, payload.step) else 0.0
        write_force_line(contact, k, lasting_line(payload, memory, site, penetration, force, stiffness, closing, before, sink))
        linearize_friction(bound, contact, k, ring, site, payload)


@piece
def linearize_crossing(
    payload: Payload,
    state: State,
    work: Workspace,
    contact: RacewayContact,
    ring: RingMotion,
) -> None:
    """Write the lines of the contacts that close or open within the step."""
    bound, site, crossings = work.bound[0], raceway_site(payload, state, ring.inner), 0
    for k in range(work.row_ends[work.row_ends.size - 1]):
        if contact.crossing[k] > 0.0:
            bound.crossings[crossings] = k
            crossings += 1
    for n in range(crossings):
        k = bound.crossings[n]
        closing, before, sink = closing_speeds(bound, contact, k, ring)
        # A pinned roller moves with its whole cage: its force hardly changes the velocity.
        mobility = 0.5 * payload.step / payload.roller_mass * bound.free[k]
        penetration, last = contact.penetration[k], contact.last_force[k]
        memory = load_memory(payload.normal_law, contact.normal, k)
        write_force_line(contact, k, crossing_line(payload, memory, site, penetration, closing, before, sink, last, mobility))
        linearize_friction(bound, contact, k, ring, site, payload)


@piece
def linearize_raceway(
    payload: Payload,
    state: State,
    work: Workspace,
    count: int,
    contact: RacewayContact,
    ring: RingMotion,
) -> None:
    """Write the contacts of bound rollers with a raceway as lines over the mean velocities of the step, notches included."""
    add_bound_heights(payload.surfaces, payload, state, work, contact, ring)
    if payload.any_defect:
        apply_notches(payload, state, work, contact, ring)
    linearize_smooth(payload, state, work, contact, count, ring)
    linearize_crossing(payload, state, work, contact, ring)
    if payload.any_defect and payload.notch_law != SINK:
        linearize_edges(payload, state, work, contact, ring)
    add_parts(payload.surfaces, payload, state, work, contact, ring)


@piece
def linearize_raceways(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write the contacts of ``count`` bound rollers with both raceways as lines over the mean velocities of the step."""
    mean, before, speed = work.mean_velocity, state.velocity, state.shaft[SHAFT_SPEED]
    outer_mean, inner_mean = (mean[OUTER, 0], mean[OUTER, 1]), (mean[INNER, 0], mean[INNER, 1])
    outer_before, inner_before = (before[OUTER, 0], before[OUTER, 1]), (before[INNER, 0], before[INNER, 1])
    outer = RingMotion(outer_mean, outer_before, 0.0, 0.0, False)
    inner = RingMotion(inner_mean, inner_before, speed, speed * payload.inner_raceway_radius, True)
    linearize_raceway(payload, state, work, count, work.bound[0].outer, outer)
    linearize_raceway(payload, state, work, count, work.bound[0].inner, inner)
