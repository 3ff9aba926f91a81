"""The time loop: drift half a step, forces at the midpoint, implicit velocity update, drift half a step.

One force evaluation per step, second order. Every contact is a straight line over the mean velocities of the bodies
it joins: normal forces explicit with a mass correction, or by their potential where they close or open, their loss and the
friction linearly implicit, so that gross sliding (bristle rates of 2e7 1/s) needs no shorter step. A roller is light and its
contacts stiff: its velocity and spin are solved for exactly between the bodies it touches. Rings and cages are heavy: they
start from predicted velocities, and sweeps over the bound rollers correct these; each sweep reduces the residual about a hundredfold.
`docs/explanation/solver.md` derives the equations.
"""

from __future__ import annotations

from dcrb_ros.core.contacts.cage_films import add_land_films, drag_bound, store_land_films, write_spin_drag
from dcrb_ros.core.contacts.conformal import add_land_forces, linearize_cages, store_lands
from dcrb_ros.core.contacts.films import write_films
from dcrb_ros.core.contacts.notch import turn_notches
from dcrb_ros.core.contacts.raceway import linearize_raceways, locate_raceways
from dcrb_ros.core.contacts.roller_pair import add_pair_contacts
from dcrb_ros.core.contacts.surface import write_free_heights
from dcrb_ros.core.jit import NO, YES, ZERO, kernel, loop, piece
from dcrb_ros.core.laws.calls import has_cage_oil
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.layout.state import OUTER, SHAFT_ANGLE, SHAFT_SPEED, TARGET_SPEED, TARGET_X, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.bodies import add_preload, book_preload, drift, finish_bodies, move_cage, move_rings, predict_bodies
from dcrb_ros.core.solver.bound import prepare_bound, solve_bound, sum_bound_forces
from dcrb_ros.core.solver.classification import apply_pair_forces, bind_special, classify_rollers, gather_bound, list_bound, predict_bound
from dcrb_ros.core.solver.free import advance_free, clear_contacts, clear_pinned, find_notches, sum_free_forces
from dcrb_ros.core.solver.update import store_bound

MOST_SWEEPS = 6
"""Sweeps over the bound rollers in a step at most."""
MOST_DAMPED_SWEEPS = 16
"""Damped sweeps at most that follow where these hardly converge: where rollers act stiffly on a light cage."""
SLOW = 0.3
"""Change of the velocities by the last of `MOST_SWEEPS` over that by the first, beyond which damped sweeps follow [-]: the next step
predicts the velocities from the last ones and multiplies their error."""
CONVERGED = 3e8
"""Square of an angular frequency [rad^2/s^2]: a sweep that changes no mean velocity of rings and cages by more than CONVERGED h^2 times
the rings' change over the step is the last one. The residual is then a hundredth of that, and the order stays two."""
CONVERGED_AT_REST = 2e9
"""The same for rings that hardly move: a change of a mean velocity over the step cubed [m/s^4]."""


@kernel
def ramped(value: float, target: float, most: float) -> float:
    """Return ``value`` moved towards ``target`` by ``most`` at most."""
    return value + min(max(target - value, -most), most)


@piece
def write_pockets(payload: Payload, state: State) -> None:
    """Write each roller's pocket, row and joint from the payload into the table of rollers."""
    rollers, count = state.rollers[0], payload.free.shape[1]
    for row in range(payload.free.shape[0]):
        for i in range(count):
            c = row * count + i
            rollers.free[c] = 1.0 if payload.free[row, i] else 0.0
            rollers.second_row[c] = 1.0 if row > 0 else 0.0
            rollers.pocket_tangent_x[c], rollers.pocket_tangent_y[c] = payload.pocket_tangent[row, i, 0], payload.pocket_tangent[row, i, 1]
            rollers.pocket_clearance[c] = payload.pocket_clearance[row, i]


