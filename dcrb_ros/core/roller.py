"""One roller over one step: which contacts are closed, how it moves between the bodies it touches, what it remembers."""

from __future__ import annotations

import math

from dcrb_ros.core.cage import conformal_contact
from dcrb_ros.core.contact import loss_coefficient
from dcrb_ros.core.friction import bristle_after, convection_rate, friction_line
from dcrb_ros.core.jit import kernel
from dcrb_ros.core.payload import Floats, Payload
from dcrb_ros.core.raceway import raceway_contact
from dcrb_ros.core.state import DRIVE, FRICTION, LOSS, NOTCH, State
from dcrb_ros.core.work import (
    BODY,
    CAGE,
    CONSTANT,
    COUNT,
    DAMPING,
    FIELDS,
    FORCE,
    GIVE,
    HEAD,
    INNER,
    LEVER_X,
    LEVER_Y,
    LONE,
    MEAN_RIM,
    MEAN_X,
    MEAN_Y,
    NORMAL_X,
    NORMAL_Y,
    OUTER,
    PHI,
    PUSH,
    RATE,
    ROLLER,
    SIDE,
    SINK,
    SLOPE,
    SURFACE_N,
    SURFACE_T,
    TANGENT_X,
    TANGENT_Y,
    TAU_X,
    TAU_Y,
    TIGHT,
    TURN,
    Workspace,
)

DISPERSION = 1.0 / 12.0
"""Share h^2 k/12 of a stiffness k that is added to the mass: leapfrog then has the right frequency to fourth order."""


@kernel
def write_normal(
    records: Floats,
    k: int,
    at: int,
    payload: Payload,
    force: float,
    stiffness: float,
    damping: float,
    sink: float,
    before: float,
    coming: float,
) -> float:
    """Write a contact's normal force as a line over the approach; return the force known beforehand [N].

    ``before`` is the approach at the step's start and ``coming`` the predicted mean [m/s], ``sink`` the speed at which a
    notch's floor falls away. The h^2 k/12 of `DISPERSION` acts on the change of the approach.
    """
    inertia = 2.0 * DISPERSION * payload.step * stiffness
    records[k, at + PUSH] = force - damping * sink - inertia * before
    records[k, at + GIVE] = damping + inertia
    records[k, at + DAMPING], records[k, at + SINK] = damping, sink
    known = force + damping * (coming - sink)
    records[k, at + FORCE] = known
    return known


@kernel
def write_friction(records: Floats, k: int, at: int, force: float, line: tuple[float, float, float, float]) -> None:
    """Write a contact's friction as a line over the slip."""
    constant, slope, rate, phi = line
    records[k, at + CONSTANT], records[k, at + SLOPE] = constant * force, slope * force
    records[k, at + RATE], records[k, at + PHI] = rate, phi


@kernel
def write_frame(
    records: Floats, k: int, at: int, body: int, side: float, normal: tuple[float, float], tangent: tuple[float, float], turn: float
) -> None:
    """Write which body a contact touches, and its directions."""
    records[k, at + BODY], records[k, at + SIDE], records[k, at + TURN] = body, side, turn
    records[k, at + NORMAL_X], records[k, at + NORMAL_Y] = normal
    records[k, at + TANGENT_X], records[k, at + TANGENT_Y] = tangent
    records[k, at + LEVER_X] = records[k, at + LEVER_Y] = records[k, at + SURFACE_N] = records[k, at + SURFACE_T] = 0.0


