"""The oil at bars and lands, and its drag on rollers and cages; see `dcrb_ros.core.laws.cage_oil`.

The damping at a bar acts on the side that a roller approaches, at the gap in the middle of the step. It is part of the bar's line for bound
rollers, and of the scalar equation along the raceway for the others. The drag is weak and slow: it is a force at the velocities predicted.
"""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.core.contacts.films import GROUPS
from dcrb_ros.core.jit import piece
from dcrb_ros.core.laws.calls import bar_shear, churning, land_damping, land_torque
from dcrb_ros.core.layout.records import VECTOR
from dcrb_ros.core.layout.state import CAGE, FRICTION, LOSS, OUTER, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.classification import bar_at

NORMAL_X, NORMAL_Y, DAMPING, TORQUE, FORCE = range(5)
"""Columns of ``Workspace.land_film``: direction from the lands' centre to the cage's [-], damping [N s/m], torque over the speed of the
cage [N m s], and radial force of the last sweep [N]."""
CONCENTRIC = 1e-15
"""Least distance of two centres, so that there is a direction from one to the other [m]."""


@piece
def write_spin_drag(payload: Payload, state: State, work: Workspace) -> None:
    """Write the drag of both bars on the spin of a group of rollers: the next group in every step."""
    rollers, last = state.rollers[0], state.position.shape[0] - 1
    size = (payload.free.size + GROUPS * VECTOR - 1) // (GROUPS * VECTOR) * VECTOR
    tick = state.tick[0]
    groups = range(GROUPS) if tick == 1 else range(tick % GROUPS, tick % GROUPS + 1)
    first_x, first_y = state.position[CAGE, 0], state.position[CAGE, 1]
    second_x, second_y = state.position[last, 0], state.position[last, 1]
    first_way, second_way = (work.heading[0, 0], work.heading[0, 1]), (work.heading[last - CAGE, 0], work.heading[last - CAGE, 1])
    for group in groups:
        first = np.uint64(group * size)
        for k in range(size):
            c = first + np.uint64(k)
            second = rollers.second_row[c] > 0.0
            cosine, sine = second_way[0] if second else first_way[0], second_way[1] if second else first_way[1]
            px, py = rollers.pocket_tangent_x[c], rollers.pocket_tangent_y[c]
            ax, ay = rollers.x[c] - (second_x if second else first_x), rollers.y[c] - (second_y if second else first_y)
            along, clearance = ax * (cosine * px - sine * py) + ay * (sine * px + cosine * py), rollers.pocket_clearance[c]
            drag = bar_shear(payload.lubrication, clearance - along) + bar_shear(payload.lubrication, clearance + along)
            rollers.spin_drag[c] = drag * rollers.free[c]


@piece
def drag_on_orbit(payload: Payload, work: Workspace, row: int) -> float:
    """Return the drag of the oil on each free roller of a row along its orbit [N]."""
    speed = payload.pitch_radius * work.mean_velocity[CAGE + row, 2]
    drag: float = -churning(payload.lubrication) * speed * abs(speed)
    return drag


@piece
def drag_bound(payload: Payload, work: Workspace, count: int) -> None:
    """Add the drag of the oil on ``count`` bound rollers to their velocities without contacts, and that on the cages to their forces."""
    bound, radius, last = work.bound[0], payload.roller_radius, work.mean_velocity.shape[0] - 1
    by_mass, by_inertia = 0.5 * payload.step / payload.roller_mass, 0.5 * payload.step * radius * radius / payload.roller_inertia
    first_turn, second_turn = work.mean_velocity[CAGE, 2], work.mean_velocity[last, 2]
    first_drag, second_drag = drag_on_orbit(payload, work, 0), drag_on_orbit(payload, work, last - CAGE)
    for k in range(count):
        second, free = bound.second_row[k] > 0.0, bound.free[k]
        turn, orbit = second_turn if second else first_turn, free * (second_drag if second else first_drag)
        past = bound.predicted_rim[k] - radius * turn
        drag = bound.spin_drag[k] * past
        bound.drag[k] = drag
        bound.drag_power[k] = drag * past - orbit * payload.pitch_radius * turn
        bound.contact_free_rim[k] -= by_inertia * drag
        bound.contact_free_vx[k] += by_mass * orbit * bound.tangent_x[k]
        bound.contact_free_vy[k] += by_mass * orbit * bound.tangent_y[k]
    for k in range(work.row_ends[work.row_ends.size - 1]):
        work.force_of_free[CAGE + bound.row[k], 2] += radius * bound.drag[k]


