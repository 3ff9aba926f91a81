"""Rollers that lie free on the outer raceway or touch nothing: most rollers in pockets.

Normal and tangent of the raceway are not coupled: each is a scalar equation that needs no other body. One pass of one loop therefore takes
a roller over the whole step, from its position to its new velocity, and only its state is read from memory and written to it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dcrb_ros.core.contacts.cage_films import drag_on_orbit
from dcrb_ros.core.contacts.free_line import ContactLine, Surroundings, contact_line, surroundings
from dcrb_ros.core.contacts.raceway import notch_depth
from dcrb_ros.core.jit import NO, piece
from dcrb_ros.core.laws.calls import (
    clear_memory,
    has_cage_oil,
    has_rolling_resistance,
    normal_update,
    scale_memory,
    store_memory,
    traction_update,
)
from dcrb_ros.core.layout.cages import Triple, of_row
from dcrb_ros.core.layout.state import CAGE, OUTER, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import SINK, Payload, mobilities
from dcrb_ros.core.solver.bound import push_share
from dcrb_ros.core.solver.classification import filled


class BarOil(NamedTuple):
    """Oil between a free roller and its cage."""

    arm_x: float
    """From the cage's centre to the roller's [m]."""
    arm_y: float
    turn: float
    """Angular speed of the cage [rad/s]."""
    bar_speed: float
    """Speed of the bar along the raceway, past the outer ring [m/s]."""
    film: float
    """Damping of the film at the bar [N s/m]."""
    past: float
    """Speed of the roller's surface past the bars [m/s]."""
    spin_drag: float
    """Drag on the roller's surface [N]."""
    orbit_drag: float
    """Drag on the roller along its orbit [N]."""


class FreeMotion(NamedTuple):
    """Mean velocity of a free roller past the outer ring over a step, and the forces that lead to it."""

    vx: float
    """[m/s]"""
    vy: float
    rim: float
    """Mean speed r_R omega_R of its surface [m/s]."""
    normal: float
    """Normal force at the raceway [N]."""
    friction: float
    """Friction there [N]."""
    bar_push: float
    """Force of the film on the bar, along the raceway [N]."""
    force_x: float
    """Force on the outer ring [N]."""
    force_y: float


@piece
def find_notches(payload: Payload, state: State, work: Workspace) -> None:
    """Write the depth of notches of the outer raceway or of their own under free rollers, and how fast it grows."""
    rollers, count = work.rollers[0], payload.free.shape[1]
    for c in range(filled(payload.free.size)):
        rollers.notch_depth[c] = rollers.sink_speed[c] = rollers.over_notch[c] = 0.0
    if payload.notch_law == SINK:
        reach, x, y = payload.outer_raceway_radius - payload.roller_radius, state.position[OUTER, 0], state.position[OUTER, 1]
        for k in range(payload.outer_notches.row.size):
            tx, ty = work.outer_notch_direction[k, 0], work.outer_notch_direction[k, 1]
            least = payload.outer_notches.nearness[k] * reach
            for c in range(payload.free.size):
                over = (rollers.x[c] - x) * tx + (rollers.y[c] - y) * ty > least
                rollers.over_notch[c] = 1.0 if over else rollers.over_notch[c]
    for k in range(payload.roller_notches.row.size):
        rollers.over_notch[payload.roller_notches.row[k] * count + payload.roller_notches.roller[k]] = 1.0
    for c in range(payload.free.size):
        if rollers.over_notch[c] > 0.0 and rollers.near_outer[c] > 0.0:
            write_notch_depth(payload, state, work, c)


@piece
def write_notch_depth(payload: Payload, state: State, work: Workspace, c: int) -> None:
    """Write the depth of the notches under a free roller that touches the outer raceway, and how fast it grows."""
    rollers, row = state.rollers[0], c // payload.free.shape[1]
    dx, dy = rollers.x[c] - state.position[OUTER, 0], rollers.y[c] - state.position[OUTER, 1]
    distance = math.sqrt(dx * dx + dy * dy)
    nx, ny = dx / distance, dy / distance
    vx = rollers.vx[c] + 0.5 * rollers.change_vx[c] - work.mean_velocity[OUTER, 0]
    vy = rollers.vy[c] + 0.5 * rollers.change_vy[c] - work.mean_velocity[OUTER, 1]
    orbit, spin = (vy * nx - vx * ny) / distance, rollers.spin[c] + 0.5 * rollers.change_spin[c]
    depth, sink = notch_depth(payload, state, work, row, c - row * payload.free.shape[1], nx, ny, orbit, spin, NO)
    work.rollers[0].notch_depth[c], work.rollers[0].sink_speed[c] = depth, sink