@kernel
def touch_raceway(
    payload: Payload,
    state: State,
    work: Workspace,
    records: Floats,
    k: int,
    at: int,
    row: int,
    i: int,
    inner: bool,
    dx: float,
    dy: float,
    before: tuple[float, float],
    coming: tuple[float, float, float],
) -> bool:
    """Write the contact of a roller with a raceway; return whether it is closed.

    (dx, dy) is the roller's centre from the ring's, ``before`` its velocity at the step's start, ``coming`` its predicted
    mean velocity and surface speed.
    """
    distance = math.sqrt(dx * dx + dy * dy)
    radial_x, radial_y = dx / distance, dy / distance
    tx, ty = -radial_y, radial_x
    body, side, turn, ring_speed, raceway = OUTER, -1.0, 1.0, 0.0, payload.outer_raceway_radius
    old_x, old_y = before[0] - state.outer_velocity[0], before[1] - state.outer_velocity[1]
    towards, bristle, width = work.outer_towards, state.outer_bristle[row, i], payload.outer_width
    if inner:
        body, side, turn, ring_speed, raceway = INNER, 1.0, -1.0, state.shaft[1], payload.inner_raceway_radius
        old_x, old_y = before[0] - state.inner_velocity[0], before[1] - state.inner_velocity[1]
        towards, bristle, width = work.inner_towards, state.inner_bristle[row, i], payload.inner_width
    vx, vy = coming[0] - work.mean[body, 0], coming[1] - work.mean[body, 1]
    along = vx * tx + vy * ty
    orbit = along / distance
    force, stiffness, nx, ny, sink = raceway_contact(
        dx,
        dy,
        distance,
        inner,
        row,
        i,
        towards,
        state.spin_angle[row, i],
        orbit - ring_speed,
        orbit - coming[2] / payload.roller_radius,
        payload,
    )
    if force == 0.0:
        return False
    surface = ring_speed * raceway if inner else 0.0
    write_frame(records, k, at, body, side, (nx, ny), (tx, ty), turn)
    records[k, at + SURFACE_N], records[k, at + SURFACE_T] = surface * (tx * nx + ty * ny), surface
    rate_before = -side * (old_x * nx + old_y * ny - records[k, at + SURFACE_N])
    rate = -side * (vx * nx + vy * ny - records[k, at + SURFACE_N])
    damping = loss_coefficient(force, stiffness * payload.loss_time + payload.contact_damping, rate - sink)
    normal = write_normal(records, k, at, payload, force, stiffness, damping, sink, rate_before, rate)
    convection = 0.0
    if payload.convection > 0.0:
        convection = convection_rate((orbit - ring_speed) * raceway, force, width, payload.convection)
    slip = along + turn * coming[2] - surface
    write_friction(
        records, k, at, normal, friction_line(slip, bristle, payload.kinetic_coefficient, payload.static_coefficient, convection, payload)
    )
    return True


@kernel
def touch_bar(
    payload: Payload,
    state: State,
    work: Workspace,
    records: Floats,
    k: int,
    at: int,
    row: int,
    i: int,
    tau: tuple[float, float],
    before: tuple[float, float],
    coming: tuple[float, float, float],
) -> bool:
    """Write the contact of a free roller with the bar ahead or behind; return whether it is closed.

    The normal is the pocket's tangent ``tau``, friction is radial (the direction-based reading of Eqs. 18 to 21).
    """
    radial_x, radial_y = tau[1], -tau[0]
    ax, ay = state.roller_position[row, i, 0] - state.cage_position[row, 0], state.roller_position[row, i, 1] - state.cage_position[row, 1]
    offset = (ax - payload.pitch_radius * radial_x) * tau[0] + (ay - payload.pitch_radius * radial_y) * tau[1]
    ahead = offset > 0.0
    side = 1.0 if ahead else -1.0
    penetration = side * offset - payload.pocket_clearance
    bar = i if ahead else (i - 1) % payload.broken.shape[1]
    if penetration <= 0.0 or payload.broken[row, bar]:
        state.bar_impact[row, i] = state.bar_bristle[row, i] = state.bar_force[row, i] = 0.0
        return False
    rx, ry = ax + side * payload.roller_radius * tau[0], ay + side * payload.roller_radius * tau[1]
    body = CAGE + row
    old_x = before[0] - state.cage_velocity[row, 0] + state.cage_velocity[row, 2] * ry
    old_y = before[1] - state.cage_velocity[row, 1] - state.cage_velocity[row, 2] * rx
    vx, vy = coming[0] - work.mean[body, 0] + work.mean[body, 2] * ry, coming[1] - work.mean[body, 1] - work.mean[body, 2] * rx
    rate_before, rate = side * (old_x * tau[0] + old_y * tau[1]), side * (vx * tau[0] + vy * tau[1])
    write_frame(records, k, at, body, -side, tau, (radial_x, radial_y), -side)
    records[k, at + LEVER_X], records[k, at + LEVER_Y] = rx, ry
    force, stiffness, damping, impact = conformal_contact(
        penetration, rate, state.bar_impact[row, i], payload.bar_coefficient, payload.bar_exponent, payload.impact_loss
    )
    state.bar_impact[row, i] = impact
    normal = write_normal(records, k, at, payload, force, stiffness, damping, 0.0, rate_before, rate)
    slip = vx * radial_x + vy * radial_y - side * coming[2]
    line = friction_line(slip, state.bar_bristle[row, i], payload.bar_friction, payload.bar_friction, 0.0, payload)
    write_friction(records, k, at, normal, line)
    return True


