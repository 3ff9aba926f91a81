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
from dcrb_ros.core.layout.cages import headings_of, of_cages, of_row
from dcrb_ros.core.layout.records import VECTOR
from dcrb_ros.core.layout.state import CAGE, FRICTION, LOSS, OUTER, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload, mobilities
from dcrb_ros.core.solver.classification import bar_at

NORMAL_X, NORMAL_Y, OUTWARDS, INWARDS, TORQUE, FORCE = range(6)
"""Columns of ``Workspace.land_film``: direction from the lands' centre to the cage's [-], damping of motion along and against it [N s/m],
torque over the speed of the cage [N m s], and radial force of the last sweep [N]."""
CONCENTRIC = 1e-15
"""Least distance of two centres, so that there is a direction from one to the other [m]."""


@piece
def write_spin_drag(payload: Payload, state: State, work: Workspace) -> None:
    """Write the drag of both bars on the spin of a group of rollers: the next group in every step."""
    rollers = state.rollers[0]
    size = (payload.free.size + GROUPS * VECTOR - 1) // (GROUPS * VECTOR) * VECTOR
    tick = state.tick[0]
    groups = range(GROUPS) if tick == 1 else range(tick % GROUPS, tick % GROUPS + 1)
    cages, headings = of_cages(state.position), headings_of(work.heading)
    for group in groups:
        first = np.uint64(group * size)
        for k in range(size):
            c = first + np.uint64(k)
            cosine, sine, _ = of_row(headings, rollers.second_row[c])
            cage_x, cage_y, _ = of_row(cages, rollers.second_row[c])
            px, py = rollers.pocket_tangent_x[c], rollers.pocket_tangent_y[c]
            ax, ay = rollers.x[c] - cage_x, rollers.y[c] - cage_y
            along, clearance = ax * (cosine * px - sine * py) + ay * (sine * px + cosine * py), rollers.pocket_clearance[c]
            drag = bar_shear(payload.lubrication, clearance - along) + bar_shear(payload.lubrication, clearance + along)
            rollers.spin_drag[c] = drag * rollers.free[c]


@piece
def drag_on_orbit(payload: Payload, turn: float) -> float:
    """Return the drag of the oil on each free roller along its orbit [N], where the cage has an angular speed [rad/s]."""
    speed = payload.pitch_radius * turn
    drag: float = -churning(payload.lubrication) * speed * abs(speed)
    return drag


@piece
def drag_bound(payload: Payload, work: Workspace, count: int) -> None:
    """Add the drag of the oil on ``count`` bound rollers to their velocities without contacts, and that on the cages to their forces."""
    bound, radius, cages = work.bound[0], payload.roller_radius, of_cages(work.mean_velocity)
    by_mass, by_inertia = mobilities(payload)
    for k in range(count):
        _, _, turn = of_row(cages, bound.second_row[k])
        orbit = bound.free[k] * drag_on_orbit(payload, turn)
        past = bound.predicted_rim[k] - radius * turn
        drag = bound.spin_drag[k] * past
        bound.drag[k] = drag
        bound.drag_power[k] = drag * past - orbit * payload.pitch_radius * turn
        bound.contact_free_rim[k] -= by_inertia * drag
        bound.contact_free_vx[k] += by_mass * orbit * bound.tangent_x[k]
        bound.contact_free_vy[k] += by_mass * orbit * bound.tangent_y[k]
    k = 0
    for row in range(payload.free.shape[0]):
        torque = work.force_of_free[CAGE + row, 2]
        while k < work.row_ends[row]:
            torque += radius * bound.drag[k]
            k += 1
        work.force_of_free[CAGE + row, 2] = torque


