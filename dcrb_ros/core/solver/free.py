"""Rollers that lie free on the outer raceway or touch nothing: most of those in pockets.

They need no solution together with other bodies: the raceway's normal and tangent are not coupled, each is a scalar equation. So a whole
step of such a roller is one pass of one loop, from its position to its new velocity, and nothing but its state goes through memory.
"""

from __future__ import annotations

import math

from dcrb_ros.core.contacts.cage_films import drag_on_orbit
from dcrb_ros.core.contacts.films import contact_site, raceway_site
from dcrb_ros.core.contacts.force_line import elastic, lasting_line
from dcrb_ros.core.contacts.raceway import notch_depth
from dcrb_ros.core.contacts.surface import tilted, uneven
from dcrb_ros.core.jit import NO, piece
from dcrb_ros.core.laws.calls import (
    clear_memory,
    film_resistance,
    film_resists,
    load_memory,
    normal_update,
    oils_cages,
    scale_memory,
    store_memory,
    traction_line,
    traction_update,
)
from dcrb_ros.core.layout.state import CAGE, OUTER, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import SINK, Payload
from dcrb_ros.core.solver.classification import filled

LEAST_DISTANCE = 1e-12
"""Least distance from the ring's centre, for elements without a roller [m]."""


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
    if payload.profiles.row.size > 0:
        for c in range(payload.free.size):
            rollers.over_notch[c] = 1.0
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
def advance_free(payload: Payload, state: State, work: Workspace) -> None:
    """Move all rollers over the step as if none were bound; the results of bound ones are replaced afterwards."""
    rollers, outer, found, h, radius = state.rollers[0], state.rollers[0].outer, work.rollers[0], payload.step, payload.roller_radius
    site, normal_law, traction_law = raceway_site(payload, state, NO), payload.normal_law, payload.traction_law
    by_mass, by_inertia = 0.5 * h / payload.roller_mass, 0.5 * h * radius * radius / payload.roller_inertia
    by_radius, fall, reach = 1.0 / radius, by_mass * payload.roller_mass * payload.gravity, payload.outer_raceway_radius - radius
    push = 2.0 * site.reduced_radius * by_radius - 1.0
    ring_x, ring_y = state.position[OUTER, 0], state.position[OUTER, 1]
    mean_x, mean_y = work.mean_velocity[OUTER, 0], work.mean_velocity[OUTER, 1]
    old_x, old_y = state.velocity[OUTER, 0], state.velocity[OUTER, 1]
    last = state.position.shape[0] - 1
    first_at, second_at = (state.position[CAGE, 0], state.position[CAGE, 1]), (state.position[last, 0], state.position[last, 1])
    first_cage = (work.mean_velocity[CAGE, 0] - mean_x, work.mean_velocity[CAGE, 1] - mean_y, work.mean_velocity[CAGE, 2])
    second_cage = (work.mean_velocity[last, 0] - mean_x, work.mean_velocity[last, 1] - mean_y, work.mean_velocity[last, 2])
    first_drag, second_drag = drag_on_orbit(payload, work, 0), drag_on_orbit(payload, work, last - CAGE)
    for c in range(filled(payload.free.size)):
        dx, dy = rollers.x[c] - ring_x, rollers.y[c] - ring_y
        distance = max(math.sqrt(dx * dx + dy * dy), LEAST_DISTANCE)
        nx, ny, sink, height = dx / distance, dy / distance, found.sink_speed[c], 0.0
        if uneven(payload.surfaces):
            (nx, ny), height = tilted(nx, ny, found.tilt[c]), found.height[c]
        normal_memory, traction_memory = load_memory(normal_law, outer.normal, c), load_memory(traction_law, outer.traction, c)

        own_x, own_y, spin = rollers.vx[c], rollers.vy[c], rollers.spin[c]
        vx, vy = own_x + 0.5 * rollers.change_vx[c] - mean_x, own_y + 0.5 * rollers.change_vy[c] - mean_y
        along, rim = vy * nx - vx * ny, radius * spin
        before = (own_x - old_x) * nx + (own_y - old_y) * ny - sink
        penetration = distance - reach - found.notch_depth[c] + height
        force, stiffness = elastic(normal_law, normal_memory, penetration, site)
        force_offset, force_slope, expected_force, damping, expected_closing = lasting_line(
            payload, normal_memory, site, penetration, force, stiffness, vx * nx + vy * ny - sink, before, sink
        )
        predicted_slip = along + rim + 0.5 * radius * rollers.change_spin[c]
        rolling = (along / distance - 0.0) * site.raceway_radius
        here = contact_site(payload, site, outer.film, c)
        offset, slope, kept = traction_line(traction_law, traction_memory, predicted_slip, rolling, expected_force, here, h)
        friction_offset, friction_slope = offset * expected_force, slope * expected_force

        alone_x, alone_y = own_x - mean_x, own_y - fall - mean_y
        resistance = film_resistance(here.film, here.memory, expected_force)
        if film_resists(site.film):
            alone_x, alone_y = alone_x + by_mass * push * resistance * ny, alone_y - by_mass * push * resistance * nx
            rim += by_inertia * resistance
        if oils_cages(payload.lubrication):
            second = rollers.second_row[c] > 0.0
            turn, orbit = second_cage[2] if second else first_cage[2], second_drag if second else first_drag
            past = radius * (spin + 0.5 * rollers.change_spin[c] - turn)
            drag = rollers.spin_drag[c] * past
            rim -= by_inertia * drag
            alone_x, alone_y = alone_x - by_mass * orbit * ny, alone_y + by_mass * orbit * nx
            # The film at a bar acts along the raceway, a linear force in the scalar equation there.
            arm_x = rollers.x[c] - (second_at[0] if second else first_at[0])
            arm_y = rollers.y[c] - (second_at[1] if second else first_at[1])
            cage_x, cage_y = second_cage[0] if second else first_cage[0], second_cage[1] if second else first_cage[1]
            bar = (cage_y + turn * arm_x) * nx - (cage_x - turn * arm_y) * ny
            film = abs(found.bar_film[c])
            free_along = alone_y * nx - alone_x * ny
            mobile = by_mass / (1.0 + by_mass * film)
            slowed = free_along - mobile * film * (free_along - bar)
            normal = (force_offset + force_slope * (alone_x * nx + alone_y * ny)) / (1.0 + by_mass * force_slope)
            friction = (friction_offset + friction_slope * (slowed + rim)) / (1.0 + (mobile + by_inertia) * friction_slope)
            push_bar = film * (slowed - mobile * friction - bar)
            fx, fy = normal * nx - (friction + push_bar) * ny, normal * ny + (friction + push_bar) * nx
            x, y, turned = alone_x - by_mass * fx, alone_y - by_mass * fy, rim - by_inertia * friction
            fx, fy = fx + push_bar * ny, fy - push_bar * nx
            among = 1.0 - found.bound[c]
            found.force_on_cage_x[c], found.force_on_cage_y[c] = -among * push_bar * ny, among * push_bar * nx
            found.torque_on_cage[c] = among * (push_bar * (arm_x * nx + arm_y * ny) + radius * drag)
            drag_loss = h * among * (drag * past - orbit * payload.pitch_radius * turn)
            rollers.friction_loss[c] += drag_loss
            rollers.drag_loss[c] += drag_loss
            rollers.bar_friction_loss[c] += drag_loss
            film_loss = h * among * push_bar * (y * nx - x * ny - bar)
            rollers.contact_loss[c] += film_loss
            rollers.bar_contact_loss[c] += film_loss
        else:
            normal = (force_offset + force_slope * (alone_x * nx + alone_y * ny)) / (1.0 + by_mass * force_slope)
            friction = (friction_offset + friction_slope * (alone_y * nx - alone_x * ny + rim)) / (
                1.0 + (by_mass + by_inertia) * friction_slope
            )
            fx, fy = normal * nx - friction * ny, normal * ny + friction * nx
            x, y, turned = alone_x - by_mass * fx, alone_y - by_mass * fy, rim - by_inertia * friction
        rim = radius * spin
        if film_resists(site.film):
            fx, fy = fx - push * resistance * ny, fy + push * resistance * nx
        slip, closing = y * nx - x * ny + turned, x * nx + y * ny - sink
        law_force = max(expected_force + damping * (closing - expected_closing), 0.0)

        bound = found.bound[c]
        found.force_on_outer_x[c], found.force_on_outer_y[c] = (1.0 - bound) * fx, (1.0 - bound) * fy
        change_vx, change_vy, change_spin = 2.0 * (x + mean_x - own_x), 2.0 * (y + mean_y - own_y), 2.0 * (turned - rim) * by_radius
        rollers.change_vx[c], rollers.change_vy[c], rollers.change_spin[c] = change_vx, change_vy, change_spin
        rollers.vx[c], rollers.vy[c], rollers.spin[c] = own_x + change_vx, own_y + change_vy, spin + change_spin
        outer.force[c], outer.friction[c], outer.slip[c] = law_force, friction, slip
        traction_memory = traction_update(traction_law, traction_memory, kept, slip, expected_force > 0.0, h)
        store_memory(traction_law, outer.traction, c, traction_memory)
        store_memory(normal_law, outer.normal, c, normal_update(normal_law, normal_memory, penetration, closing, h))
        time = h * (1.0 - bound)
        rollers.friction_loss[c] += time * friction * slip
        if film_resists(site.film):
            rolling_loss = time * resistance * (push * (y * nx - x * ny) - turned)
            rollers.friction_loss[c] += rolling_loss
            rollers.rolling_loss[c] += rolling_loss
        rollers.contact_loss[c] += time * damping * closing * closing
        rollers.notch_loss[c] += time * normal * sink


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
    if oils_cages(payload.lubrication):
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