@piece
def add_bar_films(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Add the films to the lines of ``count`` bound rollers with their bars."""
    bound, bar, last = work.bound[0], work.bound[0].bar, state.position.shape[0] - 1
    if payload.any_broken:
        for k in range(work.row_ends[work.row_ends.size - 1]):
            i = bound.roller[k] - bound.row[k] * payload.free.shape[1]
            if not bar_at(payload, bound.row[k], i, bound.bar_film[k] > 0.0):
                bound.bar_film[k] = 0.0
    first_x, first_y = state.position[CAGE, 0], state.position[CAGE, 1]
    second_x, second_y = state.position[last, 0], state.position[last, 1]
    for k in range(count):
        second, film, side = bound.second_row[k] > 0.0, bound.bar_film[k], bar.side[k]
        damping = abs(film) if side * film >= 0.0 else 0.0
        bar.force_slope[k] += damping
        bar.damping[k] += damping
        # A roller that touches no bar has no side; that the lever ends at its centre does not matter to a force along the tangent.
        bar.lever_x[k] = bar.lever_x[k] if side != 0.0 else bound.x[k] - (second_x if second else first_x)
        bar.lever_y[k] = bar.lever_y[k] if side != 0.0 else bound.y[k] - (second_y if second else first_y)


@piece
def write_land_films(payload: Payload, state: State, work: Workspace) -> None:
    """Write how the oil of its lands acts on each cage."""
    film, law = work.land_film, payload.lubrication
    for row in range(payload.free.shape[0]):
        dx, dy = state.position[CAGE + row, 0] - state.position[OUTER, 0], state.position[CAGE + row, 1] - state.position[OUTER, 1]
        distance = max(math.sqrt(dx * dx + dy * dy), CONCENTRIC)
        film[row, NORMAL_X], film[row, NORMAL_Y] = dx / distance, dy / distance
        film[row, DAMPING] = land_damping(law, distance, payload.land_clearance, payload.land_radius)
        film[row, TORQUE] = land_torque(law, payload.land_clearance, payload.land_radius)
        film[row, FORCE] = film[row, DAMPING] * moving_out(work, row)


@piece
def moving_out(work: Workspace, row: int) -> float:
    """Return the speed of a cage away from its lands' centre at the present mean velocities [m/s]."""
    film, mean = work.land_film, work.mean_velocity
    vx, vy = mean[CAGE + row, 0] - mean[OUTER, 0], mean[CAGE + row, 1] - mean[OUTER, 1]
    speed: float = vx * film[row, NORMAL_X] + vy * film[row, NORMAL_Y]
    return speed


@piece
def add_land_films(payload: Payload, work: Workspace) -> None:
    """Add the forces of the lands' oil at the present mean velocities to those on cages and outer ring."""
    film, forces = work.land_film, work.force_of_bound
    for row in range(payload.free.shape[0]):
        # As at a land that is touched: the mean velocities result from the force of the last sweep.
        feedback = 0.5 * payload.step * film[row, DAMPING] * (1.0 / payload.train_mass[row] + 1.0 / payload.outer_mass)
        force = (film[row, DAMPING] * moving_out(work, row) + feedback * film[row, FORCE]) / (1.0 + feedback)
        film[row, FORCE] = force
        forces[CAGE + row, 0] -= force * film[row, NORMAL_X]
        forces[CAGE + row, 1] -= force * film[row, NORMAL_Y]
        forces[CAGE + row, 2] -= film[row, TORQUE] * work.mean_velocity[CAGE + row, 2]
        forces[OUTER, 0] += force * film[row, NORMAL_X]
        forces[OUTER, 1] += force * film[row, NORMAL_Y]


@piece
def store_land_films(payload: Payload, state: State, work: Workspace) -> None:
    """Book the losses in the oil of the lands."""
    for row in range(payload.free.shape[0]):
        turn = work.mean_velocity[CAGE + row, 2]
        squeezed = payload.step * work.land_film[row, FORCE] * moving_out(work, row)
        sheared = payload.step * work.land_film[row, TORQUE] * turn * turn
        state.account[LOSS] += squeezed
        state.account[FRICTION] += sheared
        state.land[0].loss[row] += squeezed + sheared
