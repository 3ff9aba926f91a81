"""Contact of two rollers with each other where the bar between them is broken (Fig. 5a of Fan et al. 2025).

With a contact angle alpha two neighbours have the same distance from the shaft, and axes inclined to it by alpha. They touch at the
distance of their own diameter, 2 r = 2 r_R/cos(alpha), and press along the line between their centres, which lies in the plane. Their
surfaces slide across their axes: cos(alpha) of the friction force F_t acts in the plane, and the torque on the spin of the plane is
r_R F_t. So the slip, whose power F_t s is that of the forces in the plane, is

    s = v_t cos(alpha) - r_R (omega_i + omega_j)

with the velocity v_t of one centre relative to the other along the tangent; two rollers that turn with the plane as one body do not slip.
"""

from __future__ import annotations

import math

from dcrb_ros.core.contacts.force_line import damping_of
from dcrb_ros.core.jit import kernel, piece
from dcrb_ros.core.laws.calls import clear_memory, load_memory, normal_force, normal_update, store_memory, traction_line, traction_update
from dcrb_ros.core.laws.loss import loss_coefficient
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.layout.rollers import Rollers
from dcrb_ros.core.layout.state import FRICTION, LOSS, State
from dcrb_ros.core.payload import Payload


@piece
def predicted_velocity(rollers: Rollers, c: int) -> tuple[float, float, float]:
    """Return the mean velocity of roller ``c`` over the coming step [m/s, m/s, rad/s]."""
    vx, vy = rollers.vx[c] + 0.5 * rollers.change_vx[c], rollers.vy[c] + 0.5 * rollers.change_vy[c]
    return vx, vy, rollers.spin[c] + 0.5 * rollers.change_spin[c]


@kernel
def closing_rate(rate: float, force: float, damping: float, last: float, mobility: float) -> float:
    """Return the mean speed of penetration over a step [m/s], predicted as ``rate`` if the force ``last`` [N] of the last step went on.

    ``force`` is the elastic force [N], ``damping`` that of the contact [N s/m], ``mobility`` how much a force changes the mean speed, h/m
    for two rollers of mass m [m/(N s)]. The prediction is used up to mobility * damping = 1. Beyond, its loss would throw rollers
    apart faster than they met; the equation of the mean speed is solved instead (implicit midpoint rule).
    """
    share = mobility * damping
    return (rate + mobility * (last - force)) / (1.0 + share) if share > 1.0 else rate


@piece
def add_pair_contact(payload: Payload, state: State, pair_force: Floats, row: int, i: int, j: int) -> None:
    """Add the contact of rollers ``i`` and ``j`` of a row to the forces on both, at their predicted velocities."""
    rollers, first, share = state.rollers[0], row * payload.free.shape[1], payload.spin_share
    pair, k, h = rollers.pair, first + i, payload.step
    normal_law, traction_law = payload.normal_law, payload.traction_law
    dx, dy = rollers.x[first + i] - rollers.x[first + j], rollers.y[first + i] - rollers.y[first + j]
    distance = math.sqrt(dx * dx + dy * dy)
    penetration = 2.0 * payload.roller_radius / share - distance
    if penetration <= 0.0:
        pair.force[k] = 0.0
        clear_memory(traction_law, pair.traction, k)
        clear_memory(normal_law, pair.normal, k)
        return
    nx, ny = dx / distance, dy / distance
    across_x, across_y = share * nx, share * ny
    velocity, other = predicted_velocity(rollers, first + i), predicted_velocity(rollers, first + j)
    vx, vy = velocity[0] - other[0], velocity[1] - other[1]
    rate = -(vx * nx + vy * ny)
    slip = vy * across_x - vx * across_y - payload.roller_radius * (velocity[2] + other[2])
    memory = load_memory(normal_law, pair.normal, k)
    force, stiffness = normal_force(normal_law, memory, penetration, payload.pair)
    damping = damping_of(payload, memory, payload.pair, penetration - 0.5 * h * rate, h * rate, force, stiffness, 1.0)
    rate = closing_rate(rate, force, damping, pair.force[k], h / payload.roller_mass)
    damping = loss_coefficient(force, damping, rate)
    normal = force + damping * rate
    store_memory(normal_law, pair.normal, k, normal_update(normal_law, memory, penetration, rate, h))
    slipping = load_memory(traction_law, pair.traction, k)
    offset, slope, kept = traction_line(traction_law, slipping, slip, None, normal, None, h)
    friction = normal * (offset + slope * slip)
    fx, fy = normal * nx + friction * across_y, normal * ny - friction * across_x
    for roller, sign in ((i, 1.0), (j, -1.0)):
        pair_force[row, roller, 0] += sign * fx
        pair_force[row, roller, 1] += sign * fy
        pair_force[row, roller, 2] += friction
    pair.force[k] = normal
    state.account[FRICTION] += h * friction * slip
    state.account[LOSS] += h * damping * rate * rate
    store_memory(traction_law, pair.traction, k, traction_update(traction_law, slipping, kept, slip, True, h))


@piece
def add_pair_contacts(payload: Payload, state: State, pair_force: Floats) -> None:
    """Write the forces that rollers exert on each other across broken bars."""
    for k in range(payload.gaps.shape[0]):
        row, i, j = payload.gaps[k, 0], payload.gaps[k, 1], payload.gaps[k, 2]
        for part in range(3):
            pair_force[row, i, part] = pair_force[row, j, part] = 0.0
    for k in range(payload.gaps.shape[0]):
        add_pair_contact(payload, state, pair_force, payload.gaps[k, 0], payload.gaps[k, 1], payload.gaps[k, 2])
