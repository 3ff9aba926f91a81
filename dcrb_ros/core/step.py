"""The time loop: drift half a step, forces at the midpoint, implicit velocity update, drift half a step.

One force evaluation per step, second order. Every contact is a straight line over the mean velocities of the bodies
it joins: normal forces explicit with a mass correction, their loss and the friction linearly implicit, so that gross
sliding (bristle rates of 2e7 1/s) needs no shorter step. A roller is light and its contacts stiff: its velocity and spin
are solved for exactly between the bodies it touches. Rings and cages are heavy: they start from the velocities predicted,
and further sweeps over the squeezed rollers take out what the prediction lacked (a hundredth each time).
"""

from __future__ import annotations

import math

from dcrb_ros.core.bodies import drift, finish_bodies, move_cage, move_rings, predict_bodies, touch_land
from dcrb_ros.core.jit import kernel, loop
from dcrb_ros.core.neighbours import add_neighbours
from dcrb_ros.core.payload import Floats, Payload
from dcrb_ros.core.raceway import turn_notches
from dcrb_ros.core.roller import begin_roller, finish_roller, move_free, move_lone, move_pinned, open_raceway, push_bodies
from dcrb_ros.core.state import State
from dcrb_ros.core.work import CAGE, LONE, ROLLER, TIGHT, Workspace

SWEEPS = 3
"""Passes over the squeezed rollers in a step."""


@kernel
def ramped(value: float, target: float, most: float) -> float:
    """Return ``value`` moved towards ``target`` by ``most`` at most."""
    return value + min(max(target - value, -most), most)


@kernel
def begin_row(payload: Payload, state: State, work: Workspace, row: int, first: int) -> int:
    """Write the records of a row's rollers that take part in this step, from ``first`` on; return where they end."""
    radius = payload.pitch_radius
    inner_reach = payload.inner_raceway_radius + payload.roller_radius
    outer_reach = payload.outer_raceway_radius - payload.roller_radius
    inner_square, outer_square = inner_reach * inner_reach, outer_reach * outer_reach
    cage_x, cage_y, angle = state.cage_position[row, 0], state.cage_position[row, 1], state.cage_position[row, 2]
    cosine, sine = math.cos(angle), math.sin(angle)
    old_x, old_y, old_rim = state.cage_velocity[row, 0], state.cage_velocity[row, 1], radius * state.cage_velocity[row, 2]
    mean_x, mean_y, mean_rim = work.mean[CAGE + row, 0], work.mean[CAGE + row, 1], radius * work.mean[CAGE + row, 2]
    k = first
    for i in range(payload.free.shape[1]):
        px, py = payload.pocket_tangent[row, i, 0], payload.pocket_tangent[row, i, 1]
        tx, ty = cosine * px - sine * py, sine * px + cosine * py
        surface = payload.roller_radius * (state.roller_velocity[row, i, 2] + 0.5 * state.roller_change[row, i, 2])
        free = payload.free[row, i]
        if free:
            x, y = state.roller_position[row, i, 0], state.roller_position[row, i, 1]
            before = (state.roller_velocity[row, i, 0], state.roller_velocity[row, i, 1])
            coming = (before[0] + 0.5 * state.roller_change[row, i, 0], before[1] + 0.5 * state.roller_change[row, i, 1], surface)
        else:
            x, y = cage_x + radius * ty, cage_y - radius * tx
            before = (old_x + old_rim * tx, old_y + old_rim * ty)
            coming = (mean_x + mean_rim * tx, mean_y + mean_rim * ty, surface)
        ix, iy, ox, oy = x - state.inner_position[0], y - state.inner_position[1], x - state.outer_position[0], y - state.outer_position[1]
        closed = 0
        if free or ix * ix + iy * iy < inner_square or ox * ox + oy * oy > outer_square:
            closed = begin_roller(payload, state, work, work.records, k, row, i, x, y, (tx, ty), before, coming)
        if free or closed > 0:
            k += 1
        elif state.inner_force[row, i] > 0.0 or state.outer_force[row, i] > 0.0:
            open_raceway(state, True, row, i)
            open_raceway(state, False, row, i)
            state.roller_change[row, i, 2] = 0.0
    return k


@kernel
def sweep_row(payload: Payload, state: State, work: Workspace, row: int, first: int, end: int, all_of_them: bool) -> None:
    """Solve for a row's rollers, or the squeezed ones only, and add what they do to rings and cages."""
    for k in range(first, end):
        squeezed = work.records[k, TIGHT] > 0.0
        if not (all_of_them or squeezed):
            continue
        if not payload.free[row, int(work.records[k, ROLLER])]:
            move_pinned(payload, state, work, work.records, k, row)
        elif work.records[k, LONE] > 0.0:
            move_lone(payload, state, work, work.records, k, row)
        else:
            move_free(payload, state, work, work.records, k, row)
        if squeezed:
            push_bodies(payload, work, work.records, k, row, work.tight)
        else:
            push_bodies(payload, work, work.records, k, row, work.loose)


@kernel
def clear(forces: Floats) -> None:
    """Set forces on bodies to zero."""
    for body in range(forces.shape[0]):
        for part in range(3):
            forces[body, part] = 0.0


@loop
def advance(payload: Payload, state: State, work: Workspace, acceleration: Floats, shaft_angle: Floats) -> None:
    """Advance the state by ``len(acceleration)`` steps.

    Writes the outer ring's mean acceleration in X and Y over each step, shape (steps, 2) [m/s^2], and the rotation of
    the inner ring at the beginning of each step, shape (steps,) [rad].
    """
    h = payload.step
    rows = payload.free.shape[0]
    turn_notches(payload.outer_notches, 0.0, work.outer_towards)
    for n in range(acceleration.shape[0]):
        shaft_angle[n] = state.shaft[0]
        for axis in range(2):
            state.load[axis] = ramped(state.load[axis], state.target[1 + axis], payload.load_ramp * h)
        speed_after = ramped(state.shaft[1], state.target[0], payload.speed_ramp * h)
        state.shaft[1] = 0.5 * (state.shaft[1] + speed_after)
        drift(payload, state, 0.5 * h)
        turn_notches(payload.inner_notches, state.shaft[0], work.inner_towards)
        predict_bodies(state, work)
        clear(work.loose)
        for row in range(rows):
            touch_land(payload, state, work, row)
            add_neighbours(payload, state, work.external, row)
            work.ends[row + 1] = begin_row(payload, state, work, row, work.ends[row])
        for sweep in range(SWEEPS):
            clear(work.tight)
            for row in range(rows):
                sweep_row(payload, state, work, row, work.ends[row], work.ends[row + 1], sweep == 0)
            move_rings(payload, state, work)
            for row in range(rows):
                move_cage(payload, state, work, row)
        for row in range(rows):
            for k in range(work.ends[row], work.ends[row + 1]):
                finish_roller(payload, state, work, work.records, k, row)
        finish_bodies(payload, state, work)
        for axis in range(2):
            acceleration[n, axis] = state.outer_change[axis] / h
        drift(payload, state, 0.5 * h)
        state.shaft[1] = speed_after
