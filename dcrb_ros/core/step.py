"""The time loop: drift half a step, forces at the midpoint, implicit velocity update, drift half a step.

One force evaluation per step, second order. Normal forces are explicit with a mass correction, their loss, the housing's
damping and the friction are linearly implicit at the mean velocity, so that gross sliding (bristle rates of 2e7 1/s)
needs no shorter step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from dcrb_ros.core.contact import johnson_force, loss_coefficient
from dcrb_ros.core.equations import (
    CAGE,
    INNER,
    OUTER,
    UNKNOWNS,
    WIDTH,
    add_contacts,
    along,
    clear,
    eliminate,
    fill_direction,
    substitute,
)
from dcrb_ros.core.friction import bristle_after, friction_line
from dcrb_ros.core.payload import Floats, Payload
from dcrb_ros.core.raceway import notch_under
from dcrb_ros.core.state import State

DISPERSION = 1.0 / 12.0
"""Share h^2 k/12 of a stiffness k that is added to the mass: leapfrog then has the right frequency to fourth order."""


class Workspace(NamedTuple):
    """Scratch arrays of the time loop; nothing in them outlives a step."""

    blocks: Floats
    """One block of equations per row, shape (rows, UNKNOWNS, WIDTH)."""
    rings: Floats
    """The rings' equations, shape (UNKNOWNS, WIDTH)."""
    before: Floats
    """Velocities before the step, shape (rows, WIDTH) [m/s]."""
    mean: Floats
    """Mean velocities over the step, shape (rows, WIDTH) [m/s]."""
    slip_inner: Floats
    """Direction rows of the slip at the inner raceway, shape (rows, rollers, WIDTH)."""
    slip_outer: Floats
    normal_inner: Floats
    """Direction rows of the normal at the inner raceway, shape (rows, rollers, WIDTH)."""
    normal_outer: Floats
    laws: Floats
    """What the roller's friction needs after the solve, shape (rows, rollers, LAW_FIELDS)."""


CONSTANT_I, SLOPE_I, RATE_I, PHI_I, CONSTANT_O, SLOPE_O, RATE_O, PHI_O = range(8)
LAW_FIELDS = 8


def workspace(rows: int, rollers: int) -> Workspace:
    """Return scratch arrays for ``rows`` rows of ``rollers`` rollers."""
    directions = [np.zeros((rows, rollers, WIDTH)) for _ in range(4)]
    return Workspace(
        np.zeros((rows, UNKNOWNS, WIDTH)),
        np.zeros((UNKNOWNS, WIDTH)),
        np.zeros((rows, WIDTH)),
        np.zeros((rows, WIDTH)),
        *directions,
        np.zeros((rows, rollers, LAW_FIELDS)),
    )


@njit(cache=True, forceinline=True)
def ramped(value: float, target: float, most: float) -> float:
    """Return ``value`` moved towards ``target`` by ``most`` at most."""
    return value + min(max(target - value, -most), most)


@njit(cache=True, forceinline=True)
def drift(state: State, time: float) -> None:
    """Move rings and cages with their velocities for ``time`` [s]."""
    for axis in range(2):
        state.outer_position[axis] += time * state.outer_velocity[axis]
        state.inner_position[axis] += time * state.inner_velocity[axis]
    for row in range(state.cage_position.shape[0]):
        for axis in range(3):
            state.cage_position[row, axis] += time * state.cage_velocity[row, axis]


@njit(cache=True, forceinline=True)
def gather(payload: Payload, state: State, work: Workspace, row: int) -> None:
    """Copy the velocities that a row's equations are about into the workspace."""
    before = work.before[row]
    before[OUTER], before[OUTER + 1] = state.outer_velocity[0], state.outer_velocity[1]
    before[INNER], before[INNER + 1] = state.inner_velocity[0], state.inner_velocity[1]
    before[CAGE], before[CAGE + 1] = state.cage_velocity[row, 0], state.cage_velocity[row, 1]
    before[CAGE + 2] = state.cage_velocity[row, 2] * payload.pitch_radius


@njit(cache=True, forceinline=True)
def begin_cage(payload: Payload, block: Floats, before: Floats) -> None:
    """Start a row's equations with the inertia and weight of the cage and its pinned rollers."""
    clear(block)
    mass = payload.train_mass
    rim_mass = payload.train_inertia / (payload.pitch_radius * payload.pitch_radius)
    for k, m in ((CAGE, mass), (CAGE + 1, mass), (CAGE + 2, rim_mass)):
        block[k, k] = 2.0 * m
        block[k, UNKNOWNS] = 2.0 * m * before[k]
    block[CAGE + 1, UNKNOWNS] -= payload.step * mass * payload.gravity