@piece
def bar_oil(payload: Payload, state: State, work: Workspace, around: Surroundings, line: ContactLine, spin: float, c: int) -> BarOil:
    """Return the oil between a free roller of a spin [rad/s] and its cage."""
    rollers, nx, ny = state.rollers[0], line.nx, line.ny
    centre_x, centre_y, _ = of_row(around.cages, rollers.second_row[c])
    cage_vx, cage_vy, turn = of_row(around.cage_motion, rollers.second_row[c])
    arm_x, arm_y = rollers.x[c] - centre_x, rollers.y[c] - centre_y
    bar_speed = (cage_vy - around.mean[1] + turn * arm_x) * nx - (cage_vx - around.mean[0] - turn * arm_y) * ny
    past = payload.roller_radius * (spin + 0.5 * rollers.change_spin[c] - turn)
    film = abs(work.rollers[0].bar_film[c])
    return BarOil(arm_x, arm_y, turn, bar_speed, film, past, rollers.spin_drag[c] * past, drag_on_orbit(payload, turn))


@piece
def solve_free(payload: Payload, around: Surroundings, line: ContactLine, oil: BarOil, old: Triple) -> FreeMotion:
    """Return the mean velocity of a free roller; ``old`` is its velocity [m/s] and spin [rad/s] before the step.

    The film at a bar acts along the raceway, a linear force in the scalar equation there.
    """
    nx, ny, push = line.nx, line.ny, push_share(payload, around.site)
    by_mass, by_inertia = mobilities(payload)
    fall = by_mass * payload.roller_mass * payload.gravity
    vx, vy, rim = old[0] - around.mean[0], old[1] - fall - around.mean[1], payload.roller_radius * old[2]
    if has_rolling_resistance(around.site.film):
        vx, vy = vx + by_mass * push * line.resistance * ny, vy - by_mass * push * line.resistance * nx
        rim += by_inertia * line.resistance
    if has_cage_oil(payload.lubrication):
        rim -= by_inertia * oil.spin_drag
        vx, vy = vx - by_mass * oil.orbit_drag * ny, vy + by_mass * oil.orbit_drag * nx
    along, mobility = vy * nx - vx * ny, by_mass
    if has_cage_oil(payload.lubrication):
        mobility = by_mass / (1.0 + by_mass * oil.film)
        along -= mobility * oil.film * (along - oil.bar_speed)
    normal = (line.force_offset + line.force_slope * (vx * nx + vy * ny)) / (1.0 + by_mass * line.force_slope)
    friction = (line.friction_offset + line.friction_slope * (along + rim)) / (1.0 + (mobility + by_inertia) * line.friction_slope)
    bar_push = 0.0
    tangential = friction
    if has_cage_oil(payload.lubrication):
        bar_push = oil.film * (along - mobility * friction - oil.bar_speed)
        tangential += bar_push
    fx, fy = normal * nx - tangential * ny, normal * ny + tangential * nx
    vx, vy, rim = vx - by_mass * fx, vy - by_mass * fy, rim - by_inertia * friction
    if has_cage_oil(payload.lubrication):
        fx, fy = fx + bar_push * ny, fy - bar_push * nx
    if has_rolling_resistance(around.site.film):
        fx, fy = fx - push * line.resistance * ny, fy + push * line.resistance * nx
    return FreeMotion(vx, vy, rim, normal, friction, bar_push, fx, fy)


@piece
def store_oil(payload: Payload, state: State, work: Workspace, line: ContactLine, oil: BarOil, motion: FreeMotion, c: int) -> None:
    """Write the force of the oil on the cage, and book its losses, unless the roller is bound."""
    rollers, step, nx, ny, push = state.rollers[0], work.rollers[0], line.nx, line.ny, motion.bar_push
    unbound = 1.0 - step.bound[c]
    step.force_on_cage_x[c], step.force_on_cage_y[c] = -unbound * push * ny, unbound * push * nx
    step.torque_on_cage[c] = unbound * (push * (oil.arm_x * nx + oil.arm_y * ny) + payload.roller_radius * oil.spin_drag)
    drag_loss = payload.step * unbound * (oil.spin_drag * oil.past - oil.orbit_drag * payload.pitch_radius * oil.turn)
    rollers.friction_loss[c] += drag_loss
    rollers.drag_loss[c] += drag_loss
    rollers.bar_friction_loss[c] += drag_loss
    film_loss = payload.step * unbound * push * (motion.vy * nx - motion.vx * ny - oil.bar_speed)
    rollers.contact_loss[c] += film_loss
    rollers.bar_contact_loss[c] += film_loss


