"""From the kernels' state to what is published of it: the bodies' states."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.block import Floats, States
from dcrb_ros.core import lanes as at
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.state import State


def wrapped(angle: Floats) -> Floats:
    """Return angles [rad] wrapped to (-pi, pi]."""
    return math.pi - np.mod(math.pi - angle, 2.0 * math.pi)


def place_pinned_rollers(payload: Payload, state: State) -> None:
    """Write position and velocity of the pinned rollers, which their cages carry."""
    if payload.all_free:
        return
    cage, velocity = state.cage_position, state.cage_velocity
    cosine, sine = np.cos(cage[:, 2, None]), np.sin(cage[:, 2, None])
    tx, ty, free = payload.pocket_tangent[..., 0], payload.pocket_tangent[..., 1], payload.free
    # A pocket lies a quarter turn behind its tangent.
    arm_x, arm_y = payload.pitch_radius * (sine * tx + cosine * ty), payload.pitch_radius * (sine * ty - cosine * tx)
    carried = (
        (at.X, cage[:, 0, None] + arm_x),
        (at.Y, cage[:, 1, None] + arm_y),
        (at.VX, velocity[:, 0, None] - velocity[:, 2, None] * arm_y),
        (at.VY, velocity[:, 1, None] + velocity[:, 2, None] * arm_x),
    )
    for field, value in carried:
        state.lanes[field : field + free.size][~free.ravel()] = value[~free]


def observe(payload: Payload, state: State, time_ns: int) -> States:
    """Return the states of all bodies at ``time_ns``."""
    place_pinned_rollers(payload, state)
    rows, count = len(payload.free), payload.free.size
    x, y, vx, vy, spin = state.lanes[: 5 * at.LANES].reshape(5, at.LANES)[:, :count]

    def of(field: int) -> Floats:
        return state.lanes[field : field + count]

    found = np.zeros((9, count + rows + 1))
    rollers, cages, ring = found[:, :count], found[:, count:-1], found[:, -1]
    (outer_x, outer_y), (inner_x, inner_y), (inner_vx, inner_vy) = state.outer_position, state.inner_position, state.inner_velocity
    turning, tangent = state.cage_velocity[:, 2], payload.pocket_tangent[:, 0]
    nx, ny = x - inner_x, y - inner_y
    distance = np.hypot(nx, ny)
    nx, ny = nx / distance, ny / distance
    push, hold = of(at.INNER_FORCE), of(at.INNER_FRICTION)

    rollers[0], cages[0] = np.arctan2(x - outer_x, outer_y - y), np.arctan2(tangent[:, 1], tangent[:, 0]) + state.cage_position[:, 2]
    rollers[1], cages[1] = spin, turning
    rollers[2], rollers[3] = push, of(at.OUTER_FORCE)
    # At the inner raceway of every roller, touching or not.
    rollers[4] = (vy - inner_vy) * nx - (vx - inner_vx) * ny - spin * payload.roller_radius - state.shaft[1] * payload.inner_raceway_radius
    rollers[5], rollers[6] = hold, payload.roller_radius * (hold - of(at.OUTER_FRICTION))
    rollers[7] = spin - np.repeat(turning, count // rows)
    rollers[8], cages[8] = of(at.BAR_FORCE), state.land_force
    ring[:3] = state.shaft[0], state.shaft[1], push.sum()
    return States(
        time_ns=time_ns,
        azimuth=wrapped(found[0]),
        speed=found[1],
        inner_force=found[2],
        outer_force=found[3],
        slip=found[4],
        friction=found[5],
        torque=found[6],
        relative_speed=found[7],
        bar_force=found[8],
        cage_offset=state.cage_position[:, :2] - state.outer_position,
        inner_ring_force=(float(-(push @ nx) - hold @ ny), float(hold @ nx - push @ ny)),
    )