@njit(cache=True, forceinline=True)
def begin_rings(payload: Payload, state: State, rings: Floats) -> None:
    """Start the rings' equations with inertia, weight, load and the housing's spring and damper."""
    clear(rings)
    h, stiffness = payload.step, payload.housing_stiffness
    outer_inertia = 2.0 * (payload.outer_ring_mass + DISPERSION * h * h * stiffness)
    for axis in range(2):
        o, i = OUTER + axis, INNER + axis
        rings[o, o] = outer_inertia + h * payload.housing_damping
        rings[o, UNKNOWNS] = outer_inertia * state.outer_velocity[axis] - h * stiffness * state.outer_position[axis]
        rings[i, i] = 2.0 * payload.inner_ring_mass
        rings[i, UNKNOWNS] = 2.0 * payload.inner_ring_mass * state.inner_velocity[axis] + h * state.load[axis]
    rings[OUTER + 1, UNKNOWNS] -= h * payload.outer_ring_mass * payload.gravity
    rings[INNER + 1, UNKNOWNS] -= h * payload.inner_ring_mass * payload.gravity


@njit(cache=True, forceinline=True)
def open_roller(state: State, row: int, i: int) -> None:
    """Forget the contacts of a roller that touches neither raceway."""
    state.inner_force[row, i] = state.outer_force[row, i] = 0.0
    state.inner_friction[row, i] = state.outer_friction[row, i] = 0.0
    state.inner_bristle[row, i] = state.outer_bristle[row, i] = 0.0


@njit(cache=True, forceinline=True)
def contact_normal(
    penetration: float, sink_speed: float, rate: float, modulus: float, scale: float, payload: Payload
) -> tuple[float, float, float, float]:
    """Return force [N], constant part [N], damping [N s/m] and mass correction [kg] of a closed normal contact.

    ``rate`` is the speed of approach of the bodies, ``sink_speed`` the speed at which the raceway falls away below the
    roller [m/s]; the damping acts on both, the constant part leaves out the share of ``rate``.
    """
    force, stiffness = johnson_force(penetration, modulus, scale)
    damping = loss_coefficient(force, stiffness, payload.loss_time, rate - sink_speed)
    constant = force - damping * sink_speed
    return constant + damping * rate, constant, damping, DISPERSION * payload.step * payload.step * stiffness


