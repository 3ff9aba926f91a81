"""Contact of two rollers with each other where the bar between them is broken (Fig. 5a of Fan et al. 2025)."""

from __future__ import annotations

import math

from dcrb_ros.core import lanes as at
from dcrb_ros.core.contact import loss_coefficient, normal_force
from dcrb_ros.core.friction import bristle_after, friction_line
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import Floats, Payload
from dcrb_ros.core.state import FRICTION, LOSS, State


@piece
def predicted(lanes: Floats, c: int) -> tuple[float, float, float]:
    """Return the mean velocity of the roller in lane ``c`` over the coming step [m/s, m/s, rad/s]."""
    vx, vy = lanes[at.VX + c] + 0.5 * lanes[at.CHANGE_X + c], lanes[at.VY + c] + 0.5 * lanes[at.CHANGE_Y + c]
    return vx, vy, lanes[at.SPIN + c] + 0.5 * lanes[at.CHANGE_SPIN + c]


@piece
def touch_neighbours(payload: Payload, state: State, external: Floats, row: int, i: int, j: int) -> None:
    """Add the contact of rollers ``i`` and ``j`` to the forces on both, at their predicted velocities."""
    lanes, first = state.lanes, row * payload.free.shape[1]
    dx, dy = lanes[at.X + first + i] - lanes[at.X + first + j], lanes[at.Y + first + i] - lanes[at.Y + first + j]
    distance = math.sqrt(dx * dx + dy * dy)
    penetration = 2.0 * payload.roller_radius - distance
    if penetration <= 0.0:
        state.next_force[row, i] = state.next_bristle[row, i] = 0.0
        return
    nx, ny = dx / distance, dy / distance
    own, other = predicted(lanes, first + i), predicted(lanes, first + j)
    vx, vy = own[0] - other[0], own[1] - other[1]
    rate = -(vx * nx + vy * ny)
    slip = vy * nx - vx * ny - payload.roller_radius * (own[2] + other[2])
    force, stiffness = normal_force(penetration, payload.roller_scale, payload)
    damping = loss_coefficient(force, stiffness * payload.loss_time + payload.contact_damping, rate)
    normal = force + damping * rate
    constant, slope, relaxation, phi = friction_line(
        slip, state.next_bristle[row, i], payload.kinetic_coefficient, payload.static_coefficient, 0.0, payload
    )
    friction = normal * (constant + slope * slip)
    fx, fy = normal * nx + friction * ny, normal * ny - friction * nx
    for roller, sign in ((i, 1.0), (j, -1.0)):
        external[row, roller, 0] += sign * fx
        external[row, roller, 1] += sign * fy
        external[row, roller, 2] += friction
    state.next_force[row, i] = normal
    state.next_bristle[row, i] = bristle_after(state.next_bristle[row, i], slip, relaxation, phi, payload.step)
    state.account[FRICTION] += payload.step * friction * slip
    state.account[LOSS] += payload.step * damping * rate * rate


@piece
def add_neighbours(payload: Payload, state: State, external: Floats) -> None:
    """Write the forces that rollers exert on each other across broken bars."""
    for k in range(payload.gaps.shape[0]):
        row, i, j = payload.gaps[k, 0], payload.gaps[k, 1], payload.gaps[k, 2]
        for part in range(3):
            external[row, i, part] = external[row, j, part] = 0.0
    for k in range(payload.gaps.shape[0]):
        touch_neighbours(payload, state, external, payload.gaps[k, 0], payload.gaps[k, 1], payload.gaps[k, 2])
