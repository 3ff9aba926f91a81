"""The rollers at the middle of a step: where they are, how they are expected to move, and which are bound.

A roller is bound when what it does to rings and cage must be solved for together with them: it is pinned and touches a raceway, it touches
the inner ring or a bar, it strikes a raceway, or it lies beside a broken bar. The others are free and lie on the outer raceway, or on
nothing.
"""

from __future__ import annotations

from dcrb_ros.core import lanes as at
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import EDGE, Payload
from dcrb_ros.core.state import CAGE, INNER, OUTER, State
from dcrb_ros.core.work import Workspace

ABOUT = 1.5
"""How many half steps before and after the middle a strike on the outer raceway is looked for [-]: its speed is not known yet."""
SLOW = 2e-3
"""Speed below which a free roller's contact with the outer raceway may close or open as it will [m/s]: it is next to no energy."""


@piece
def filled(count: int) -> int:
    """Return how many lanes are worked on for ``count`` rollers: a multiple of `VECTOR`."""
    return (count + at.VECTOR - 1) // at.VECTOR * at.VECTOR


@piece
def place_rollers(payload: Payload, state: State, work: Workspace, pinned: bool) -> None:
    """Write places and pocket tangents of the rollers, how near their contacts are to closing, and who is bound.

    ``pinned`` says that all of them are: it is for the compiler, which leaves out what free ones need.
    """
    own, step, h, heading = state.lanes, work.light, payload.step, work.heading
    place, old, last = state.position, state.velocity, state.position.shape[0] - 1
    pitch, clearance = payload.pitch_radius, payload.pocket_clearance
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
    inner_reach, outer_reach = payload.inner_raceway_radius + payload.roller_radius, payload.outer_raceway_radius - payload.roller_radius
    slow_way = h * SLOW * outer_reach
    inner_square, outer_square = inner_reach * inner_reach, outer_reach * outer_reach
    first_at, second_at = (place[CAGE, 0], place[CAGE, 1]), (place[last, 0], place[last, 1])
    first_old, second_old = (old[CAGE, 0], old[CAGE, 1], old[CAGE, 2]), (old[last, 0], old[last, 1], old[last, 2])
    first_way, second_way = (heading[0, 0], heading[0, 1]), (heading[last - CAGE, 0], heading[last - CAGE, 1])
    for c in range(filled(payload.free.size)):
        second = own[at.IN_SECOND + c] > 0.0
        cage_x, cage_y = second_at[0] if second else first_at[0], second_at[1] if second else first_at[1]
        cosine, sine = second_way[0] if second else first_way[0], second_way[1] if second else first_way[1]
        px, py = own[at.POCKET_X + c], own[at.POCKET_Y + c]
        tx, ty = cosine * px - sine * py, sine * px + cosine * py
        x, y, bar_near, if_outer = cage_x + pitch * ty, cage_y - pitch * tx, -1.0, 1.0
        old_x, old_y = second_old[0] if second else first_old[0], second_old[1] if second else first_old[1]
        old_turn = second_old[2] if second else first_old[2]
        vx, vy = old_x + pitch * old_turn * tx, old_y + pitch * old_turn * ty
        if not pinned:
            free = own[at.FREE + c] > 0.0
            x, y = own[at.X + c] if free else x, own[at.Y + c] if free else y
            ax, ay = x - cage_x, y - cage_y
            vx, vy = own[at.VX + c] if free else vx, own[at.VY + c] if free else vy
            rate = (vx - old_x) * tx + (vy - old_y) * ty - old_turn * (ax * ty - ay * tx)
            bar_near = abs(ax * tx + ay * ty) + 0.5 * h * abs(rate) - clearance if free else -1.0
            if_outer = 0.0 if free else 1.0
        ix, iy, ox, oy = x - inner_x, y - inner_y, x - outer_x, y - outer_y
        # What counts is whether a contact is closed at the step's beginning, or will be at its end.
        inner_way = h * abs((vx - inner_vx) * ix + (vy - inner_vy) * iy)
        outer_way = h * abs((vx - outer_vx) * ox + (vy - outer_vy) * oy)
        inner_near, outer_deep = inner_square - ix * ix - iy * iy + inner_way, ox * ox + oy * oy - outer_square
        outer_near, outer_turns = outer_deep + outer_way, ABOUT * (outer_way - slow_way) - abs(outer_deep)
        nearest = max(max(inner_near, bar_near), max(if_outer * outer_near, outer_turns))
        step[at.PLACE_X + c], step[at.PLACE_Y + c], step[at.TAU_X + c], step[at.TAU_Y + c] = x, y, tx, ty
        step[at.OUTER_NEAR + c], step[at.BAR_NEAR + c], step[at.BOUND + c] = outer_near, bar_near, 1.0 if nearest > 0.0 else 0.0


@piece
def bar_at(payload: Payload, row: int, i: int, ahead: bool) -> bool:
    """Return whether there is a bar ahead of a roller, or behind it."""
    return not payload.broken[row, i if ahead else i - 1]


@piece
def bind_special(payload: Payload, work: Workspace) -> None:
    """Correct which rollers are bound where a bar is broken, or an edge gives the outer raceway normals of its own."""
    light, count = work.light, payload.free.shape[1]
    for k in range(payload.gaps.shape[0]):
        first = payload.gaps[k, 0] * count
        light[at.BOUND + first + payload.gaps[k, 1]] = light[at.BOUND + first + payload.gaps[k, 2]] = 1.0
    if payload.notch_law == EDGE and payload.outer_notches.row.size > 0:
        for c in range(payload.free.size):
            if light[at.OUTER_NEAR + c] > 0.0:
                light[at.BOUND + c] = 1.0


