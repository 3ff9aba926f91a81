"""The time loop: drift half a step, forces at the midpoint, implicit velocity update, drift half a step.

One force evaluation per step, second order. Normal forces are explicit with a mass correction; their loss, the housing's
damping and the friction are linearly implicit at the mean velocity, so that gross sliding (bristle rates of 2e7 1/s)
needs no shorter step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dcrb_ros.core.equations import CAGE, INNER, OUTER, SUMS, UNKNOWNS, WIDTH, eliminate, fold_row, substitute
from dcrb_ros.core.jit import kernel, loop
from dcrb_ros.core.payload import Floats, Payload
from dcrb_ros.core.roller import DISPERSION, RECORD, add_roller, finish_roller, open_roller
from dcrb_ros.core.state import State


class Workspace(NamedTuple):
    """Scratch arrays of the time loop; nothing in them outlives a step."""

    sums: Floats
    """Sums over a row's rollers, shape (SUMS,)."""
    blocks: Floats
    """One block of equations per row, shape (rows, UNKNOWNS, WIDTH)."""
    rings: Floats
    """The rings' equations, shape (UNKNOWNS, WIDTH)."""
    mean: Floats
    """Mean velocities over the step of rings and cages, shape (rows, UNKNOWNS) [m/s]."""
    records: Floats
    """One record per roller that bears on a raceway, shape (rows, rollers, RECORD)."""


def workspace(rows: int, rollers: int) -> Workspace:
    """Return scratch arrays for ``rows`` rows of ``rollers`` rollers."""
    return Workspace(
        np.zeros(SUMS),
        np.zeros((rows, UNKNOWNS, WIDTH)),
        np.zeros((UNKNOWNS, WIDTH)),
        np.zeros((rows, UNKNOWNS)),
        np.zeros((rows, rollers, RECORD)),
    )


@kernel
def ramped(value: float, target: float, most: float) -> float:
    """Return ``value`` moved towards ``target`` by ``most`` at most."""
    return value + min(max(target - value, -most), most)


@kernel
def drift(state: State, time: float) -> None:
    """Move rings, cages and the shaft's angle with their velocities for ``time`` [s]."""
    for axis in range(2):
        state.outer_position[axis] += time * state.outer_velocity[axis]
        state.inner_position[axis] += time * state.inner_velocity[axis]
    for row in range(state.cage_position.shape[0]):
        for axis in range(3):
            state.cage_position[row, axis] += time * state.cage_velocity[row, axis]
    state.shaft[0] += time * state.shaft[1]


@kernel
def begin_cage(payload: Payload, state: State, block: Floats, row: int) -> None:
    """Start a row's equations with the inertia and weight of the cage and its pinned rollers."""
    mass, radius = payload.train_mass, payload.pitch_radius
    rim_mass = payload.train_inertia / (radius * radius)
    for i in range(3):
        for j in range(3):
            block[CAGE + i, CAGE + j] = 0.0
    block[CAGE, CAGE] = block[CAGE + 1, CAGE + 1] = 2.0 * mass
    block[CAGE + 2, CAGE + 2] = 2.0 * rim_mass
    block[CAGE, UNKNOWNS] = 2.0 * mass * state.cage_velocity[row, 0]
    block[CAGE + 1, UNKNOWNS] = 2.0 * mass * state.cage_velocity[row, 1] - payload.step * mass * payload.gravity
    block[CAGE + 2, UNKNOWNS] = 2.0 * rim_mass * radius * state.cage_velocity[row, 2]


@kernel
def begin_rings(payload: Payload, state: State, rings: Floats) -> None:
    """Start the rings' equations with inertia, weight, load and the housing's spring and damper."""
    h, stiffness = payload.step, payload.housing_stiffness
    outer_inertia = 2.0 * (payload.outer_ring_mass + DISPERSION * h * h * stiffness)
    inner_inertia = 2.0 * payload.inner_ring_mass
    for i in range(CAGE):
        for j in range(CAGE):
            rings[i, j] = 0.0
    for axis in range(2):
        o, i = OUTER + axis, INNER + axis
        rings[o, o] = outer_inertia + h * payload.housing_damping
        rings[o, UNKNOWNS] = outer_inertia * state.outer_velocity[axis] - h * stiffness * state.outer_position[axis]
        rings[i, i] = inner_inertia
        rings[i, UNKNOWNS] = inner_inertia * state.inner_velocity[axis] + h * state.load[axis]
    rings[OUTER + 1, UNKNOWNS] -= h * payload.outer_ring_mass * payload.gravity
    rings[INNER + 1, UNKNOWNS] -= h * payload.inner_ring_mass * payload.gravity


