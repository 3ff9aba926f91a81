"""Conformal contacts: cages with their lands, and bound rollers with the bars of their pockets.

Few of them are closed at any time. They are found one by one and put side by side, so that their law, which takes three powers each, is
evaluated for all of them at once.
"""

from __future__ import annotations

import math

from dcrb_ros.core.contacts.cage_films import CONCENTRIC, add_bar_films, write_land_films
from dcrb_ros.core.jit import piece
from dcrb_ros.core.laws.calls import (
    clear_memory,
    has_cage_oil,
    has_rolling_resistance,
    load_kept,
    load_memory,
    store_kept,
    store_memory,
    traction_line,
    traction_update,
)
from dcrb_ros.core.laws.pereira import LEAST_IMPACT_SPEED, impact_damping, step_force
from dcrb_ros.core.layout.contacts import BarContact, ConformalContacts
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.layout.state import CAGE, FRICTION, LOSS, OUTER, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.classification import bar_at, filled


@piece
def find_lands(payload: Payload, state: State, work: Workspace) -> int:
    """Write how the cages in reach of the outer ring's land lie to it, in the first conformal contacts; return how many there are."""
    contacts, land, law, h, count = work.conformal[0], state.land[0], payload.cage_traction_law, payload.step, 0
    for row in range(payload.free.shape[0]):
        dx, dy = state.position[CAGE + row, 0] - state.position[OUTER, 0], state.position[CAGE + row, 1] - state.position[OUTER, 1]
        distance = max(math.sqrt(dx * dx + dy * dy), CONCENTRIC)
        nx, ny = dx / distance, dy / distance
        before = (state.velocity[CAGE + row, 0] - state.velocity[OUTER, 0]) * nx + (
            state.velocity[CAGE + row, 1] - state.velocity[OUTER, 1]
        ) * ny
        if distance + 0.5 * h * abs(before) <= payload.land_clearance:
            land.force[row] = land.impact_speed[row] = 0.0
            clear_memory(law, land.traction, row)
            continue
        vx = work.mean_velocity[CAGE + row, 0] - work.mean_velocity[OUTER, 0]
        vy = work.mean_velocity[CAGE + row, 1] - work.mean_velocity[OUTER, 1]
        contacts.owner[count] = row
        contacts.normal_x[count], contacts.normal_y[count] = nx, ny
        contacts.penetration[count] = distance - payload.land_clearance - 0.5 * h * before
        contacts.closing_before[count], contacts.closing[count] = before, vx * nx + vy * ny
        contacts.slip[count] = vy * nx - vx * ny + payload.land_radius * work.mean_velocity[CAGE + row, 2]
        contacts.force[count], contacts.impact_speed[count] = land.force[row], land.impact_speed[row]
        store_memory(law, contacts.traction, count, load_memory(law, land.traction, row))
        contacts.coefficient[count], contacts.exponent[count] = payload.land_coefficient, payload.land_exponent
        contacts.mobility[count] = 0.5 * h * (1.0 / payload.train_mass[row] + 1.0 / payload.outer_mass)
        count += 1
    return count


