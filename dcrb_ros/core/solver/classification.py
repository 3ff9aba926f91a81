"""The rollers in the middle of a step: where they are, how they are predicted to move, and which are bound.

A roller is bound when its forces on rings and cage must be solved for together with their motion: it is pinned and touches a raceway, it
touches the inner ring or a bar, stiff oil couples it to a bar, it strikes a raceway, or it lies beside a broken bar. The others are free
and lie on the outer raceway, or touch nothing.
"""

from __future__ import annotations

from dcrb_ros.core.contacts.films import raceway_site
from dcrb_ros.core.contacts.force_line import SHORT_WAY, onset, reach
from dcrb_ros.core.jit import NO, YES, piece
from dcrb_ros.core.laws.calls import bar_damping, film_floor, film_reach, has_cage_oil, load_memory, store_memory
from dcrb_ros.core.layout.cages import headings_of, of_cages, of_row
from dcrb_ros.core.layout.records import WIDTH
from dcrb_ros.core.layout.state import INNER, OUTER, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import EDGE, Payload, mobilities

STRIKE_WINDOW = 1.5
"""Half steps before and after the middle within which a strike on the outer raceway counts [-]: its speed is not known yet."""
STIFF_OIL = 0.15
"""Damping by the oil at the bars of a row over 2 m_C/h of its cage, above which the rollers in the stiffest films are bound [-]."""
NEGLIGIBLE_STRIKE = 2e-3
"""Speed below which a free roller may close or open its contact with the outer raceway unbound [m/s]: its energy is negligible."""


@piece
def filled(count: int) -> int:
    """Return how many elements a loop over ``count`` rollers works on: a multiple of `WIDTH`."""
    return (count + WIDTH - 1) // WIDTH * WIDTH


@piece
def classify_rollers(payload: Payload, state: State, work: Workspace, pinned: bool) -> None:
    """Write centres and pocket tangents of the rollers, how near their contacts are to closing, and which rollers are bound.

    ``pinned`` says that all of them are: it is a constant for the compiler, which leaves out what free ones need.
    """
    rollers, step, h = state.rollers[0], work.rollers[0], payload.step
    cages, old_cages, headings, pitch = of_cages(state.position), of_cages(state.velocity), headings_of(work.heading), payload.pitch_radius
    inner_x, inner_y, outer_x, outer_y = (
        state.position[INNER, 0],
        state.position[INNER, 1],
        state.position[OUTER, 0],
        state.position[OUTER, 1],
    )
    inner_vx, inner_vy, outer_vx, outer_vy = (
        state.velocity[INNER, 0],
        state.velocity[INNER, 1],
        state.velocity[OUTER, 0],
        state.velocity[OUTER, 1],
    )
    law, inner, outer = payload.normal_law, raceway_site(payload, state, YES), raceway_site(payload, state, NO)
    inner_reach = payload.inner_raceway_radius + payload.roller_radius + (reach(law, inner) + payload.profile_height)
    outer_reach = payload.outer_raceway_radius - payload.roller_radius - (reach(law, outer) + payload.profile_height)
    outer_onset = payload.outer_raceway_radius - payload.roller_radius - (onset(law, outer) + payload.profile_height)
    oiled, nominal, floor = film_reach(outer.film) > 0.0, payload.outer_raceway_radius - payload.roller_radius, film_floor(outer.film)
    slow_way = h * NEGLIGIBLE_STRIKE * outer_reach
    inner_square, outer_square, onset_square = inner_reach * inner_reach, outer_reach * outer_reach, outer_onset * outer_onset
    for c in range(filled(payload.free.size)):
        cage_x, cage_y, _ = of_row(cages, rollers.second_row[c])
        cosine, sine, _ = of_row(headings, rollers.second_row[c])
        px, py = rollers.pocket_tangent_x[c], rollers.pocket_tangent_y[c]
        tx, ty = cosine * px - sine * py, sine * px + cosine * py
        x, y, near_bar, if_outer = cage_x + pitch * ty, cage_y - pitch * tx, -1.0, 1.0
        old_x, old_y, old_turn = of_row(old_cages, rollers.second_row[c])
        vx, vy = old_x + pitch * old_turn * tx, old_y + pitch * old_turn * ty
        if not pinned:
            free = rollers.free[c] > 0.0
            x, y = rollers.x[c] if free else x, rollers.y[c] if free else y
            ax, ay = x - cage_x, y - cage_y
            vx, vy = rollers.vx[c] if free else vx, rollers.vy[c] if free else vy
            rate = (vx - old_x) * tx + (vy - old_y) * ty - old_turn * (ax * ty - ay * tx)
            near_bar = abs(ax * tx + ay * ty) + 0.5 * h * abs(rate) - rollers.pocket_clearance[c] if free else -1.0
            if_outer = 0.0 if free else 1.0
            if has_cage_oil(payload.lubrication):
                along = ax * tx + ay * ty
                film = bar_damping(payload.lubrication, rollers.pocket_clearance[c] - (along if rate > 0.0 else -along))
                step.bar_film[c] = (film if rate > 0.0 else -film) if free else 0.0
        ix, iy, ox, oy = x - inner_x, y - inner_y, x - outer_x, y - outer_y
        # What counts is whether a contact is closed at the beginning of the step, or will be at its end.
        inner_way = h * abs((vx - inner_vx) * ix + (vy - inner_vy) * iy)
        outer_way = h * abs((vx - outer_vx) * ox + (vy - outer_vy) * oy)
        near_inner, outer_deep = inner_square - ix * ix - iy * iy + inner_way, ox * ox + oy * oy - onset_square
        near_outer = ox * ox + oy * oy - outer_square + outer_way
        outer_strike = STRIKE_WINDOW * (outer_way - slow_way) - abs(outer_deep)
        nearest = max(max(near_inner, near_bar), max(if_outer * near_outer, outer_strike))
        if oiled:
            # A gap that closes by much within the step: see `closes_quickly`.
            gap = max(0.5 * (nominal * nominal - ox * ox - oy * oy) - nominal * payload.profile_height, nominal * floor)
            way = h * ((vx - outer_vx) * ox + (vy - outer_vy) * oy)
            nearest = max(nearest, min(near_outer, way - SHORT_WAY * gap))
        step.x[c], step.y[c], step.tangent_x[c], step.tangent_y[c] = x, y, tx, ty
        step.near_outer[c], step.near_bar[c], step.bound[c] = near_outer, near_bar, 1.0 if nearest > 0.0 else 0.0