@njit(cache=True, forceinline=True)
def add_roller(payload: Payload, state: State, work: Workspace, row: int, i: int, tx: float, ty: float) -> None:
    """Add roller ``i`` of a row to its equations if it touches a raceway; (tx, ty) is its pocket's tangent."""
    cage = state.cage_position[row]
    radius = payload.roller_radius
    x, y = cage[0] + payload.pitch_radius * ty, cage[1] - payload.pitch_radius * tx
    ix, iy = x - state.inner_position[0], y - state.inner_position[1]
    ox, oy = x - state.outer_position[0], y - state.outer_position[1]
    inner_reach = payload.inner_raceway_radius + radius
    outer_reach = payload.outer_raceway_radius - radius
    inner_square, outer_square = ix * ix + iy * iy, ox * ox + oy * oy
    if inner_square >= inner_reach * inner_reach and outer_square <= outer_reach * outer_reach:
        open_roller(state, row, i)
        return

    h, spin = payload.step, state.spin[row, i]
    before, law = work.before[row], work.laws[row, i]
    slip_i, slip_o = work.slip_inner[row, i], work.slip_outer[row, i]
    normal_i, normal_o = work.normal_inner[row, i], work.normal_outer[row, i]
    shaft_slip = state.shaft[1] * payload.inner_raceway_radius

    force_i = constant_ni = damping_i = mass_i = 0.0
    if inner_square < inner_reach * inner_reach:
        distance = math.sqrt(inner_square)
        nx, ny = ix / distance, iy / distance
        fill_direction(slip_i, INNER, -ny, nx, nx * ty - ny * tx)
        fill_direction(normal_i, INNER, nx, ny, nx * tx + ny * ty)
        depth, slope = notch_under(
            payload.inner_notches, True, row, nx, ny, state.shaft[0], payload.inner_raceway_radius, radius
        )
        penetration = inner_reach - distance - depth
        if penetration > 0.0:
            turn = along(slip_i, before) / distance - state.shaft[1]
            force_i, constant_ni, damping_i, mass_i = contact_normal(
                penetration, slope * turn, -along(normal_i, before), payload.contact_modulus, payload.inner_scale, payload
            )
    force_o = constant_no = damping_o = mass_o = 0.0
    if outer_square > outer_reach * outer_reach:
        distance = math.sqrt(outer_square)
        nx, ny = ox / distance, oy / distance
        fill_direction(slip_o, OUTER, -ny, nx, nx * ty - ny * tx)
        fill_direction(normal_o, OUTER, nx, ny, nx * tx + ny * ty)
        depth, slope = notch_under(payload.outer_notches, False, row, nx, ny, 0.0, payload.outer_raceway_radius, radius)
        penetration = distance - outer_reach - depth
        if penetration > 0.0:
            turn = along(slip_o, before) / distance
            force_o, constant_no, damping_o, mass_o = contact_normal(
                penetration, slope * turn, along(normal_o, before), payload.contact_modulus, payload.outer_scale, payload
            )
    state.inner_force[row, i], state.outer_force[row, i] = force_i, force_o
    if force_i == 0.0 and force_o == 0.0:
        open_roller(state, row, i)
        return

    constant_i = slope_i = 0.0
    if force_i > 0.0:
        known = along(slip_i, before) - spin * radius - shaft_slip
        constant, slope, law[RATE_I], law[PHI_I] = friction_line(known, state.inner_bristle[row, i], payload)
        constant_i, slope_i = force_i * constant, force_i * slope
    else:
        state.inner_bristle[row, i] = 0.0
    constant_o = slope_o = 0.0
    if force_o > 0.0:
        known = along(slip_o, before) + spin * radius
        constant, slope, law[RATE_O], law[PHI_O] = friction_line(known, state.outer_bristle[row, i], payload)
        constant_o, slope_o = force_o * constant, force_o * slope
    else:
        state.outer_bristle[row, i] = 0.0
    law[CONSTANT_I], law[SLOPE_I], law[CONSTANT_O], law[SLOPE_O] = constant_i, slope_i, constant_o, slope_o

    # The roller's spin is eliminated here: its mean follows from the two slips of the roller's centre.
    inertia = 2.0 * payload.roller_inertia + h * radius * radius * (slope_i + slope_o)
    at_rest = mean_spin(payload, spin, law, -shaft_slip, 0.0)
    coupling = h * h * radius * radius / inertia
    push_i = constant_i + slope_i * (-shaft_slip - radius * at_rest)
    push_o = constant_o + slope_o * radius * at_rest
    add_contacts(
        work.blocks[row],
        slip_i,
        slip_o,
        normal_i,
        normal_o,
        h * slope_i - coupling * slope_i * slope_i,
        h * slope_o - coupling * slope_o * slope_o,
        coupling * slope_i * slope_o,
        h * damping_i + 2.0 * mass_i,
        h * damping_o + 2.0 * mass_o,
        -h * push_i,
        -h * push_o,
        h * constant_ni + 2.0 * mass_i * along(normal_i, before),
        -h * constant_no + 2.0 * mass_o * along(normal_o, before),
    )


@njit(cache=True, forceinline=True)
def mean_spin(payload: Payload, spin: float, law: Floats, centre_i: float, centre_o: float) -> float:
    """Return the mean spin [rad/s] over the step, given the slips [m/s] that a roller without spin would have."""
    h, radius = payload.step, payload.roller_radius
    inertia = 2.0 * payload.roller_inertia + h * radius * radius * (law[SLOPE_I] + law[SLOPE_O])
    torque = law[CONSTANT_I] + law[SLOPE_I] * centre_i - law[CONSTANT_O] - law[SLOPE_O] * centre_o
    return (2.0 * payload.roller_inertia * spin + h * radius * torque) / inertia


@njit(cache=True, forceinline=True)
def finish_roller(payload: Payload, state: State, work: Workspace, row: int, i: int) -> None:
    """Update spin, bristles and friction of a roller in contact from the solved velocities."""
    h, radius, law, mean = payload.step, payload.roller_radius, work.laws[row, i], work.mean[row]
    closed_i, closed_o = state.inner_force[row, i] > 0.0, state.outer_force[row, i] > 0.0
    centre_i = along(work.slip_inner[row, i], mean) - state.shaft[1] * payload.inner_raceway_radius if closed_i else 0.0
    centre_o = along(work.slip_outer[row, i], mean) if closed_o else 0.0
    spin = mean_spin(payload, state.spin[row, i], law, centre_i, centre_o)
    if closed_i:
        slip = centre_i - spin * radius
        state.inner_slip[row, i] = slip
        state.inner_friction[row, i] = law[CONSTANT_I] + law[SLOPE_I] * slip
        state.inner_bristle[row, i] = bristle_after(state.inner_bristle[row, i], slip, law[RATE_I], law[PHI_I], h)
    else:
        state.inner_friction[row, i] = 0.0
    if closed_o:
        slip = centre_o + spin * radius
        state.outer_slip[row, i] = slip
        state.outer_friction[row, i] = law[CONSTANT_O] + law[SLOPE_O] * slip
        state.outer_bristle[row, i] = bristle_after(state.outer_bristle[row, i], slip, law[RATE_O], law[PHI_O], h)
    else:
        state.outer_friction[row, i] = 0.0
    state.spin[row, i] = 2.0 * spin - state.spin[row, i]


