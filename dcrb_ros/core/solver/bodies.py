"""Rings and cages over one step: their velocities under the forces of the rollers."""

from __future__ import annotations

import math

from dcrb_ros.core.contacts.cage_films import resist_cage
from dcrb_ros.core.contacts.force_line import DISPERSION
from dcrb_ros.core.jit import piece
from dcrb_ros.core.laws.calls import has_cage_oil
from dcrb_ros.core.layout.state import CAGE, HOUSING, INNER, LOAD, OUTER, SHAFT_ANGLE, SHAFT_SPEED, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload


@piece
def predict_bodies(payload: Payload, state: State, work: Workspace) -> None:
    """Write the cages' directions, and the mean velocities predicted for the step: as if their last change went on growing."""
    heading, moment = work.heading, work.train_moment
    for body in range(state.velocity.shape[0]):
        for part in range(3):
            work.mean_velocity[body, part] = state.velocity[body, part] + state.change[body, part] - 0.5 * state.earlier_change[body, part]
    for row in range(heading.shape[0]):
        turn = state.position[CAGE + row, 2]
        heading[row, 0], heading[row, 1] = math.cos(turn), math.sin(turn)
        moment[row, 0] = heading[row, 0] * payload.train_moment[row, 0] - heading[row, 1] * payload.train_moment[row, 1]
        moment[row, 1] = heading[row, 1] * payload.train_moment[row, 0] + heading[row, 0] * payload.train_moment[row, 1]


@piece
def move_cage(payload: Payload, state: State, work: Workspace, row: int, damped: bool) -> float:
    """Solve for the mean velocity of a cage with its pinned rollers, whose centre of mass may lie off the cage's centre.

    Returns the change of that velocity by the solution [m/s]. A ``damped`` cage takes half of it.
    The oil of its lands also changes the mean velocity of the outer ring.
    """
    h, body, sx, sy = payload.step, CAGE + row, work.train_moment[row, 0], work.train_moment[row, 1]
    mean, free, bound = work.mean_velocity, work.force_of_free, work.force_of_bound
    # Tangents turn into radii with the cage's speed: the centrifugal force of the pinned rollers is along (sy, -sx).
    whirl = mean[body, 2] * mean[body, 2]
    fx = free[body, 0] + bound[body, 0] + whirl * sy
    fy = free[body, 1] + bound[body, 1] - whirl * sx - payload.train_mass[row] * payload.gravity
    torque = free[body, 2] + bound[body, 2] - payload.gravity * sy
    by_mass, by_inertia = payload.train_inverse[row, 0], payload.train_inverse[row, 1]
    lift_x, lift_y = 0.5 * h * fx * by_mass, 0.5 * h * fy * by_mass
    turn = (0.5 * h * torque - sx * lift_x - sy * lift_y) * by_inertia
    x, y = state.velocity[CAGE + row, 0] + lift_x - sx * by_mass * turn, state.velocity[CAGE + row, 1] + lift_y - sy * by_mass * turn
    speed = state.velocity[CAGE + row, 2] + turn
    if has_cage_oil(payload.lubrication):
        x, y = resist_cage(payload, work, row, x, y)
    moved: float = max(abs(x - mean[body, 0]), abs(y - mean[body, 1])) + payload.pitch_radius * abs(speed - mean[body, 2])
    if damped:
        x, y, speed = 0.5 * (x + mean[body, 0]), 0.5 * (y + mean[body, 1]), 0.5 * (speed + mean[body, 2])
    mean[body, 0], mean[body, 1], mean[body, 2] = x, y, speed
    return moved


@piece
def add_preload(payload: Payload, state: State, work: Workspace) -> None:
    """Add the force of a primary suspension on the outer ring at its seat, which carries load and weight."""
    work.force_of_free[OUTER, 0] -= state.load[0]
    work.force_of_free[OUTER, 1] += payload.carried_weight - state.load[1]


@piece
def book_preload(payload: Payload, state: State, work: Workspace) -> None:
    """Book the work of that force."""
    moved_x, moved_y = payload.step * work.mean_velocity[OUTER, 0], payload.step * work.mean_velocity[OUTER, 1]
    state.account[LOAD] += (payload.carried_weight - state.load[1]) * moved_y - state.load[0] * moved_x


@piece
def move_rings(payload: Payload, state: State, work: Workspace) -> tuple[float, float]:
    """Solve for the mean velocities of the rings; return the largest change by the solution, and the largest change over the step [m/s]."""
    moved = changed = 0.0
    h, stiffness, mean, free, bound = payload.step, payload.housing_stiffness, work.mean_velocity, work.force_of_free, work.force_of_bound
    outer_inertia = 2.0 * (payload.outer_mass + DISPERSION * h * h * stiffness)
    by_outer, by_inner = 1.0 / (outer_inertia + h * payload.housing_damping), 0.5 * h / payload.inner_mass
    for axis in range(2):
        weight = payload.gravity if axis == 1 else 0.0
        outer = free[OUTER, axis] + bound[OUTER, axis] - stiffness * state.position[OUTER, axis] - payload.outer_ring_mass * weight
        inner = free[INNER, axis] + bound[INNER, axis] + state.load[axis] - payload.inner_ring_mass * weight
        outer = (outer_inertia * state.velocity[OUTER, axis] + h * outer) * by_outer
        inner = state.velocity[INNER, axis] + by_inner * inner
        moved = max(moved, max(abs(outer - mean[OUTER, axis]), abs(inner - mean[INNER, axis])))
        changed = max(changed, max(abs(outer - state.velocity[OUTER, axis]), abs(inner - state.velocity[INNER, axis])))
        mean[OUTER, axis], mean[INNER, axis] = outer, inner
    return moved, changed


@piece
def finish_bodies(payload: Payload, state: State, work: Workspace) -> None:
    """Update the velocities of rings and cages from their means, and book the energy of load and housing."""
    h = payload.step
    for axis in range(2):
        outer, inner = work.mean_velocity[OUTER, axis], work.mean_velocity[INNER, axis]
        state.account[LOAD] += h * state.load[axis] * inner
        state.account[HOUSING] += h * payload.housing_damping * outer * outer
    for body in range(state.velocity.shape[0]):
        for part in range(3):
            state.earlier_change[body, part] = state.change[body, part]
            state.change[body, part] = 2.0 * (work.mean_velocity[body, part] - state.velocity[body, part])
            state.velocity[body, part] += state.change[body, part]


@piece
def drift(payload: Payload, state: State, time: float) -> None:
    """Move all bodies with their velocities for ``time`` [s]; where a pinned roller is follows from its cage.

    The plane's rollers have the radius r cos(alpha) and turn 1/cos(alpha) times as fast in their cage as the bearing's, of the radius r:
    a roller's angle is that of its surface, relative to the cage cos(alpha) of the plane's.
    """
    for body in range(state.position.shape[0]):
        for part in range(3):
            state.position[body, part] += time * state.velocity[body, part]
    rollers, share, each = state.rollers[0], payload.spin_share, payload.free.shape[1]
    for c in range(payload.free.size):
        rollers.angle[c] += time * rollers.spin[c]
    if share != 1.0:
        for c in range(payload.free.size):
            rollers.angle[c] += time * (share - 1.0) * (rollers.spin[c] - state.velocity[CAGE + c // each, 2])
    if payload.any_free:
        for c in range(payload.free.size):
            rollers.x[c] += time * rollers.vx[c]
            rollers.y[c] += time * rollers.vy[c]
    state.shaft[SHAFT_ANGLE] += time * state.shaft[SHAFT_SPEED]