@piece
def find_bars(payload: Payload, state: State, work: Workspace, count: int) -> int:
    """Write how bound rollers lie to bars in reach, as conformal contacts from ``count`` on; return how many there are then."""
    bound, contacts, law, radius, h = work.bound[0], work.conformal[0], payload.cage_traction_law, payload.roller_radius, payload.step
    for k in range(work.row_ends[work.row_ends.size - 1]):
        if bound.near_bar[k] <= 0.0:
            continue
        c, row = bound.roller[k], bound.row[k]
        tx, ty = bound.tangent_x[k], bound.tangent_y[k]
        ax, ay = bound.x[k] - state.position[CAGE + row, 0], bound.y[k] - state.position[CAGE + row, 1]
        along = ax * tx + ay * ty
        ahead = along > 0.0
        i = c - row * payload.free.shape[1]
        if not bar_at(payload, row, i, ahead):
            continue
        side = 1.0 if ahead else -1.0
        rx, ry = ax + side * radius * tx, ay + side * radius * ty
        body = CAGE + row
        turn, old_turn = work.mean_velocity[body, 2], state.velocity[CAGE + row, 2]
        vx = bound.predicted_vx[k] - work.mean_velocity[body, 0] + turn * ry
        vy = bound.predicted_vy[k] - work.mean_velocity[body, 1] - turn * rx
        ux = bound.vx[k] - state.velocity[CAGE + row, 0] + old_turn * ry
        uy = bound.vy[k] - state.velocity[CAGE + row, 1] - old_turn * rx
        before = side * (ux * tx + uy * ty)
        contacts.owner[count] = k
        contacts.penetration[count] = abs(along) - payload.pocket_clearance[row, i] - 0.5 * h * before
        contacts.closing_before[count], contacts.closing[count] = before, side * (vx * tx + vy * ty)
        contacts.slip[count] = vx * ty - vy * tx - side * bound.predicted_rim[k]
        contacts.force[count], contacts.impact_speed[count] = abs(state.rollers[0].bar.force[c]), state.rollers[0].bar.impact_speed[c]
        store_memory(law, contacts.traction, count, load_memory(law, bound.bar.traction, k))
        contacts.coefficient[count], contacts.exponent[count] = payload.bar_coefficient[row, i], payload.bar_exponent[row, i]
        contacts.mobility[count] = 0.5 * h / payload.roller_mass
        bound.bar.side[k], bound.bar.lever_x[k], bound.bar.lever_y[k] = side, rx, ry
        count += 1
    return count


@piece
def evaluate_conformal(payload: Payload, contacts: ConformalContacts, count: int) -> None:
    """Write elastic force and its slope, damping and friction of all conformal contacts."""
    law, lanes = payload.cage_traction_law, filled(count)
    for c in range(count, lanes):
        contacts.penetration[c], contacts.closing[c], contacts.closing_before[c], contacts.force[c] = -1.0, 0.0, 0.0, 0.0
    for c in range(lanes):
        force, slope, closing = step_force(
            contacts.penetration[c],
            contacts.closing[c],
            contacts.force[c],
            contacts.mobility[c],
            payload.step,
            contacts.coefficient[c],
            contacts.exponent[c],
        )
        closed_at = contacts.impact_speed[c]
        impact = closed_at if closed_at > 0.0 else max(contacts.closing_before[c], LEAST_IMPACT_SPEED)
        damping = impact_damping(force, closing, impact, payload.impact_loss)
        memory = load_memory(law, contacts.traction, c)
        friction_offset, friction_slope, kept = traction_line(
            law, memory, contacts.slip[c], None, force + damping * closing, None, payload.step
        )
        contacts.elastic_force[c], contacts.elastic_slope[c] = force, slope
        contacts.closing[c], contacts.damping[c] = closing, damping
        contacts.friction_offset[c], contacts.friction_slope[c] = friction_offset, friction_slope
        store_kept(law, contacts.kept, c, kept)
        contacts.impact_speed[c] = impact if force > 0.0 else 0.0


@piece
def land_closing(contacts: ConformalContacts, mean_velocity: Floats, c: int, row: int) -> float:
    """Return the speed of penetration of a cage's contact with its land at the present mean velocities [m/s]."""
    vx, vy = mean_velocity[CAGE + row, 0] - mean_velocity[OUTER, 0], mean_velocity[CAGE + row, 1] - mean_velocity[OUTER, 1]
    closing: float = vx * contacts.normal_x[c] + vy * contacts.normal_y[c]
    return closing