@piece
def bind_row(payload: Payload, work: Workspace, row: int, bound: int) -> int:
    """Write which of a row's rollers are bound, from lane ``bound`` on; return where they end."""
    light, count = work.light, payload.free.shape[1]
    first = max(row * count, 0)
    for i in range(count):
        if light[at.BOUND + first + i] > 0.0:
            work.order[bound], work.rows[bound] = first + i, row
            bound += 1
    return bound


@piece
def gather_bound(state: State, work: Workspace, bound: int) -> int:
    """Copy the bound rollers side by side, filled up to a multiple of `VECTOR`; return how many lanes that makes."""
    own, light, near = state.lanes, work.light, work.bound
    count = filled(bound)
    for k in range(bound, count):
        work.order[k], work.rows[k] = work.order[bound - 1], work.rows[bound - 1]
    for k in range(count):
        c = work.order[k]
        near[at.SECOND + k], near[at.MOVING + k] = 1.0 if work.rows[k] > 0 else 0.0, own[at.FREE + c]
        near[at.PLACE_X + k], near[at.PLACE_Y + k] = light[at.PLACE_X + c], light[at.PLACE_Y + c]
        near[at.TAU_X + k], near[at.TAU_Y + k], near[at.BAR_NEAR + k] = light[at.TAU_X + c], light[at.TAU_Y + c], light[at.BAR_NEAR + c]
        near[at.BEFORE_X + k], near[at.BEFORE_Y + k], near[at.BEFORE_RIM + k] = own[at.VX + c], own[at.VY + c], own[at.SPIN + c]
        near[at.COMING_X + k], near[at.COMING_Y + k] = own[at.CHANGE_X + c], own[at.CHANGE_Y + c]
        near[at.COMING_RIM + k] = own[at.CHANGE_SPIN + c]
        near[at.INNER + at.BRISTLE + k], near[at.OUTER + at.BRISTLE + k] = own[at.INNER_BRISTLE + c], own[at.OUTER_BRISTLE + c]
        near[at.BAR + at.BRISTLE + k] = own[at.BAR_BRISTLE + c]
        near[at.INNER + at.KNOWN + k], near[at.OUTER + at.KNOWN + k] = own[at.INNER_FORCE + c], own[at.OUTER_FORCE + c]
    return count


@piece
def expect_bound(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Write the velocities of bound rollers before the step, those expected over it, and those without contacts.

    Where they go, `gather_bound` has left velocities and spins, and their changes over the last step.
    """
    near, radius, pitch, last = work.bound, payload.roller_radius, payload.pitch_radius, work.mean.shape[0] - 1
    old, mean, fall = state.velocity, work.mean, 0.5 * payload.step * payload.gravity
    first_old, second_old = (
        (old[CAGE, 0], old[CAGE, 1], pitch * old[CAGE, 2]),
        (old[last, 0], old[last, 1], pitch * old[last, 2]),
    )
    first_mean = (mean[CAGE, 0], mean[CAGE, 1], pitch * mean[CAGE, 2])
    second_mean = (mean[last, 0], mean[last, 1], pitch * mean[last, 2])
    for k in range(count):
        second, moving, tx, ty = near[at.SECOND + k] > 0.0, near[at.MOVING + k] > 0.0, near[at.TAU_X + k], near[at.TAU_Y + k]
        old_x, old_y = second_old[0] if second else first_old[0], second_old[1] if second else first_old[1]
        mean_x, mean_y = second_mean[0] if second else first_mean[0], second_mean[1] if second else first_mean[1]
        old_rim, mean_rim = second_old[2] if second else first_old[2], second_mean[2] if second else first_mean[2]
        vx, vy, rim = near[at.BEFORE_X + k], near[at.BEFORE_Y + k], radius * near[at.BEFORE_RIM + k]
        coming_x, coming_y = vx + 0.5 * near[at.COMING_X + k], vy + 0.5 * near[at.COMING_Y + k]
        before_x, before_y = vx if moving else old_x + old_rim * tx, vy if moving else old_y + old_rim * ty
        near[at.BEFORE_X + k], near[at.BEFORE_Y + k], near[at.BEFORE_RIM + k] = before_x, before_y, rim
        near[at.ALONE_X + k], near[at.ALONE_Y + k], near[at.ALONE_RIM + k] = before_x, before_y - fall, rim
        near[at.COMING_X + k] = coming_x if moving else mean_x + mean_rim * tx
        near[at.COMING_Y + k] = coming_y if moving else mean_y + mean_rim * ty
        near[at.COMING_RIM + k] = rim + 0.5 * radius * near[at.COMING_RIM + k]


@piece
def push_neighbours(payload: Payload, work: Workspace) -> None:
    """Add what rollers do to each other across broken bars to the velocities that they would have without contacts."""
    near, rollers = work.bound, payload.free.shape[1]
    by_mass = 0.5 * payload.step / payload.roller_mass
    by_inertia = 0.5 * payload.step * payload.roller_radius * payload.roller_radius / payload.roller_inertia
    for k in range(work.ends[work.ends.size - 1]):
        row = work.rows[k]
        i = work.order[k] - row * rollers
        if payload.beside[row, i]:
            near[at.ALONE_X + k] += by_mass * work.external[row, i, 0]
            near[at.ALONE_Y + k] += by_mass * work.external[row, i, 1]
            near[at.ALONE_RIM + k] += by_inertia * work.external[row, i, 2]