@piece
def bar_at(payload: Payload, row: int, i: int, ahead: bool) -> bool:
    """Return whether there is a bar ahead of a roller, or behind it."""
    return not payload.broken[row, i if ahead else i - 1]


@piece
def bind_oiled(payload: Payload, work: Workspace) -> None:
    """Bind the rollers of a row whose oil at the bars couples them to their cage more stiffly than its predicted velocity allows.

    A free roller acts on the predicted cage, at a bar through the film's damping d. Such explicit steps diverge where the sum of
    d/(1 + h d/(2 m_R)) over the row exceeds a quarter of 2 m_C/h, or of 2 I_C/(h r_M^2) if that is smaller. Most films of a row are wide,
    so a row is safe if the sum with every film at its stiffest is below a half of 2 m_C/h.
    """
    rollers, count = work.rollers[0], payload.free.shape[1]
    by_roller, _ = mobilities(payload)
    stiffest = bar_damping(payload.lubrication, 0.0)
    for row in range(payload.free.shape[0]):
        by_cage = max(payload.train_inverse[row, 0], payload.train_inverse[row, 1] * payload.pitch_radius * payload.pitch_radius)
        first, total, unit = row * count, 0.0, 2.0 / (by_cage * payload.step)
        if count * stiffest < 0.5 * unit * (1.0 + by_roller * stiffest):
            continue
        for c in range(first, first + count):
            total += abs(rollers.bar_film[c])
        if total > STIFF_OIL * unit:
            for c in range(first, first + count):
                if count * abs(rollers.bar_film[c]) > STIFF_OIL * unit:
                    rollers.bound[c] = 1.0


@piece
def bind_special(payload: Payload, work: Workspace) -> None:
    """Bind the rollers beside broken bars, on an outer raceway whose notches have edges, and in stiff oil."""
    rollers, count = work.rollers[0], payload.free.shape[1]
    for k in range(payload.gaps.shape[0]):
        first = payload.gaps[k, 0] * count
        rollers.bound[first + payload.gaps[k, 1]] = rollers.bound[first + payload.gaps[k, 2]] = 1.0
    if payload.notch_law == EDGE and payload.outer_notches.row.size > 0:
        for c in range(payload.free.size):
            if rollers.near_outer[c] > 0.0:
                rollers.bound[c] = 1.0
    if has_cage_oil(payload.lubrication):
        bind_oiled(payload, work)


@piece
def list_bound(payload: Payload, work: Workspace, row: int, end: int) -> int:
    """List the bound rollers of a row, from element ``end`` on; return where they end."""
    rollers, bound, count = work.rollers[0], work.bound[0], payload.free.shape[1]
    first = row * count
    for i in range(count):
        if rollers.bound[first + i] > 0.0:
            bound.roller[end], bound.row[end] = first + i, row
            end += 1
    return end


