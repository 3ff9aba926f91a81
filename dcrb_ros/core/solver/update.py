"""The results of a step for bound rollers: forces, slips, bristles and velocities, and the energy that they cost."""

from __future__ import annotations

from dcrb_ros.core.jit import piece
from dcrb_ros.core.laws.calls import (
    has_cage_oil,
    has_rolling_resistance,
    load_kept,
    load_memory,
    load_resistance,
    normal_update,
    store_memory,
    traction_update,
)
from dcrb_ros.core.layout.cages import of_cages, of_row
from dcrb_ros.core.layout.contacts import BarContact, RacewayContact
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.layout.rollers import BoundRollers
from dcrb_ros.core.layout.state import INNER, OUTER, SHAFT_SPEED, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.bound import push_share


@piece
def update_raceway(
    payload: Payload, bound: BoundRollers, contact: RacewayContact, count: int, mean_x: float, mean_y: float, surface: float, side: float
) -> None:
    """Write forces, slips and bristles of the contacts with a ring at the mean velocities found, and their powers.

    Those of the inner ring, where ``side`` is 1, begin the sums of a roller's powers, those of the outer are added.
    """
    first, h, normal_law, traction_law = side > 0.0, payload.step, payload.normal_law, payload.traction_law
    site = payload.inner if first else payload.outer
    share = push_share(payload, site)
    for k in range(count):
        nx, ny = contact.normal_x[k], contact.normal_y[k]
        tx, ty = -contact.radial_y[k], contact.radial_x[k]
        vx, vy, surface_n = bound.mean_vx[k] - mean_x, bound.mean_vy[k] - mean_y, contact.surface_speed_normal[k]
        approach = -side * (vx * nx + vy * ny - surface_n)
        slip = vx * tx + vy * ty - side * bound.mean_rim[k] - surface
        normal = contact.force_offset[k] + contact.force_slope[k] * approach
        friction = contact.friction_offset[k] + contact.friction_slope[k] * slip
        sink = contact.sink_speed[k]
        closing, memory = approach - sink, load_memory(traction_law, contact.traction, k)
        contact.friction[k], contact.slip[k] = friction, slip
        expected = contact.expected_force[k]
        contact.force[k] = max(expected + contact.damping[k] * (closing - contact.expected_closing[k]), 0.0)
        memory = traction_update(traction_law, memory, load_kept(traction_law, contact.kept, k), slip, expected > 0.0, h)
        store_memory(traction_law, contact.traction, k, memory)
        normal_memory = load_memory(normal_law, contact.normal, k)
        store_memory(normal_law, contact.normal, k, normal_update(normal_law, normal_memory, contact.penetration[k], closing, h))
        friction_power, loss_power = friction * slip, contact.damping[k] * closing * closing
        notch_power, drive_power = normal * sink, side * normal * surface_n - friction * surface
        if has_rolling_resistance(site.film):
            resistance = load_resistance(payload.lubrication, contact.film, k, 1.0)
            along, turning = vx * tx + vy * ty, side * bound.mean_rim[k] - surface
            rolling_power = resistance * (share * along + turning)
            bound.rolling_power[k] = rolling_power if first else rolling_power + bound.rolling_power[k]
            friction_power += rolling_power
            drive_power -= resistance * surface
        bound.friction_power[k] = friction_power if first else friction_power + bound.friction_power[k]
        bound.loss_power[k] = loss_power if first else loss_power + bound.loss_power[k]
        bound.notch_power[k] = notch_power if first else notch_power + bound.notch_power[k]
        bound.drive_power[k] = drive_power if first else drive_power + bound.drive_power[k]