@piece
def add_land_forces(payload: Payload, work: Workspace, lands: int) -> None:
    """Add the forces between cages and lands at the present mean velocities to those on both bodies."""
    contacts, forces = work.conformal[0], work.force_of_bound
    for c in range(lands):
        row = contacts.owner[c]
        closing = land_closing(contacts, work.mean_velocity, c, row)
        elastic = contacts.elastic_force[c] + contacts.elastic_slope[c] * (closing - contacts.closing[c])
        force = max(elastic + contacts.damping[c] * closing, 0.0)
        # The mean velocities result from the force of the last sweep: without a step of Newton's method a stiff land is unstable.
        feedback = contacts.mobility[c] * (contacts.elastic_slope[c] + contacts.damping[c])
        normal = (force + feedback * contacts.force[c]) / (1.0 + feedback)
        contacts.force[c] = normal
        friction = normal * (contacts.friction_offset[c] + contacts.friction_slope[c] * contacts.slip[c])
        nx, ny = contacts.normal_x[c], contacts.normal_y[c]
        fx, fy = -normal * nx + friction * ny, -normal * ny - friction * nx
        forces[CAGE + row, 0] += fx
        forces[CAGE + row, 1] += fy
        forces[CAGE + row, 2] -= payload.land_radius * friction
        forces[OUTER, 0] -= fx
        forces[OUTER, 1] -= fy


@piece
def store_lands(payload: Payload, state: State, work: Workspace, lands: int) -> None:
    """Write the contacts of cages and lands back into the state, and their losses into the energy account."""
    contacts, land, law, h = work.conformal[0], state.land[0], payload.cage_traction_law, payload.step
    for c in range(lands):
        row = contacts.owner[c]
        normal, closing, slip = contacts.force[c], land_closing(contacts, work.mean_velocity, c, row), contacts.slip[c]
        land.force[row] = normal
        memory, kept = load_memory(law, contacts.traction, c), load_kept(law, contacts.kept, c)
        store_memory(law, land.traction, row, traction_update(law, memory, kept, slip, normal > 0.0, h))
        land.impact_speed[row] = contacts.impact_speed[c]
        state.account[FRICTION] += h * normal * (contacts.friction_offset[c] + contacts.friction_slope[c] * slip) * slip
        state.account[LOSS] += h * contacts.damping[c] * closing * closing
        if has_rolling_resistance(payload.inner.film):
            sliding = normal * (contacts.friction_offset[c] + contacts.friction_slope[c] * slip) * slip
            land.loss[row] += h * (sliding + contacts.damping[c] * closing * closing)


@piece
def linearize_bars(payload: Payload, bar: BarContact, contacts: ConformalContacts, lands: int, count: int) -> None:
    """Write contacts with bars as lines over the mean velocities of the step; the normal is the pocket's tangent, friction radial."""
    law = payload.cage_traction_law
    for c in range(lands, count):
        k, elastic, slope, closing = contacts.owner[c], contacts.elastic_force[c], contacts.elastic_slope[c], contacts.closing[c]
        damping = contacts.damping[c]
        expected = elastic + damping * closing
        bar.force_offset[k], bar.force_slope[k] = elastic - slope * closing, slope + damping
        bar.friction_offset[k], bar.friction_slope[k] = contacts.friction_offset[c] * expected, contacts.friction_slope[c] * expected
        store_kept(law, bar.kept, k, load_kept(law, contacts.kept, c))
        bar.damping[k] = damping
        bar.impact_speed[k] = contacts.impact_speed[c]


@piece
def clear_bars(bar: BarContact, count: int) -> None:
    """Write that no bar is touched."""
    for k in range(count):
        bar.force_offset[k] = bar.force_slope[k] = bar.friction_offset[k] = bar.friction_slope[k] = 0.0
        bar.damping[k] = bar.side[k] = bar.lever_x[k] = bar.lever_y[k] = 0.0
        bar.impact_speed[k] = 0.0


@piece
def linearize_cages(payload: Payload, state: State, work: Workspace, count: int) -> int:
    """Write the contacts of cages with lands and of ``count`` bound rollers with bars; return how many lands are touched."""
    lands = find_lands(payload, state, work)
    touching = lands
    if payload.any_free:
        clear_bars(work.bound[0].bar, count)
        touching = find_bars(payload, state, work, lands)
    if touching > 0:
        evaluate_conformal(payload, work.conformal[0], touching)
        linearize_bars(payload, work.bound[0].bar, work.conformal[0], lands, touching)
    if has_cage_oil(payload.lubrication):
        if payload.any_free:
            add_bar_films(payload, state, work, count)
        write_land_films(payload, state, work)
    return lands