@piece
def gather_bound(payload: Payload, state: State, work: Workspace, end: int) -> int:
    """Copy the bound rollers side by side, filled up to a multiple of `WIDTH`; return how many elements that makes."""
    rollers, step, bound = state.rollers[0], work.rollers[0], work.bound[0]
    normal_law, traction_law, cage_law = payload.normal_law, payload.traction_law, payload.cage_traction_law
    count = filled(end)
    for k in range(end, count):
        bound.roller[k], bound.row[k] = bound.roller[end - 1], bound.row[end - 1]
    for k in range(count):
        c = bound.roller[k]
        bound.second_row[k], bound.free[k] = 1.0 if bound.row[k] > 0 else 0.0, rollers.free[c]
        bound.x[k], bound.y[k] = step.x[c], step.y[c]
        bound.tangent_x[k], bound.tangent_y[k], bound.near_bar[k] = step.tangent_x[c], step.tangent_y[c], step.near_bar[c]
        bound.vx[k], bound.vy[k], bound.spin[k] = rollers.vx[c], rollers.vy[c], rollers.spin[c]
        bound.change_vx[k], bound.change_vy[k] = rollers.change_vx[c], rollers.change_vy[c]
        bound.change_spin[k] = rollers.change_spin[c]
        store_memory(traction_law, bound.inner.traction, k, load_memory(traction_law, rollers.inner.traction, c))
        store_memory(traction_law, bound.outer.traction, k, load_memory(traction_law, rollers.outer.traction, c))
        store_memory(normal_law, bound.inner.normal, k, load_memory(normal_law, rollers.inner.normal, c))
        store_memory(normal_law, bound.outer.normal, k, load_memory(normal_law, rollers.outer.normal, c))
        store_memory(cage_law, bound.bar.traction, k, load_memory(cage_law, rollers.bar.traction, c))
        store_memory(payload.lubrication, bound.inner.film, k, load_memory(payload.lubrication, rollers.inner.film, c))
        store_memory(payload.lubrication, bound.outer.film, k, load_memory(payload.lubrication, rollers.outer.film, c))
        if has_cage_oil(payload.lubrication):
            bound.bar_film[k], bound.spin_drag[k] = step.bar_film[c], rollers.spin_drag[c]
        bound.inner.last_force[k], bound.outer.last_force[k] = rollers.inner.force[c], rollers.outer.force[c]
    return count


@piece
def predict_bound(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write the velocities of ``count`` bound rollers before the step, those predicted over it, and those without contacts.

    Those before the step are gathered for free rollers, and follow from the cage for pinned ones.
    """
    bound, radius, pitch = work.bound[0], payload.roller_radius, payload.pitch_radius
    cages, old_cages, fall = of_cages(work.mean_velocity), of_cages(state.velocity), 0.5 * payload.step * payload.gravity
    for k in range(count):
        free, tx, ty = bound.free[k] > 0.0, bound.tangent_x[k], bound.tangent_y[k]
        old_x, old_y, old_turn = of_row(old_cages, bound.second_row[k])
        mean_x, mean_y, mean_turn = of_row(cages, bound.second_row[k])
        old_rim, mean_rim = pitch * old_turn, pitch * mean_turn
        vx, vy, rim = bound.vx[k], bound.vy[k], radius * bound.spin[k]
        coming_x, coming_y = vx + 0.5 * bound.change_vx[k], vy + 0.5 * bound.change_vy[k]
        before_x, before_y = vx if free else old_x + old_rim * tx, vy if free else old_y + old_rim * ty
        bound.vx[k], bound.vy[k], bound.rim[k] = before_x, before_y, rim
        bound.contact_free_vx[k], bound.contact_free_vy[k], bound.contact_free_rim[k] = before_x, before_y - fall, rim
        bound.predicted_vx[k] = coming_x if free else mean_x + mean_rim * tx
        bound.predicted_vy[k] = coming_y if free else mean_y + mean_rim * ty
        bound.predicted_rim[k] = rim + 0.5 * radius * bound.change_spin[k]


@piece
def apply_pair_forces(payload: Payload, work: Workspace) -> None:
    """Add the forces that rollers exert on each other across broken bars to the velocities without contacts."""
    bound, rollers = work.bound[0], payload.free.shape[1]
    by_mass, by_inertia = mobilities(payload)
    for k in range(work.row_ends[work.row_ends.size - 1]):
        row = bound.row[k]
        i = bound.roller[k] - row * rollers
        if payload.beside[row, i]:
            bound.contact_free_vx[k] += by_mass * work.pair_force[row, i, 0]
            bound.contact_free_vy[k] += by_mass * work.pair_force[row, i, 1]
            bound.contact_free_rim[k] += by_inertia * work.pair_force[row, i, 2]