@piece
def add_bar_films(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Add the films to the lines of ``count`` bound rollers with their bars."""
    bound, bar, cages = work.bound[0], work.bound[0].bar, of_cages(state.position)
    if payload.any_broken:
        for k in range(work.row_ends[work.row_ends.size - 1]):
            i = bound.roller[k] - bound.row[k] * payload.free.shape[1]
            if not bar_at(payload, bound.row[k], i, bound.bar_film[k] > 0.0):
                bound.bar_film[k] = 0.0
    for k in range(count):
        (cage_x, cage_y, _), film, side = of_row(cages, bound.second_row[k]), bound.bar_film[k], bar.side[k]
        damping = abs(film) if side * film >= 0.0 else 0.0
        bar.force_slope[k] += damping
        bar.damping[k] += damping
        # A roller that touches no bar has no side; that the lever ends at its centre does not matter to a force along the tangent.
        bar.lever_x[k] = bar.lever_x[k] if side != 0.0 else bound.x[k] - cage_x
        bar.lever_y[k] = bar.lever_y[k] if side != 0.0 else bound.y[k] - cage_y


@piece
def write_land_films(payload: Payload, state: State, work: Workspace) -> None:
    """Write how the oil of its lands acts on each cage."""
    film, law = work.land_film, payload.lubrication
    for row in range(payload.free.shape[0]):
        dx, dy = state.position[CAGE + row, 0] - state.position[OUTER, 0], state.position[CAGE + row, 1] - state.position[OUTER, 1]
        distance = max(math.sqrt(dx * dx + dy * dy), CONCENTRIC)
        film[row, NORMAL_X], film[row, NORMAL_Y] = dx / distance, dy / distance
        film[row, OUTWARDS], film[row, INWARDS] = land_damping(law, distance, payload.land_clearance, payload.land_radius)
        film[row, TORQUE] = land_torque(law, payload.land_clearance, payload.land_radius)
        speed = moving_out(work, row)
        film[row, FORCE] = film[row, OUTWARDS if speed > 0.0 else INWARDS] * speed


@piece
def moving_out(work: Workspace, row: int) -> float:
    """Return the speed of a cage away from its lands' centre at the present mean velocities [m/s]."""
    film, mean = work.land_film, work.mean_velocity
    vx, vy = mean[CAGE + row, 0] - mean[OUTER, 0], mean[CAGE + row, 1] - mean[OUTER, 1]
    speed: float = vx * film[row, NORMAL_X] + vy * film[row, NORMAL_Y]
    return speed


@piece
def add_land_films(payload: Payload, work: Workspace) -> None:
    """Add the forces of the lands' oil from the last sweep to those on cages and outer ring."""
    film, forces = work.land_film, work.force_of_bound
    for row in range(payload.free.shape[0]):
        force = film[row, FORCE]
        forces[CAGE + row, 0] -= force * film[row, NORMAL_X]
        forces[CAGE + row, 1] -= force * film[row, NORMAL_Y]
        forces[CAGE + row, 2] -= film[row, TORQUE] * work.mean_velocity[CAGE + row, 2]
        forces[OUTER, 0] += force * film[row, NORMAL_X]
        forces[OUTER, 1] += force * film[row, NORMAL_Y]


@piece
def resist_cage(payload: Payload, work: Workspace, row: int, x: float, y: float) -> tuple[float, float]:
    """Solve for the force of the lands' oil implicitly; return the mean velocity of a cage that would be (x, y) under the last force.

    The oil is stiff against a light cage. Let v be its speed away from the lands' centre under the last force N, and
    mu = h (1/m_C + 1/m_O)/2. Without the oil the speed would be v + mu N, whose sign selects the damping d. The new force is
    d (v + mu N)/(1 + mu d). Its change acts at once on cage and outer ring; that on the turn of a cage whose centre of mass lies off its
    centre follows in the next sweep.
    """
    film, outer = work.land_film, work.mean_velocity[OUTER]
    by_cage, by_outer = 0.5 * payload.step * payload.train_inverse[row, 0], 0.5 * payload.step / payload.outer_mass
    speed = (x - outer[0]) * film[row, NORMAL_X] + (y - outer[1]) * film[row, NORMAL_Y]
    free = speed + (by_cage + by_outer) * film[row, FORCE]
    damping = film[row, OUTWARDS if free > 0.0 else INWARDS]
    change = damping * free / (1.0 + damping * (by_cage + by_outer)) - film[row, FORCE]
    film[row, FORCE] += change
    outer[0] += by_outer * change * film[row, NORMAL_X]
    outer[1] += by_outer * change * film[row, NORMAL_Y]
    return x - by_cage * change * film[row, NORMAL_X], y - by_cage * change * film[row, NORMAL_Y]


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