@kernel
def open_raceway(state: State, inner: bool, row: int, i: int) -> None:
    """Forget a roller's contact with a raceway that has opened."""
    if inner:
        state.inner_force[row, i] = state.inner_friction[row, i] = state.inner_bristle[row, i] = 0.0
    else:
        state.outer_force[row, i] = state.outer_friction[row, i] = state.outer_bristle[row, i] = 0.0


@kernel
def begin_roller(
    payload: Payload,
    state: State,
    work: Workspace,
    records: Floats,
    k: int,
    row: int,
    i: int,
    x: float,
    y: float,
    tau: tuple[float, float],
    before: tuple[float, float],
    coming: tuple[float, float, float],
) -> int:
    """Write the record of roller ``i`` at (x, y); return how many of its contacts are closed."""
    count = 0
    for inner in (True, False):
        dx, dy, reach = x - state.outer_position[0], y - state.outer_position[1], payload.outer_raceway_radius - payload.roller_radius
        apart = dx * dx + dy * dy <= reach * reach
        if inner:
            dx, dy, reach = x - state.inner_position[0], y - state.inner_position[1], payload.inner_raceway_radius + payload.roller_radius
            apart = dx * dx + dy * dy >= reach * reach
        if not apart and touch_raceway(payload, state, work, records, k, HEAD + count * FIELDS, row, i, inner, dx, dy, before, coming):
            count += 1
        else:
            open_raceway(state, inner, row, i)
    squeezed = count == 2
    if payload.free[row, i] and touch_bar(payload, state, work, records, k, HEAD + count * FIELDS, row, i, tau, before, coming):
        count += 1
    records[k, ROLLER], records[k, COUNT], records[k, TAU_X], records[k, TAU_Y] = i, count, tau[0], tau[1]
    records[k, TIGHT] = 1.0 if squeezed or not payload.free[row, i] else 0.0
    mixed = records[k, HEAD + NORMAL_X] * records[k, HEAD + TANGENT_X] + records[k, HEAD + NORMAL_Y] * records[k, HEAD + TANGENT_Y]
    records[k, LONE] = 1.0 if count == 0 or (count == 1 and abs(mixed) < 1e-9) else 0.0
    return count


@kernel
def partner_velocity(work: Workspace, records: Floats, k: int, at: int) -> tuple[float, float]:
    """Return the mean velocity of the body touched, along normal and tangent [m/s]."""
    body = int(records[k, at + BODY])
    turn = work.mean[body, 2]
    vx, vy = work.mean[body, 0] - turn * records[k, at + LEVER_Y], work.mean[body, 1] + turn * records[k, at + LEVER_X]
    return (
        vx * records[k, at + NORMAL_X] + vy * records[k, at + NORMAL_Y] + records[k, at + SURFACE_N],
        vx * records[k, at + TANGENT_X] + vy * records[k, at + TANGENT_Y] + records[k, at + SURFACE_T],
    )


@kernel
def move_pinned(payload: Payload, state: State, work: Workspace, records: Floats, k: int, row: int) -> None:
    """Solve for the mean spin of a pinned roller, which moves with its cage."""
    h, body = payload.step, CAGE + row
    rim = payload.pitch_radius * work.mean[body, 2]
    records[k, MEAN_X] = work.mean[body, 0] + rim * records[k, TAU_X]
    records[k, MEAN_Y] = work.mean[body, 1] + rim * records[k, TAU_Y]
    inertia = 2.0 * payload.roller_inertia / (payload.roller_radius * payload.roller_radius)
    total, right = inertia, inertia * payload.roller_radius * state.roller_velocity[row, int(records[k, ROLLER]), 2]
    for c in range(int(records[k, COUNT])):
        at = HEAD + c * FIELDS
        _, pt = partner_velocity(work, records, k, at)
        along = records[k, MEAN_X] * records[k, at + TANGENT_X] + records[k, MEAN_Y] * records[k, at + TANGENT_Y]
        total += h * records[k, at + SLOPE]
        right -= h * records[k, at + TURN] * (records[k, at + CONSTANT] + records[k, at + SLOPE] * (along - pt))
    records[k, MEAN_RIM] = right / total


@kernel
def pushed_alone(payload: Payload, state: State, work: Workspace, row: int, i: int) -> tuple[float, float, float]:
    """Return mean velocity and surface speed of a free roller without its contacts [m/s]."""
    h, radius = payload.step, payload.roller_radius
    by_mass, by_inertia = 0.5 * h / payload.roller_mass, 0.5 * h * radius * radius / payload.roller_inertia
    return (
        state.roller_velocity[row, i, 0] + by_mass * work.external[row, i, 0],
        state.roller_velocity[row, i, 1] + by_mass * work.external[row, i, 1] - 0.5 * h * payload.gravity,
        radius * state.roller_velocity[row, i, 2] + by_inertia * work.external[row, i, 2],
    )