@piece
def update_bars(payload: Payload, bound: BoundRollers, bar: BarContact, mean_velocity: Floats, count: int) -> None:
    """Write forces and bristles of the contacts with bars, and add their powers; ``mean_velocity`` is that of all bodies."""
    law, cages = payload.cage_traction_law, of_cages(mean_velocity)
    for k in range(count):
        nx, ny, side = bound.tangent_x[k], bound.tangent_y[k], bar.side[k]
        cage_vx, cage_vy, turn = of_row(cages, bound.second_row[k])
        vx = bound.mean_vx[k] - cage_vx + turn * bar.lever_y[k]
        vy = bound.mean_vy[k] - cage_vy - turn * bar.lever_x[k]
        along, slip = vx * nx + vy * ny, vx * ny - vy * nx - side * bound.mean_rim[k]
        approach = side * along
        friction = bar.friction_offset[k] + bar.friction_slope[k] * slip
        force = max(bar.force_offset[k] + bar.force_slope[k] * approach, 0.0)
        bar.force[k] = force if side != 0.0 else 0.0
        memory, kept = load_memory(law, bar.traction, k), load_kept(law, bar.kept, k)
        store_memory(law, bar.traction, k, traction_update(law, memory, kept, slip, side != 0.0, payload.step))
        bound.friction_power[k] += friction * slip
        bound.loss_power[k] += bar.damping[k] * along * along
        if has_rolling_resistance(payload.inner.film):
            bound.bar_friction_power[k], bound.bar_loss_power[k] = friction * slip, bar.damping[k] * along * along


@piece
def store_bound(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write the bound rollers, in ``count`` elements, back into the state."""
    rollers, bound, by_radius, h = state.rollers[0], work.bound[0], 1.0 / payload.roller_radius, payload.step
    normal_law, traction_law, cage_law = payload.normal_law, payload.traction_law, payload.cage_traction_law
    surface = state.shaft[SHAFT_SPEED] * payload.inner_raceway_radius
    update_raceway(payload, bound, bound.inner, count, work.mean_velocity[INNER, 0], work.mean_velocity[INNER, 1], surface, 1.0)
    update_raceway(payload, bound, bound.outer, count, work.mean_velocity[OUTER, 0], work.mean_velocity[OUTER, 1], 0.0, -1.0)
    if payload.any_free:
        update_bars(payload, bound, bound.bar, work.mean_velocity, count)
    for k in range(work.row_ends[work.row_ends.size - 1]):
        c = bound.roller[k]
        rollers.inner.force[c], rollers.outer.force[c] = bound.inner.force[k], bound.outer.force[k]
        rollers.inner.friction[c], rollers.outer.friction[c] = bound.inner.friction[k], bound.outer.friction[k]
        rollers.inner.slip[c], rollers.outer.slip[c] = bound.inner.slip[k], bound.outer.slip[k]
        store_memory(traction_law, rollers.inner.traction, c, load_memory(traction_law, bound.inner.traction, k))
        store_memory(traction_law, rollers.outer.traction, c, load_memory(traction_law, bound.outer.traction, k))
        store_memory(normal_law, rollers.inner.normal, c, load_memory(normal_law, bound.inner.normal, k))
        store_memory(normal_law, rollers.outer.normal, c, load_memory(normal_law, bound.outer.normal, k))
        rollers.friction_loss[c] += h * bound.friction_power[k]
        if has_rolling_resistance(payload.inner.film):
            rollers.rolling_loss[c] += h * bound.rolling_power[k]
        if has_cage_oil(payload.lubrication):
            rollers.friction_loss[c] += h * bound.drag_power[k]
            rollers.drag_loss[c] += h * bound.drag_power[k]
            rollers.bar_friction_loss[c] += h * bound.drag_power[k]
        rollers.contact_loss[c] += h * bound.loss_power[k]
        rollers.notch_loss[c] += h * bound.notch_power[k]
        rollers.drive_work[c] += h * bound.drive_power[k]
        before = bound.rim[k]
        rollers.change_spin[c] = 2.0 * (bound.mean_rim[k] - before) * by_radius
        rollers.spin[c] = (2.0 * bound.mean_rim[k] - before) * by_radius
        if bound.free[k] > 0.0:
            rollers.bar.force[c] = bound.bar.side[k] * bound.bar.force[k]
            store_memory(cage_law, rollers.bar.traction, c, load_memory(cage_law, bound.bar.traction, k))
            if has_rolling_resistance(payload.inner.film):
                rollers.bar_friction_loss[c] += h * bound.bar_friction_power[k]
                rollers.bar_contact_loss[c] += h * bound.bar_loss_power[k]
            rollers.bar.impact_speed[c] = bound.bar.impact_speed[k]
            x, y = bound.mean_vx[k], bound.mean_vy[k]
            rollers.change_vx[c], rollers.change_vy[c] = 2.0 * (x - bound.vx[k]), 2.0 * (y - bound.vy[k])
            rollers.vx[c], rollers.vy[c] = 2.0 * x - bound.vx[k], 2.0 * y - bound.vy[k]
