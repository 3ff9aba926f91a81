"""The time loop: drift half a step, forces at the midpoint, implicit velocity update, drift half a step.

One force evaluation per step, second order. Every contact is a straight line over the mean velocities of the bodies
it joins: normal forces explicit with a mass correction, their loss and the friction linearly implicit, so that gross
sliding (bristle rates of 2e7 1/s) needs no shorter step. A roller is light and its contacts stiff: its velocity and spin
are solved for exactly between the bodies it touches. Rings and cages are heavy: they start from the velocities predicted,
and further sweeps over the bound rollers take out what the prediction lacked, a hundredth each time, until nothing moves.
"""

from __future__ import annotations

from dcrb_ros.core import lanes as at
from dcrb_ros.core.bars import touch_bars
from dcrb_ros.core.bodies import drift, finish_bodies, move_cage, move_rings, predict_bodies, touch_land
from dcrb_ros.core.jit import kernel, loop, piece
from dcrb_ros.core.neighbours import add_neighbours
from dcrb_ros.core.payload import SINK, Floats, Payload
from dcrb_ros.core.place import bind_row, bind_special, gather_bound, place_row
from dcrb_ros.core.raceway import turn_notches
from dcrb_ros.core.remember import forget, keep_bound, keep_light, let_go
from dcrb_ros.core.solve import prepare_bound, push_bound, push_light, solve_bound, solve_light
from dcrb_ros.core.state import State
from dcrb_ros.core.touch import draw_raceways, face_raceways, press_raceways
from dcrb_ros.core.work import OUTER, Workspace

MOST_SWEEPS = 6
"""Passes over the bound rollers in a step at most."""
STILL = 2e9
"""Change of a mean velocity of rings and cages by a pass that needs no further one, over the step cubed [m/s^4]: what is left then is a
hundredth of it, and with the cube of the step the order stays two."""


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
            state.lanes[at.POCKET_X + c], state.lanes[at.POCKET_Y + c] = (
                payload.pocket_tangent[row, i, 0],
                payload.pocket_tangent[row, i, 1],
            )


@piece
def begin(payload: Payload, state: State, work: Workspace) -> int:
    """Place the rollers, find the bound ones and put them side by side; return how many lanes they take."""
    bound = 0
    for row in range(payload.free.shape[0]):
        touch_land(payload, state, work, row)
        if payload.any_broken:
            add_neighbours(payload, state, work.external, row)
        place_row(payload, state, work, row)
        if payload.any_broken or payload.notch_law != SINK:
            bind_special(payload, work, row)
        bound = bind_row(payload, work, row, bound)
        work.ends[row] = bound
    return gather_bound(payload, state, work, bound) if bound > 0 else 0


@piece
def face_all(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write how rollers lie to the raceways; bound ones take ``count`` lanes."""
    if payload.all_free:
        face_raceways(payload, state, work.light, payload.free.size, payload.free.size, False)
    face_raceways(payload, state, work.bound, work.ends[work.ends.size - 1], count, True)


@piece
def press_all(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write the elastic forces of the raceways."""
    if payload.all_free:
        press_raceways(payload, state, work, work.light, work.every, payload.free.size, payload.free.size, False)
    press_raceways(payload, state, work, work.bound, work.order, work.ends[work.ends.size - 1], count, True)


@piece
def draw_all(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write all contacts of rollers with raceways and bars as lines over the mean velocities of the step."""
    if payload.all_free:
        draw_raceways(payload, state, work, work.light, payload.free.size, False)
    draw_raceways(payload, state, work, work.bound, count, True)
    if payload.any_free:
        touch_bars(payload, state, work, work.ends[work.ends.size - 1], count)


@piece
def solve(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Solve for the mean velocities of all bodies, those of rings and cages being predicted at first."""
    if payload.all_free:
        solve_light(payload, work.light, payload.free.size, work.mean[OUTER, 0], work.mean[OUTER, 1])
        push_light(work, payload.free.size)
    prepare_bound(payload, work, count)
    surface = state.shaft[1] * payload.inner_raceway_radius
    still = STILL * payload.step * payload.step * payload.step
    for _ in range(MOST_SWEEPS):
        solve_bound(payload, work, count, surface)
        push_bound(payload, work)
        moved = move_rings(payload, state, work)
        for row in range(payload.free.shape[0]):
            moved = max(moved, move_cage(payload, state, work, row))
        if moved < still:
            break


@piece
def keep(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Keep what became of the rollers."""
    if payload.all_free:
        let_go(state, work.light, payload.free.size)
        keep_light(payload, state, work, payload.free.size)
    else:
        forget(state, payload.free.size)
    keep_bound(payload, state, work, work.ends[work.ends.size - 1], count, state.shaft[1] * payload.inner_raceway_radius)


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
        predict_bodies(state, work)
        clear(work.loose)
        count = begin(payload, state, work)
        face_all(payload, state, work, count)
        press_all(payload, state, work, count)
        draw_all(payload, state, work, count)
        solve(payload, state, work, count)
        keep(payload, state, work, count)
        finish_bodies(payload, state, work)
        for axis in range(2):
            acceleration[n, axis] = state.outer_change[axis] / h
        drift(payload, state, 0.5 * h)
        state.shaft[1] = speed_after