@kernel
def move_lone(payload: Payload, state: State, work: Workspace, records: Floats, k: int, row: int) -> None:
    """Solve for a free roller with one contact or none, whose normal and tangent do not mix: each is a scalar equation."""
    h, i, at, radius = payload.step, int(records[k, ROLLER]), HEAD, payload.roller_radius
    x, y, rim = pushed_alone(payload, state, work, row, i)
    if records[k, COUNT] > 0.0:
        by_mass, by_inertia = 0.5 * h / payload.roller_mass, 0.5 * h * radius * radius / payload.roller_inertia
        nx, ny, tx, ty = records[k, at + NORMAL_X], records[k, at + NORMAL_Y], records[k, at + TANGENT_X], records[k, at + TANGENT_Y]
        pn, pt = partner_velocity(work, records, k, at)
        side, turn = records[k, at + SIDE], records[k, at + TURN]
        normal = side * (records[k, at + PUSH] - records[k, at + GIVE] * side * (x * nx + y * ny - pn))
        normal /= 1.0 + by_mass * records[k, at + GIVE]
        friction = records[k, at + CONSTANT] + records[k, at + SLOPE] * (x * tx + y * ty + turn * rim - pt)
        friction /= 1.0 + (by_mass + by_inertia) * records[k, at + SLOPE]
        x += by_mass * (normal * nx - friction * tx)
        y += by_mass * (normal * ny - friction * ty)
        rim -= by_inertia * turn * friction
    records[k, MEAN_X], records[k, MEAN_Y], records[k, MEAN_RIM] = x, y, rim


@kernel
def move_free(payload: Payload, state: State, work: Workspace, records: Floats, k: int, row: int) -> None:
    """Solve for the mean velocity and spin of a free roller between the bodies it touches."""
    h, i = payload.step, int(records[k, ROLLER])
    mass, inertia = 2.0 * payload.roller_mass, 2.0 * payload.roller_inertia / (payload.roller_radius * payload.roller_radius)
    xx, xy, yy, xw, yw, ww = mass, 0.0, mass, 0.0, 0.0, inertia
    x, y, w = pushed_alone(payload, state, work, row, i)
    x, y, w = mass * x, mass * y, inertia * w
    for c in range(int(records[k, COUNT])):
        at = HEAD + c * FIELDS
        nx, ny, tx, ty, turn = (
            records[k, at + NORMAL_X],
            records[k, at + NORMAL_Y],
            records[k, at + TANGENT_X],
            records[k, at + TANGENT_Y],
            records[k, at + TURN],
        )
        pn, pt = partner_velocity(work, records, k, at)
        give, slope = h * records[k, at + GIVE], h * records[k, at + SLOPE]
        push, hold = h * records[k, at + SIDE] * records[k, at + PUSH] + give * pn, slope * pt - h * records[k, at + CONSTANT]
        xx += give * nx * nx + slope * tx * tx
        xy += give * nx * ny + slope * tx * ty
        yy += give * ny * ny + slope * ty * ty
        xw += slope * turn * tx
        yw += slope * turn * ty
        ww += slope
        x += push * nx + hold * tx
        y += push * ny + hold * ty
        w += hold * turn
    by_w = 1.0 / ww
    xx, xy, yy = xx - by_w * xw * xw, xy - by_w * xw * yw, yy - by_w * yw * yw
    x, y = x - by_w * w * xw, y - by_w * w * yw
    by_determinant = 1.0 / (xx * yy - xy * xy)
    mean_x, mean_y = (yy * x - xy * y) * by_determinant, (xx * y - xy * x) * by_determinant
    records[k, MEAN_X], records[k, MEAN_Y], records[k, MEAN_RIM] = mean_x, mean_y, (w - xw * mean_x - yw * mean_y) * by_w


