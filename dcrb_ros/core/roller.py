"""One roller over one step: where it touches, what it adds to its row's equations, its spin afterwards."""

from __future__ import annotations

import math

from dcrb_ros.core.contact import johnson_force, loss_coefficient
from dcrb_ros.core.equations import PUSH_I, PUSH_O, A, B, add_contact, add_coupling
from dcrb_ros.core.friction import bristle_after, friction_line
from dcrb_ros.core.jit import kernel
from dcrb_ros.core.payload import Floats, Notches, Payload
from dcrb_ros.core.raceway import notch_under
from dcrb_ros.core.state import State

DISPERSION = 1.0 / 12.0
"""Share h^2 k/12 of a stiffness k that is added to the mass: leapfrog then has the right frequency to fourth order."""

NORMAL_X, NORMAL_Y, RIM, CONSTANT, SLOPE, RATE, PHI = range(7)
OUTER_CONTACT = 7
ROLLER = 14
"""Fields of a contact record: the inner contact's seven, the outer contact's seven, the roller's index."""
RECORD = 15


@kernel
def normal_contact(
    distance: float,
    gap: float,
    approach: float,
    turn: float,
    nx: float,
    ny: float,
    notches: Notches,
    inner: bool,
    row: int,
    ring_angle: float,
    payload: Payload,
) -> tuple[float, float, float, float]:
    """Return normal force [N], its part free of the approach [N], damping [N s/m] and mass correction [kg].

    ``gap`` is the penetration of the smooth raceway with its sign turned, ``approach`` the speed [m/s] at which roller
    and ring come closer, ``turn`` the speed [rad/s] of the contact's azimuth over the ring.
    """
    raceway = payload.inner_raceway_radius if inner else payload.outer_raceway_radius
    scale = payload.inner_scale if inner else payload.outer_scale
    depth, slope = 0.0, 0.0
    if notches.row.size > 0:
        depth, slope = notch_under(notches, inner, row, nx, ny, ring_angle, raceway, payload.roller_radius)
    penetration = -gap - depth
    if penetration <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    sink_speed = slope * turn
    force, stiffness = johnson_force(penetration, payload.contact_modulus, scale)
    damping = loss_coefficient(force, stiffness, payload.loss_time, approach - sink_speed)
    constant = force - damping * sink_speed
    return constant + damping * approach, constant, damping, DISPERSION * payload.step * payload.step * stiffness


@kernel
def mean_spin(payload: Payload, spin: float, slope_i: float, slope_o: float, torque: float) -> float:
    """Return the mean spin [rad/s] over the step.

    ``torque`` is friction times lever over the radius [N], inner less outer, that a roller without spin would feel.
    """
    h, radius = payload.step, payload.roller_radius
    inertia = 2.0 * payload.roller_inertia + h * radius * radius * (slope_i + slope_o)
    return (2.0 * payload.roller_inertia * spin + h * radius * torque) / inertia


@kernel
def open_roller(state: State, row: int, i: int) -> None:
    """Forget the contacts of a roller that touches neither raceway."""
    state.inner_force[row, i] = state.outer_force[row, i] = 0.0
    state.inner_friction[row, i] = state.outer_friction[row, i] = 0.0
    state.inner_bristle[row, i] = state.outer_bristle[row, i] = 0.0