@kernel
def add_row(payload: Payload, state: State, sums: Floats, block: Floats, rings: Floats, records: Floats, row: int) -> int:
    """Assemble a row's equations, eliminate its cage, add what is left to the rings; return how many rollers bear."""
    begin_cage(payload, state, block, row)
    for k in range(SUMS):
        sums[k] = 0.0
    inner_reach = payload.inner_raceway_radius + payload.roller_radius
    outer_reach = payload.outer_raceway_radius - payload.roller_radius
    inner_square, outer_square = inner_reach * inner_reach, outer_reach * outer_reach
    radius = payload.pitch_radius
    cage_x, cage_y, angle = state.cage_position[row, 0], state.cage_position[row, 1], state.cage_position[row, 2]
    inner_x, inner_y = cage_x - state.inner_position[0], cage_y - state.inner_position[1]
    outer_x, outer_y = cage_x - state.outer_position[0], cage_y - state.outer_position[1]
    rim_speed = radius * state.cage_velocity[row, 2]
    cosine, sine = math.cos(angle), math.sin(angle)
    bearing = 0
    for i in range(payload.pocket_tangent.shape[1]):
        px, py = payload.pocket_tangent[row, i, 0], payload.pocket_tangent[row, i, 1]
        tx, ty = cosine * px - sine * py, sine * px + cosine * py
        x, y = radius * ty, -radius * tx
        ix, iy, ox, oy = inner_x + x, inner_y + y, outer_x + x, outer_y + y
        if ix * ix + iy * iy < inner_square or ox * ox + oy * oy > outer_square:
            if add_roller(payload, state, sums, records, bearing, row, i, cage_x + x, cage_y + y, tx, ty, rim_speed):
                bearing += 1
        elif state.inner_force[row, i] > 0.0 or state.outer_force[row, i] > 0.0:
            open_roller(state, row, i)
    fold_row(sums, block)
    eliminate(block, CAGE, UNKNOWNS)
    for k in range(CAGE):
        for j in range(k + 1):
            rings[k, j] += block[k, j]
        rings[k, UNKNOWNS] += block[k, UNKNOWNS]
    return bearing


@kernel
def finish_row(payload: Payload, state: State, block: Floats, records: Floats, mean: Floats, row: int, bearing: int) -> None:
    """Solve for a row's cage and update its velocity and its rollers; ``mean`` holds the rings' velocities."""
    substitute(block, CAGE, UNKNOWNS, mean)
    x, y, rim = mean[CAGE], mean[CAGE + 1], mean[CAGE + 2]
    for i in range(state.spin.shape[1]):
        state.spin_angle[row, i] += 0.5 * payload.step * state.spin[row, i]
    for k in range(bearing):
        finish_roller(
            payload, state, records, k, row, x - mean[INNER], y - mean[INNER + 1], x - mean[OUTER], y - mean[OUTER + 1], rim
        )
    for i in range(state.spin.shape[1]):
        state.spin_angle[row, i] += 0.5 * payload.step * state.spin[row, i]
    state.cage_velocity[row, 0] = 2.0 * x - state.cage_velocity[row, 0]
    state.cage_velocity[row, 1] = 2.0 * y - state.cage_velocity[row, 1]
    state.cage_velocity[row, 2] = 2.0 * rim / payload.pitch_radius - state.cage_velocity[row, 2]


@loop
def advance(payload: Payload, state: State, work: Workspace, acceleration: Floats, shaft_angle: Floats) -> None:
    """Advance the state by ``len(acceleration)`` steps.

    Writes the outer ring's mean acceleration in X and Y over each step, shape (steps, 2) [m/s^2], and the rotation of
    the inner ring at the beginning of each step, shape (steps,) [rad].
    """
    h = payload.step
    rows = state.cage_position.shape[0]
    bearing = np.zeros(rows, np.int64)
    for n in range(acceleration.shape[0]):
        shaft_angle[n] = state.shaft[0]
        for axis in range(2):
            state.load[axis] = ramped(state.load[axis], state.target[1 + axis], payload.load_ramp * h)
        speed_after = ramped(state.shaft[1], state.target[0], payload.speed_ramp * h)
        state.shaft[1] = 0.5 * (state.shaft[1] + speed_after)
        drift(state, 0.5 * h)
        begin_rings(payload, state, work.rings)
        for row in range(rows):
            bearing[row] = add_row(payload, state, work.sums, work.blocks[row], work.rings, work.records[row], row)
        eliminate(work.rings, 1, CAGE)
        for row in range(rows):
            substitute(work.rings, 0, CAGE, work.mean[row])
            finish_row(payload, state, work.blocks[row], work.records[row], work.mean[row], row, bearing[row])
        for axis in range(2):
            outer, inner = work.mean[0, OUTER + axis], work.mean[0, INNER + axis]
            acceleration[n, axis] = 2.0 * (outer - state.outer_velocity[axis]) / h
            state.outer_velocity[axis] = 2.0 * outer - state.outer_velocity[axis]
            state.inner_velocity[axis] = 2.0 * inner - state.inner_velocity[axis]
        drift(state, 0.5 * h)
        state.shaft[1] = speed_after