@kernel
def contact_forces(work: Workspace, records: Floats, k: int, at: int) -> tuple[float, float, float, float]:
    """Return normal force [N], friction [N], approach [m/s] and slip [m/s] of a contact at the mean velocities."""
    pn, pt = partner_velocity(work, records, k, at)
    vn = records[k, MEAN_X] * records[k, at + NORMAL_X] + records[k, MEAN_Y] * records[k, at + NORMAL_Y] - pn
    slip = (
        records[k, MEAN_X] * records[k, at + TANGENT_X]
        + records[k, MEAN_Y] * records[k, at + TANGENT_Y]
        + records[k, at + TURN] * records[k, MEAN_RIM]
        - pt
    )
    approach = -records[k, at + SIDE] * vn
    normal, friction = records[k, at + PUSH] + records[k, at + GIVE] * approach, records[k, at + CONSTANT] + records[k, at + SLOPE] * slip
    return normal, friction, approach, slip


@kernel
def push_bodies(payload: Payload, work: Workspace, records: Floats, k: int, row: int, forces: Floats) -> None:
    """Add what a roller's contacts do to the bodies it touches, and a pinned one's to its cage."""
    total_x, total_y = 0.0, 0.0
    for c in range(int(records[k, COUNT])):
        at = HEAD + c * FIELDS
        normal, friction, _, _ = contact_forces(work, records, k, at)
        normal *= records[k, at + SIDE]
        fx = normal * records[k, at + NORMAL_X] - friction * records[k, at + TANGENT_X]
        fy = normal * records[k, at + NORMAL_Y] - friction * records[k, at + TANGENT_Y]
        body = int(records[k, at + BODY])
        forces[body, 0] -= fx
        forces[body, 1] -= fy
        forces[body, 2] -= records[k, at + LEVER_X] * fy - records[k, at + LEVER_Y] * fx
        total_x += fx
        total_y += fy
    if not payload.free[row, int(records[k, ROLLER])]:
        forces[CAGE + row, 0] += total_x
        forces[CAGE + row, 1] += total_y
        forces[CAGE + row, 2] += payload.pitch_radius * (total_x * records[k, TAU_X] + total_y * records[k, TAU_Y])


@kernel
def remember_contacts(payload: Payload, state: State, work: Workspace, records: Floats, k: int, row: int) -> None:
    """Keep forces, slip and bristles of a roller's closed contacts, and book their energy."""
    h, i = payload.step, int(records[k, ROLLER])
    for c in range(int(records[k, COUNT])):
        at = HEAD + c * FIELDS
        normal, friction, approach, slip = contact_forces(work, records, k, at)
        closing = approach - records[k, at + SINK]
        state.account[FRICTION] += h * friction * slip
        state.account[LOSS] += h * records[k, at + DAMPING] * closing * closing
        state.account[NOTCH] += h * normal * records[k, at + SINK]
        state.account[DRIVE] += h * (records[k, at + SIDE] * normal * records[k, at + SURFACE_N] - friction * records[k, at + SURFACE_T])
        body = int(records[k, at + BODY])
        if body == INNER:
            state.inner_force[row, i], state.inner_friction[row, i], state.inner_slip[row, i] = records[k, at + FORCE], friction, slip
            state.inner_bristle[row, i] = bristle_after(state.inner_bristle[row, i], slip, records[k, at + RATE], records[k, at + PHI], h)
        elif body == OUTER:
            state.outer_force[row, i], state.outer_friction[row, i], state.outer_slip[row, i] = records[k, at + FORCE], friction, slip
            state.outer_bristle[row, i] = bristle_after(state.outer_bristle[row, i], slip, records[k, at + RATE], records[k, at + PHI], h)
        else:
            state.bar_force[row, i] = -records[k, at + SIDE] * records[k, at + FORCE]
            state.bar_bristle[row, i] = bristle_after(state.bar_bristle[row, i], slip, records[k, at + RATE], records[k, at + PHI], h)


@kernel
def finish_roller(payload: Payload, state: State, work: Workspace, records: Floats, k: int, row: int) -> None:
    """Update a roller's velocity and spin from their means."""
    remember_contacts(payload, state, work, records, k, row)
    i = int(records[k, ROLLER])
    spin = records[k, MEAN_RIM] / payload.roller_radius
    state.roller_change[row, i, 2] = 2.0 * (spin - state.roller_velocity[row, i, 2])
    state.roller_velocity[row, i, 2] += state.roller_change[row, i, 2]
    if payload.free[row, i]:
        state.roller_change[row, i, 0] = 2.0 * (records[k, MEAN_X] - state.roller_velocity[row, i, 0])
        state.roller_change[row, i, 1] = 2.0 * (records[k, MEAN_Y] - state.roller_velocity[row, i, 1])
        state.roller_velocity[row, i, 0] += state.roller_change[row, i, 0]
        state.roller_velocity[row, i, 1] += state.roller_change[row, i, 1]
