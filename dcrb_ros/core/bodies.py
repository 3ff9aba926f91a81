"""Rings and cages over one step: their velocities from what the rollers do to them."""

from __future__ import annotations

import math

from dcrb_ros.core import lanes as at
from dcrb_ros.core.jit import piece
from dcrb_ros.core.normal import DISPERSION
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.state import HOUSING, LOAD, State
from dcrb_ros.core.work import CAGE, INNER, OUTER, Workspace


@piece
def predict_bodies(payload: Payload, state: State, work: Workspace) -> None:
    """Write how the cages stand, and the mean velocities expected of the step: as if their last change went on growing."""
    for axis in range(2):
        work.mean[OUTER, axis] = state.outer_velocity[axis] + state.outer_change[axis] - 0.5 * state.earlier_change[OUTER, axis]
        work.mean[INNER, axis] = state.inner_velocity[axis] + state.inner_change[axis] - 0.5 * state.earlier_change[INNER, axis]
    for row in range(state.cage_velocity.shape[0]):
        work.heading[row, 0], work.heading[row, 1] = math.cos(state.cage_position[row, 2]), math.sin(state.cage_position[row, 2])
        work.moment[row, 0] = work.heading[row, 0] * payload.train_moment[row, 0] - work.heading[row, 1] * payload.train_moment[row, 1]
        work.moment[row, 1] = work.heading[row, 1] * payload.train_moment[row, 0] + work.heading[row, 0] * payload.train_moment[row, 1]
        for part in range(3):
            work.mean[CAGE + row, part] = (
                state.cage_velocity[row, part] + state.cage_change[row, part] - 0.5 * state.earlier_change[CAGE + row, part]
            )


@piece
def move_cage(payload: Payload, state: State, work: Workspace, row: int) -> float:
    """Solve for the mean velocity of a cage with its pinned rollers, whose centre of mass may lie off the cage's centre.

    Returns by how much that changes it [m/s].
    """
    h, body, sx, sy = payload.step, CAGE + row, work.moment[row, 0], work.moment[row, 1]
    # Tangents turn into radii with the cage's speed: the centrifugal force of the pinned rollers is along (sy, -sx).
    whirl = work.mean[body, 2] * work.mean[body, 2]
    fx = work.loose[body, 0] + work.tight[body, 0] + whirl * sy
    fy = work.loose[body, 1] + work.tight[body, 1] - whirl * sx - payload.train_mass[row] * payload.gravity
    torque = work.loose[body, 2] + work.tight[body, 2] - payload.gravity * sy
    by_mass, by_inertia = payload.train_yield[row, 0], payload.train_yield[row, 1]
    lift_x, lift_y = 0.5 * h * fx * by_mass, 0.5 * h * fy * by_mass
    turn = (0.5 * h * torque - sx * lift_x - sy * lift_y) * by_inertia
    x, y = state.cage_velocity[row, 0] + lift_x - sx * by_mass * turn, state.cage_velocity[row, 1] + lift_y - sy * by_mass * turn
    speed = state.cage_velocity[row, 2] + turn
    moved: float = max(abs(x - work.mean[body, 0]), abs(y - work.mean[body, 1])) + payload.pitch_radius * abs(speed - work.mean[body, 2])
    work.mean[body, 0], work.mean[body, 1], work.mean[body, 2] = x, y, speed
    return moved


@piece
def move_rings(payload: Payload, state: State, work: Workspace) -> tuple[float, float]:
    """Solve for the mean velocities of the rings; return by how much that changes them, and they the velocities before the step [m/s]."""
    moved = changed = 0.0
    h, stiffness = payload.step, payload.housing_stiffness
    outer_inertia = 2.0 * (payload.outer_ring_mass + DISPERSION * h * h * stiffness)
    by_outer, by_inner = 1.0 / (outer_inertia + h * payload.housing_damping), 0.5 * h / payload.inner_ring_mass
    for axis in range(2):
        weight = payload.gravity if axis == 1 else 0.0
        outer = (
            work.loose[OUTER, axis] + work.tight[OUTER, axis] - stiffness * state.outer_position[axis] - payload.outer_ring_mass * weight
        )
        inner = work.loose[INNER, axis] + work.tight[INNER, axis] + state.load[axis] - payload.inner_ring_mass * weight
        outer = (outer_inertia * state.outer_velocity[axis] + h * outer) * by_outer
        inner = state.inner_velocity[axis] + by_inner * inner
        moved = max(moved, max(abs(outer - work.mean[OUTER, axis]), abs(inner - work.mean[INNER, axis])))
        changed = max(changed, max(abs(outer - state.outer_velocity[axis]), abs(inner - state.inner_velocity[axis])))
        work.mean[OUTER, axis], work.mean[INNER, axis] = outer, inner
    return moved, changed


@piece
def finish_bodies(payload: Payload, state: State, work: Workspace) -> None:
    """Update the velocities of rings and cages from their means, and book the energy of load and housing."""
    h = payload.step
    for axis in range(2):
        outer, inner = work.mean[OUTER, axis], work.mean[INNER, axis]
        state.account[LOAD] += h * state.load[axis] * inner
        state.account[HOUSING] += h * payload.housing_damping * outer * outer
        state.earlier_change[OUTER, axis], state.earlier_change[INNER, axis] = state.outer_change[axis], state.inner_change[axis]
        state.outer_change[axis] = 2.0 * (outer - state.outer_velocity[axis])
        state.inner_change[axis] = 2.0 * (inner - state.inner_velocity[axis])
        state.outer_velocity[axis] += state.outer_change[axis]
        state.inner_velocity[axis] += state.inner_change[axis]
    for row in range(state.cage_velocity.shape[0]):
        for part in range(3):
            state.earlier_change[CAGE + row, part] = state.cage_change[row, part]
            state.cage_change[row, part] = 2.0 * (work.mean[CAGE + row, part] - state.cage_velocity[row, part])
            state.cage_velocity[row, part] += state.cage_change[row, part]


@piece
def drift(payload: Payload, state: State, time: float) -> None:
    """Move all bodies with their velocities for ``time`` [s]; where a pinned roller is follows from its cage."""
    for axis in range(2):
        state.outer_position[axis] += time * state.outer_velocity[axis]
        state.inner_position[axis] += time * state.inner_velocity[axis]
    for row in range(state.cage_position.shape[0]):
        for part in range(3):
            state.cage_position[row, part] += time * state.cage_velocity[row, part]
    lanes = state.lanes
    for c in range(payload.free.size):
        lanes[at.ANGLE + c] += time * lanes[at.SPIN + c]
    if payload.any_free:
        for c in range(payload.free.size):
            lanes[at.X + c] += time * lanes[at.VX + c]
            lanes[at.Y + c] += time * lanes[at.VY + c]
    state.shaft[0] += time * state.shaft[1]
