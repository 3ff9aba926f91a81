"""The rollers at the middle of a step: where they are, how they are expected to move, and which are bound.

A roller is bound when what it does to rings and cage must be solved for together with them: it is pinned and touches a raceway, it touches
the inner ring or a bar, or it lies beside a broken bar. The others are free and lie on the outer raceway, or on nothing.
"""

from __future__ import annotations

from dcrb_ros.core import lanes as at
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import EDGE, Payload
from dcrb_ros.core.state import State
from dcrb_ros.core.work import CAGE, Workspace


@piece
def place_row(payload: Payload, state: State, work: Workspace, row: int) -> None:
    """Write places, pocket tangents and velocities of a row's rollers, and how near each contact is to closing."""
    own, step, radius, h = state.lanes, work.light, payload.roller_radius, payload.step
    cage_x, cage_y = state.cage_position[row, 0], state.cage_position[row, 1]
    cosine, sine = work.heading[row, 0], work.heading[row, 1]
    pitch, clearance, fall = payload.pitch_radius, payload.pocket_clearance, 0.5 * h * payload.gravity
    old_x, old_y, old_turn = state.cage_velocity[row, 0], state.cage_velocity[row, 1], state.cage_velocity[row, 2]
    mean_x, mean_y, mean_rim = work.mean[CAGE + row, 0], work.mean[CAGE + row, 1], pitch * work.mean[CAGE + row, 2]
    old_rim = pitch * old_turn
    inner_x, inner_y, outer_x, outer_y = state.inner_position[0], state.inner_position[1], state.outer_position[0], state.outer_position[1]
    inner_reach, outer_reach = payload.inner_raceway_radius + radius, payload.outer_raceway_radius - radius
    inner_square, outer_square = inner_reach * inner_reach, outer_reach * outer_reach
    first, count = max(row * payload.free.shape[1], 0), payload.free.shape[1]
    for i in range(count):
        c = first + i
        free = own[at.FREE + c] > 0.0
        px, py = own[at.POCKET_X + c], own[at.POCKET_Y + c]
        tx, ty = cosine * px - sine * py, sine * px + cosine * py
        own_x, own_y, vx, vy = own[at.X + c], own[at.Y + c], own[at.VX + c], own[at.VY + c]
        coming_x, coming_y = vx + 0.5 * own[at.CHANGE_X + c], vy + 0.5 * own[at.CHANGE_Y + c]
        x, y = own_x if free else cage_x + pitch * ty, own_y if free else cage_y - pitch * tx
        before_x, before_y = vx if free else old_x + old_rim * tx, vy if free else old_y + old_rim * ty
        rim = radius * own[at.SPIN + c]
        step[at.PLACE_X + c], step[at.PLACE_Y + c], step[at.TAU_X + c], step[at.TAU_Y + c] = x, y, tx, ty
        step[at.BEFORE_X + c], step[at.BEFORE_Y + c], step[at.BEFORE_RIM + c] = before_x, before_y, rim
        step[at.ALONE_X + c], step[at.ALONE_Y + c], step[at.ALONE_RIM + c] = before_x, before_y - fall, rim
        step[at.COMING_X + c] = coming_x if free else mean_x + mean_rim * tx
        step[at.COMING_Y + c] = coming_y if free else mean_y + mean_rim * ty
        step[at.COMING_RIM + c] = rim + 0.5 * radius * own[at.CHANGE_SPIN + c]
        step[at.MOVING + c] = own[at.FREE + c]
        step[at.OUTER + at.BRISTLE + c] = own[at.OUTER_BRISTLE + c]
        ix, iy, ox, oy = x - inner_x, y - inner_y, x - outer_x, y - outer_y
        inner_near, outer_near = inner_square - ix * ix - iy * iy, ox * ox + oy * oy - outer_square
        ax, ay = x - cage_x, y - cage_y
        # A bar counts where the roller touches it at the step's beginning, or will at its end.
        rate = (before_x - old_x) * tx + (before_y - old_y) * ty - old_turn * (ax * ty - ay * tx)
        bar_near = abs(ax * tx + ay * ty) + 0.5 * h * abs(rate) - clearance if free else -1.0
        if_outer = 0.0 if free else outer_near
        nearest = max(max(inner_near, bar_near), if_outer)
        step[at.OUTER_NEAR + c], step[at.BAR_NEAR + c], step[at.BOUND + c] = outer_near, bar_near, 1.0 if nearest > 0.0 else 0.0


@piece
def bar_at(payload: Payload, row: int, i: int, ahead: bool) -> bool:
    """Return whether there is a bar ahead of a roller, or behind it."""
    return not payload.broken[row, i if ahead else i - 1]


@piece
def bind_special(payload: Payload, work: Workspace, row: int) -> None:
    """Correct which rollers are bound where a bar is broken, or an edge gives the outer raceway normals of its own."""
    light, count = work.light, payload.free.shape[1]
    edges = payload.notch_law == EDGE and payload.outer_notches.row.size > 0
    for i in range(count):
        c = row * count + i
        if payload.beside[row, i] or (edges and light[at.OUTER_NEAR + c] > 0.0):
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
def gather_bound(payload: Payload, state: State, work: Workspace, bound: int) -> int:
    """Copy the bound rollers side by side, filled up to a multiple of `VECTOR`; return how many lanes that makes."""
    own, light, near = state.lanes, work.light, work.bound
    count = (bound + at.VECTOR - 1) // at.VECTOR * at.VECTOR
    for k in range(bound, count):
        work.order[k], work.rows[k] = work.order[bound - 1], work.rows[bound - 1]
    by_mass = 0.5 * payload.step / payload.roller_mass
    by_inertia = 0.5 * payload.step * payload.roller_radius * payload.roller_radius / payload.roller_inertia
    rollers = payload.free.shape[1]
    for k in range(count):
        c, row = work.order[k], work.rows[k]
        i = c - row * rollers
        near[at.PLACE_X + k], near[at.PLACE_Y + k] = light[at.PLACE_X + c], light[at.PLACE_Y + c]
        near[at.TAU_X + k], near[at.TAU_Y + k] = light[at.TAU_X + c], light[at.TAU_Y + c]
        near[at.BEFORE_X + k], near[at.BEFORE_Y + k] = light[at.BEFORE_X + c], light[at.BEFORE_Y + c]
        near[at.SECOND + k] = 1.0 if row > 0 else 0.0
        near[at.BEFORE_RIM + k], near[at.MOVING + k] = light[at.BEFORE_RIM + c], light[at.MOVING + c]
        near[at.COMING_X + k], near[at.COMING_Y + k] = light[at.COMING_X + c], light[at.COMING_Y + c]
        near[at.COMING_RIM + k] = light[at.COMING_RIM + c]
        near[at.ALONE_X + k] = light[at.ALONE_X + c] + by_mass * work.external[row, i, 0]
        near[at.ALONE_Y + k] = light[at.ALONE_Y + c] + by_mass * work.external[row, i, 1]
        near[at.ALONE_RIM + k] = light[at.ALONE_RIM + c] + by_inertia * work.external[row, i, 2]
        near[at.INNER + at.BRISTLE + k], near[at.OUTER + at.BRISTLE + k] = own[at.INNER_BRISTLE + c], own[at.OUTER_BRISTLE + c]
        near[at.BAR + at.BRISTLE + k], near[at.BAR_NEAR + k] = own[at.BAR_BRISTLE + c], light[at.BAR_NEAR + c]
    return count