@piece
def find_bound(payload: Payload, state: State, work: Workspace) -> int:
    """Find the bound rollers and put them side by side; return how many elements they take."""
    if payload.any_free:
        classify_rollers(payload, state, work, NO)
    else:
        classify_rollers(payload, state, work, YES)
    write_free_heights(payload.surfaces, payload, state, work)
    bind_special(payload, work)
    end = ZERO
    for row in range(payload.free.shape[0]):
        end = list_bound(payload, work, row, end)
        work.row_ends[row] = end
    if end == 0:
        return 0
    count = gather_bound(payload, state, work, end)
    predict_bound(payload, state, work, count)
    if has_cage_oil(payload.lubrication):
        drag_bound(payload, work, count)
    if payload.any_broken:
        add_pair_contacts(payload, state, work.pair_force)
        apply_pair_forces(payload, work)
    return count


@piece
def advance_unbound(payload: Payload, state: State, work: Workspace) -> None:
    """Move the rollers that are not bound over the step, and sum their forces on the outer ring."""
    if not payload.all_free:
        clear_pinned(payload, state)
        return
    if payload.any_defect:
        find_notches(payload, state, work)
    advance_free(payload, state, work)
    clear_contacts(payload, state, work)
    sum_free_forces(payload, work)


@piece
def solve(payload: Payload, state: State, work: Workspace, count: int, lands: int) -> None:
    """Solve for the mean velocities of the bound rollers and of rings and cages, predicted at first; ``lands`` cages touch theirs."""
    prepare_bound(payload, work, count)
    surface = state.shaft[SHAFT_SPEED] * payload.inner_raceway_radius
    h = payload.step
    first = 0.0
    for sweep in range(MOST_SWEEPS + MOST_DAMPED_SWEEPS):
        damped = sweep >= MOST_SWEEPS
        solve_bound(payload, work, count, surface)
        sum_bound_forces(payload, work)
        add_land_forces(payload, work, lands)
        if has_cage_oil(payload.lubrication):
            add_land_films(payload, work)
        moved, changed = move_rings(payload, state, work)
        for row in range(payload.free.shape[0]):
            moved = max(moved, move_cage(payload, state, work, row, damped))
        first = moved if sweep == 0 else first
        if moved < h * h * (CONVERGED * changed + CONVERGED_AT_REST * h) or (sweep == MOST_SWEEPS - 1 and moved <= SLOW * first):
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
    write_pockets(payload, state)
    turn_notches(payload.outer_notches, 0.0, work.outer_notch_direction)
    for n in range(acceleration.shape[0]):
        shaft_angle[n] = state.shaft[SHAFT_ANGLE]
        for axis in range(2):
            state.load[axis] = ramped(state.load[axis], state.target[TARGET_X + axis], payload.load_ramp * h)
        speed_after = ramped(state.shaft[SHAFT_SPEED], state.target[TARGET_SPEED], payload.speed_ramp * h)
        state.shaft[SHAFT_SPEED] = 0.5 * (state.shaft[SHAFT_SPEED] + speed_after)
        drift(payload, state, 0.5 * h)
        turn_notches(payload.inner_notches, state.shaft[SHAFT_ANGLE], work.inner_notch_direction)
        predict_bodies(payload, state, work)
        write_films(payload, state)
        if has_cage_oil(payload.lubrication):
            write_spin_drag(payload, state, work)
        clear(work.force_of_free)
        if payload.suspended:
            add_preload(payload, state, work)
        count = find_bound(payload, state, work)
        advance_unbound(payload, state, work)
        locate_raceways(payload, state, work, count)
        linearize_raceways(payload, state, work, count)
        lands = linearize_cages(payload, state, work, count)
        solve(payload, state, work, count, lands)
        store_bound(payload, state, work, count)
        store_lands(payload, state, work, lands)
        if has_cage_oil(payload.lubrication):
            store_land_films(payload, state, work)
        finish_bodies(payload, state, work)
        if payload.suspended:
            book_preload(payload, state, work)
        for axis in range(2):
            acceleration[n, axis] = state.change[OUTER, axis] / h
        drift(payload, state, 0.5 * h)
        state.shaft[SHAFT_SPEED] = speed_after
