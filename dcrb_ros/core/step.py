"""The time loop: drift half a step, forces at the midpoint, implicit velocity update, drift half a step.

One force evaluation per step, second order. Every contact is a straight line over the mean velocities of the bodies
it joins: normal forces explicit with a mass correction, or by their potential where they close or open, their loss and the
friction linearly implicit, so that gross sliding (bristle rates of 2e7 1/s) needs no shorter step. A roller is light and its
contacts stiff: its velocity and spin are solved for exactly between the bodies it touches. Rings and cages are heavy: they
start from the velocities predicted, and further sweeps over the bound rollers take out what the prediction lacked, a
hundredth each time, until nothing moves.
"""

from __future__ import annotations

from dcrb_ros.core import lanes as at
from dcrb_ros.core.bars import keep_lands, push_lands, touch_cages
from dcrb_ros.core.bodies import drift, finish_bodies, move_cage, move_rings, predict_bodies
from dcrb_ros.core.jit import kernel, loop, piece
from dcrb_ros.core.neighbours import add_neighbours
from dcrb_ros.core.payload import JOHNSON, Floats, Payload
from dcrb_ros.core.place import bind_row, bind_special, expect_bound, gather_bound, place_rollers, push_neighbours
from dcrb_ros.core.raceway import turn_notches
from dcrb_ros.core.remember import forget, keep_bound
from dcrb_ros.core.rolling import find_notches, let_go, push_free, roll_free
from dcrb_ros.core.solve import prepare_bound, push_bound, solve_bound
from dcrb_ros.core.state import OUTER, State
from dcrb_ros.core.touch import draw_raceways, face_raceways
from dcrb_ros.core.work import Workspace

MOST_SWEEPS = 6
"""Passes over the bound rollers in a step at most."""
STILL = 3e8
"""Square of an angular frequency [rad^2/s^2]: a pass that changes no mean velocity of rings and cages by more than STILL h^2 times
the rings' change over the step needs no further one. What is left is a hundredth of it, and the order stays two."""
QUIET = 2e9
"""The same for rings that hardly move: a change of a mean velocity over the step cubed [m/s^4]."""


@kernel
def ramped(value: float, target: float, most: float) -> float:
    """Return ``value`` moved towards ``target`` by ``most`` at most."""
    return value + min(max(target - value, -most), most)


@piece
def lay_out(payload: Payload, state: State) -> None:
    """Write what the payload says of each roller into its lane."""
    rollers = payload.free.shape[1]
    for row in range(payload.free.shape[0]):
        for i in range(rollers):
            c = row * rollers + i
            state.lanes[at.FREE + c] = 1.0 if payload.free[row, i] else 0.0
            state.lanes[at.IN_SECOND + c] = 1.0 if row > 0 else 0.0
            state.lanes[at.POCKET_X + c], state.lanes[at.POCKET_Y + c] = (
                payload.pocket_tangent[row, i, 0],
                payload.pocket_tangent[row, i, 1],
            )


@piece
def begin(payload: Payload, state: State, work: Workspace) -> int:
    """Place the rollers, find the bound ones and put them side by side; return how many lanes they take."""
    if payload.any_free:
        place_rollers(payload, state, work, False)
    else:
        place_rollers(payload, state, work, True)
    bind_special(payload, work)
    bound = 0
    for row in range(payload.free.shape[0]):
        bound = bind_row(payload, work, row, bound)
        work.ends[row] = bound
    if bound == 0:
        return 0
    count = gather_bound(state, work, bound)
    expect_bound(payload, state, work, count)
    if payload.any_broken:
        add_neighbours(payload, state, work.external)
        push_neighbours(payload, work)
    return count


@piece
def roll(payload: Payload, state: State, work: Workspace) -> None:
    """Move the rollers that are not bound over the step, where there are such, and push the outer ring with them."""
    if not payload.all_free:
        forget(state, payload.free.size)
        return
    if payload.any_notch:
        find_notches(payload, state, work)
    if payload.contact_law == JOHNSON:
        roll_free(payload, state, work, True)
    else:
        roll_free(payload, state, work, False)
    let_go(payload, state, work)
    push_free(payload, work)


@piece
def solve(payload: Payload, state: State, work: Workspace, count: int, lands: int) -> None:
    """Solve for the mean velocities of the bound rollers and of rings and cages, predicted at first; ``lands`` cages touch theirs."""
    prepare_bound(payload, work, count)
    surface = state.shaft[1] * payload.inner_raceway_radius
    h = payload.step
    for _ in range(MOST_SWEEPS):
        solve_bound(payload, work, count, surface)
        push_bound(payload, work)
        push_lands(payload, work, lands)
        moved, changed = move_rings(payload, state, work)
        for row in range(payload.free.shape[0]):
            moved = max(moved, move_cage(payload, state, work, row))
        if moved < h * h * (STILL * changed + QUIET * h):
            break


@piece
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
    lay_out(payload, state)
    turn_notches(payload.outer_notches, 0.0, work.outer_towards)
    for n in range(acceleration.shape[0]):
        shaft_angle[n] = state.shaft[0]
        for axis in range(2):
            state.load[axis] = ramped(state.load[axis], state.target[1 + axis], payload.load_ramp * h)
        speed_after = ramped(state.shaft[1], state.target[0], payload.speed_ramp * h)
        state.shaft[1] = 0.5 * (state.shaft[1] + speed_after)
        drift(payload, state, 0.5 * h)
        turn_notches(payload.inner_notches, state.shaft[0], work.inner_towards)
        predict_bodies(payload, state, work)
        clear(work.loose)
        count = begin(payload, state, work)
        roll(payload, state, work)
        face_raceways(payload, state, work, count)
        draw_raceways(payload, state, work, count)
        lands = touch_cages(payload, state, work, count)
        solve(payload, state, work, count, lands)
        keep_bound(payload, state, work, count)
        keep_lands(payload, state, work, lands)
        finish_bodies(payload, state, work)
        for axis in range(2):
            acceleration[n, axis] = state.change[OUTER, axis] / h
        drift(payload, state, 0.5 * h)
        state.shaft[1] = speed_after