@njit(cache=True, forceinline=True)
def add_row(payload: Payload, state: State, work: Workspace, row: int) -> None:
    """Assemble a row's equations, eliminate its cage and add what is left to the rings."""
    gather(payload, state, work, row)
    block = work.blocks[row]
    begin_cage(payload, block, work.before[row])
    angle = state.cage_position[row, 2]
    cosine, sine = math.cos(angle), math.sin(angle)
    for i in range(payload.pocket_tangent.shape[1]):
        px, py = payload.pocket_tangent[row, i, 0], payload.pocket_tangent[row, i, 1]
        add_roller(payload, state, work, row, i, cosine * px - sine * py, sine * px + cosine * py)
    eliminate(block, CAGE, UNKNOWNS)
    for k in range(CAGE):
        for j in range(CAGE):
            work.rings[k, j] += block[k, j]
        work.rings[k, UNKNOWNS] += block[k, UNKNOWNS]


@njit(cache=True, forceinline=True)
def finish_row(payload: Payload, state: State, work: Workspace, row: int) -> None:
    """Solve for a row's cage and update its velocity and its rollers."""
    mean = work.mean[row]
    for k in range(CAGE):
        mean[k] = work.mean[0, k]
    substitute(work.blocks[row], CAGE, UNKNOWNS, mean)
    state.cage_velocity[row, 0] = 2.0 * mean[CAGE] - state.cage_velocity[row, 0]
    state.cage_velocity[row, 1] = 2.0 * mean[CAGE + 1] - state.cage_velocity[row, 1]
    state.cage_velocity[row, 2] = 2.0 * mean[CAGE + 2] / payload.pitch_radius - state.cage_velocity[row, 2]
    for i in range(state.spin.shape[1]):
        before = state.spin[row, i]
        if state.inner_force[row, i] > 0.0 or state.outer_force[row, i] > 0.0:
            finish_roller(payload, state, work, row, i)
        state.spin_angle[row, i] += 0.5 * payload.step * (before + state.spin[row, i])


@njit(cache=True, forceinline=True)
def turn_shaft(payload: Payload, state: State, fraction: float) -> None:
    """Turn the inner ring by ``fraction`` of a step."""
    state.shaft[0] += fraction * payload.step * state.shaft[1]


@njit(cache=True, nogil=True)
def advance(payload: Payload, state: State, work: Workspace, acceleration: Floats, shaft_angle: Floats) -> None:
    """Advance the state by ``len(acceleration)`` steps.

    Writes the outer ring's mean acceleration in X and Y over each step, shape (steps, 2) [m/s^2], and the rotation of
    the inner ring at the middle of each step, shape (steps,) [rad].
    """
    h = payload.step
    rows = state.cage_position.shape[0]
    for n in range(acceleration.shape[0]):
        for axis in range(2):
            state.load[axis] = ramped(state.load[axis], state.target[1 + axis], payload.load_ramp * h)
        speed = state.shaft[1]
        after = ramped(speed, state.target[0], payload.speed_ramp * h)
        state.shaft[1] = 0.5 * (speed + after)
        drift(state, 0.5 * h)
        turn_shaft(payload, state, 0.5)
        begin_rings(payload, state, work.rings)
        for row in range(rows):
            add_row(payload, state, work, row)
        eliminate(work.rings, 1, CAGE)
        substitute(work.rings, 0, CAGE, work.mean[0])
        for row in range(rows):
            finish_row(payload, state, work, row)
        for axis in range(2):
            mean_outer, mean_inner = work.mean[0, OUTER + axis], work.mean[0, INNER + axis]
            acceleration[n, axis] = 2.0 * (mean_outer - state.outer_velocity[axis]) / h
            state.outer_velocity[axis] = 2.0 * mean_outer - state.outer_velocity[axis]
            state.inner_velocity[axis] = 2.0 * mean_inner - state.inner_velocity[axis]
        shaft_angle[n] = state.shaft[0]
        drift(state, 0.5 * h)
        turn_shaft(payload, state, 0.5)
        state.shaft[1] = after