@kernel
def add_roller(
    payload: Payload,
    state: State,
    sums: Floats,
    records: Floats,
    k: int,
    row: int,
    i: int,
    x: float,
    y: float,
    tau_x: float,
    tau_y: float,
    rim_speed: float,
) -> bool:
    """Add roller ``i`` at (x, y) to its row's sums and write record ``k``; return whether it bears on a raceway.

    (tau_x, tau_y) is its pocket's tangent, ``rim_speed`` the cage's rim speed [m/s].
    """
    h, radius, spin = payload.step, payload.roller_radius, state.spin[row, i]
    vx, vy = state.cage_velocity[row, 0] + rim_speed * tau_x, state.cage_velocity[row, 1] + rim_speed * tau_y

    dx, dy = x - state.inner_position[0], y - state.inner_position[1]
    distance = math.sqrt(dx * dx + dy * dy)
    nx_i, ny_i = dx / distance, dy / distance
    rim_ni, rim_ti = nx_i * tau_x + ny_i * tau_y, nx_i * tau_y - ny_i * tau_x
    wx, wy = vx - state.inner_velocity[0], vy - state.inner_velocity[1]
    pass_i, part_i = wy * nx_i - wx * ny_i, wx * nx_i + wy * ny_i
    force_i, constant_ni, damping_i, mass_i = 0.0, 0.0, 0.0, 0.0
    gap = distance - payload.inner_raceway_radius - radius
    if gap < 0.0:
        force_i, constant_ni, damping_i, mass_i = normal_contact(
            distance,
            gap,
            -part_i,
            pass_i / distance - state.shaft[1],
            nx_i,
            ny_i,
            payload.inner_notches,
            True,
            row,
            state.shaft[0],
            payload,
        )

    dx, dy = x - state.outer_position[0], y - state.outer_position[1]
    distance = math.sqrt(dx * dx + dy * dy)
    nx_o, ny_o = dx / distance, dy / distance
    rim_no, rim_to = nx_o * tau_x + ny_o * tau_y, nx_o * tau_y - ny_o * tau_x
    wx, wy = vx - state.outer_velocity[0], vy - state.outer_velocity[1]
    pass_o, part_o = wy * nx_o - wx * ny_o, wx * nx_o + wy * ny_o
    force_o, constant_no, damping_o, mass_o = 0.0, 0.0, 0.0, 0.0
    gap = payload.outer_raceway_radius - radius - distance
    if gap < 0.0:
        force_o, constant_no, damping_o, mass_o = normal_contact(
            distance, gap, part_o, pass_o / distance, nx_o, ny_o, payload.outer_notches, False, row, 0.0, payload
        )
    if force_i == 0.0 and force_o == 0.0:
        open_roller(state, row, i)
        return False

    shaft_slip = state.shaft[1] * payload.inner_raceway_radius
    constant_i, slope_i, rate_i, phi_i = friction_line(pass_i - spin * radius - shaft_slip, state.inner_bristle[row, i], payload)
    constant_o, slope_o, rate_o, phi_o = friction_line(pass_o + spin * radius, state.outer_bristle[row, i], payload)
    constant_i, slope_i = constant_i * force_i, slope_i * force_i
    constant_o, slope_o = constant_o * force_o, slope_o * force_o

    at_rest = mean_spin(payload, spin, slope_i, slope_o, constant_i - slope_i * shaft_slip - constant_o)
    coupling = h * h * radius * radius / (2.0 * payload.roller_inertia + h * radius * radius * (slope_i + slope_o))
    add_contact(
        sums,
        A,
        PUSH_I,
        nx_i,
        ny_i,
        rim_ni,
        rim_ti,
        (
            h * slope_i - coupling * slope_i * slope_i,
            h * damping_i + 2.0 * mass_i,
            -h * (constant_i - slope_i * (shaft_slip + radius * at_rest)),
            h * constant_ni + 2.0 * mass_i * part_i,
        ),
    )
    add_contact(
        sums,
        B,
        PUSH_O,
        nx_o,
        ny_o,
        rim_no,
        rim_to,
        (
            h * slope_o - coupling * slope_o * slope_o,
            h * damping_o + 2.0 * mass_o,
            -h * (constant_o + slope_o * radius * at_rest),
            2.0 * mass_o * part_o - h * constant_no,
        ),
    )
    add_coupling(sums, coupling * slope_i * slope_o, -ny_i, nx_i, rim_ti, -ny_o, nx_o, rim_to)

    state.inner_force[row, i], state.outer_force[row, i] = force_i, force_o
    for j, value in enumerate((nx_i, ny_i, rim_ti, constant_i, slope_i, rate_i, phi_i)):
        records[k, j] = value
    for j, value in enumerate((nx_o, ny_o, rim_to, constant_o, slope_o, rate_o, phi_o)):
        records[k, OUTER_CONTACT + j] = value
    records[k, ROLLER] = i
    return True


@kernel
def finish_roller(
    payload: Payload,
    state: State,
    records: Floats,
    k: int,
    row: int,
    inner_x: float,
    inner_y: float,
    outer_x: float,
    outer_y: float,
    rim: float,
) -> None:
    """Update spin, bristles and friction of record ``k`` from the mean velocities of the cage against both rings."""
    h, radius, i = payload.step, payload.roller_radius, int(records[k, ROLLER])
    o = OUTER_CONTACT
    constant_i, slope_i, constant_o, slope_o = records[k, CONSTANT], records[k, SLOPE], records[k, o + CONSTANT], records[k, o + SLOPE]
    slip_i = inner_y * records[k, NORMAL_X] - inner_x * records[k, NORMAL_Y] + rim * records[k, RIM]
    slip_i -= state.shaft[1] * payload.inner_raceway_radius
    slip_o = outer_y * records[k, o + NORMAL_X] - outer_x * records[k, o + NORMAL_Y] + rim * records[k, o + RIM]
    spin = mean_spin(payload, state.spin[row, i], slope_i, slope_o, constant_i + slope_i * slip_i - constant_o - slope_o * slip_o)
    slip_i -= spin * radius
    slip_o += spin * radius
    state.inner_slip[row, i], state.outer_slip[row, i] = slip_i, slip_o
    state.inner_friction[row, i] = constant_i + slope_i * slip_i
    state.outer_friction[row, i] = constant_o + slope_o * slip_o
    if state.inner_force[row, i] > 0.0:
        state.inner_bristle[row, i] = bristle_after(state.inner_bristle[row, i], slip_i, records[k, RATE], records[k, PHI], h)
    else:
        state.inner_bristle[row, i] = 0.0
    if state.outer_force[row, i] > 0.0:
        state.outer_bristle[row, i] = bristle_after(state.outer_bristle[row, i], slip_o, records[k, o + RATE], records[k, o + PHI], h)
    else:
        state.outer_bristle[row, i] = 0.0
    state.spin[row, i] = 2.0 * spin - state.spin[row, i]