@piece
def store_free(
    payload: Payload, state: State, work: Workspace, around: Surroundings, line: ContactLine, motion: FreeMotion, old: Triple, c: int
) -> None:
    """Write velocity, contact and losses of a free roller after the step, and its force on the outer ring, unless it is bound."""
    rollers, step, outer, h, site = state.rollers[0], work.rollers[0], state.rollers[0].outer, payload.step, around.site
    bound = step.bound[c]
    along = motion.vy * line.nx - motion.vx * line.ny
    slip, closing = along + motion.rim, motion.vx * line.nx + motion.vy * line.ny - line.sink
    step.force_on_outer_x[c], step.force_on_outer_y[c] = (1.0 - bound) * motion.force_x, (1.0 - bound) * motion.force_y
    change_vx, change_vy = 2.0 * (motion.vx + around.mean[0] - old[0]), 2.0 * (motion.vy + around.mean[1] - old[1])
    change_spin = 2.0 * (motion.rim - payload.roller_radius * old[2]) * (1.0 / payload.roller_radius)
    rollers.change_vx[c], rollers.change_vy[c], rollers.change_spin[c] = change_vx, change_vy, change_spin
    rollers.vx[c], rollers.vy[c], rollers.spin[c] = old[0] + change_vx, old[1] + change_vy, old[2] + change_spin
    outer.force[c] = max(line.expected_force + line.damping * (closing - line.expected_closing), 0.0)
    outer.friction[c], outer.slip[c] = motion.friction, slip
    traction_memory = traction_update(payload.traction_law, line.traction_memory, line.kept, slip, line.expected_force > 0.0, h)
    store_memory(payload.traction_law, outer.traction, c, traction_memory)
    normal_memory = normal_update(payload.normal_law, line.normal_memory, line.penetration, closing, h)
    store_memory(payload.normal_law, outer.normal, c, normal_memory)
    time = h * (1.0 - bound)
    rollers.friction_loss[c] += time * motion.friction * slip
    if has_rolling_resistance(site.film):
        rolling_loss = time * line.resistance * (push_share(payload, site) * along - motion.rim)
        rollers.friction_loss[c] += rolling_loss
        rollers.rolling_loss[c] += rolling_loss
    rollers.contact_loss[c] += time * line.damping * closing * closing
    rollers.notch_loss[c] += time * motion.normal * line.sink


@piece
def advance_free(payload: Payload, state: State, work: Workspace) -> None:
    """Move all rollers over the step as if none were bound; the results of bound ones are replaced afterwards."""
    rollers, around = state.rollers[0], surroundings(payload, state, work)
    for c in range(filled(payload.free.size)):
        old = (rollers.vx[c], rollers.vy[c], rollers.spin[c])
        line = contact_line(payload, state, work, around, old, c)
        oil = bar_oil(payload, state, work, around, line, old[2], c)
        motion = solve_free(payload, around, line, oil, old)
        if has_cage_oil(payload.lubrication):
            store_oil(payload, state, work, line, oil, motion, c)
        store_free(payload, state, work, around, line, motion, old, c)


@piece
def clear_contacts(payload: Payload, state: State, work: Workspace) -> None:
    """Clear the contacts with the inner raceway and bars of rollers that are not bound."""
    inner, bar = state.rollers[0].inner, state.rollers[0].bar
    for c in range(filled(payload.free.size)):
        touching = work.rollers[0].bound[c]
        inner.force[c] *= touching
        inner.friction[c] *= touching
        scale_memory(payload.traction_law, inner.traction, c, touching)
        scale_memory(payload.normal_law, inner.normal, c, touching)
        bar.force[c] *= touching
        scale_memory(payload.cage_traction_law, bar.traction, c, touching)
        bar.impact_speed[c] *= touching


@piece
def clear_pinned(payload: Payload, state: State) -> None:
    """Clear the contacts of all rollers before those of bound ones are written: pinned ones that are not bound touch nothing."""
    rollers, inner, outer = state.rollers[0], state.rollers[0].inner, state.rollers[0].outer
    for c in range(payload.free.size):
        inner.force[c] = inner.friction[c] = outer.force[c] = outer.friction[c] = rollers.change_spin[c] = 0.0
        clear_memory(payload.traction_law, inner.traction, c)
        clear_memory(payload.normal_law, inner.normal, c)
        clear_memory(payload.traction_law, outer.traction, c)
        clear_memory(payload.normal_law, outer.normal, c)


@piece
def sum_free_forces(payload: Payload, work: Workspace) -> None:
    """Add the forces of free rollers that are not bound to those on the outer ring, and on the cages where there is oil."""
    x, y = 0.0, 0.0
    for c in range(payload.free.size):
        x += work.rollers[0].force_on_outer_x[c]
        y += work.rollers[0].force_on_outer_y[c]
    work.force_of_free[OUTER, 0] += x
    work.force_of_free[OUTER, 1] += y
    if has_cage_oil(payload.lubrication):
        rollers, count = work.rollers[0], payload.free.shape[1]
        for row in range(payload.free.shape[0]):
            x, y, turn = 0.0, 0.0, 0.0
            for i in range(count):
                c = row * count + i
                x += rollers.force_on_cage_x[c]
                y += rollers.force_on_cage_y[c]
                turn += rollers.torque_on_cage[c]
            work.force_of_free[CAGE + row, 0] += x
            work.force_of_free[CAGE + row, 1] += y
            work.force_of_free[CAGE + row, 2] += turn
