"""What a step leaves behind: forces, slips, bristles and velocities of the rollers, and the energy that it cost."""

from __future__ import annotations

from dcrb_ros.core import lanes as at
from dcrb_ros.core.friction import bristle_after
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import Floats, Payload
from dcrb_ros.core.state import CAGE, INNER, OUTER, State
from dcrb_ros.core.work import Workspace


@piece
def settle(lanes: Floats, contact: int, count: int, mean_x: float, mean_y: float, surface: float, side: float, step: float) -> None:
    """Write forces, slips and bristles of the contacts with a ring at the mean velocities found, and their powers.

    Those of the inner ring, where ``side`` is 1, begin the sums of a roller's powers anew, those of the outer are added.
    """
    contact, first = max(contact, 0), side > 0.0
    for c in range(count):
        nx, ny = lanes[contact + at.NORMAL_X + c], lanes[contact + at.NORMAL_Y + c]
        tx, ty = -lanes[contact + at.RADIAL_Y + c], lanes[contact + at.RADIAL_X + c]
        vx, vy, surface_n = lanes[at.MEAN_X + c] - mean_x, lanes[at.MEAN_Y + c] - mean_y, lanes[contact + at.SURFACE_N + c]
        approach = -side * (vx * nx + vy * ny - surface_n)
        slip = vx * tx + vy * ty - side * lanes[at.MEAN_RIM + c] - surface
        normal = lanes[contact + at.PUSH + c] + lanes[contact + at.GIVE + c] * approach
        friction = lanes[contact + at.CONSTANT + c] + lanes[contact + at.SLOPE + c] * slip
        sink = lanes[contact + at.SINK + c]
        closing, bristle = approach - sink, lanes[contact + at.BRISTLE + c]
        bent = bristle_after(bristle, slip, lanes[contact + at.RATE + c], lanes[contact + at.PHI + c], step)
        lanes[contact + at.FRICTION + c], lanes[contact + at.SLIP + c] = friction, slip
        known = lanes[contact + at.KNOWN + c]
        lanes[contact + at.KNOWN + c] = max(known + lanes[contact + at.DAMPING + c] * (closing - lanes[contact + at.EXPECTED + c]), 0.0)
        lanes[contact + at.BRISTLE + c] = bent if known > 0.0 else 0.0
        lost, spent = friction * slip, lanes[contact + at.DAMPING + c] * closing * closing
        taken, driven = normal * sink, side * normal * surface_n - friction * surface
        lanes[at.LOST_IN_FRICTION + c] = lost if first else lost + lanes[at.LOST_IN_FRICTION + c]
        lanes[at.LOST_IN_CONTACT + c] = spent if first else spent + lanes[at.LOST_IN_CONTACT + c]
        lanes[at.TAKEN_BY_NOTCH + c] = taken if first else taken + lanes[at.TAKEN_BY_NOTCH + c]
        lanes[at.DRIVEN + c] = driven if first else driven + lanes[at.DRIVEN + c]


@piece
def settle_bars(lanes: Floats, mean: Floats, count: int, step: float) -> None:
    """Write bristles of the contacts with bars, and add their powers; ``mean`` holds the velocities of all bodies."""
    contact, last = at.BAR, mean.shape[0] - 1
    first_x, first_y, first_turn = mean[CAGE, 0], mean[CAGE, 1], mean[CAGE, 2]
    second_x, second_y, second_turn = mean[last, 0], mean[last, 1], mean[last, 2]
    for k in range(count):
        nx, ny, sign = lanes[at.TAU_X + k], lanes[at.TAU_Y + k], lanes[contact + at.AHEAD + k]
        second = lanes[at.SECOND + k] > 0.0
        own_x, own_y, turn = second_x if second else first_x, second_y if second else first_y, second_turn if second else first_turn
        vx = lanes[at.MEAN_X + k] - own_x + turn * lanes[contact + at.LEVER_Y + k]
        vy = lanes[at.MEAN_Y + k] - own_y - turn * lanes[contact + at.LEVER_X + k]
        approach, slip = sign * (vx * nx + vy * ny), vx * ny - vy * nx - sign * lanes[at.MEAN_RIM + k]
        friction = lanes[contact + at.CONSTANT + k] + lanes[contact + at.SLOPE + k] * slip
        found = max(lanes[contact + at.PUSH + k] + lanes[contact + at.GIVE + k] * approach, 0.0)
        lanes[contact + at.KNOWN + k] = found if sign != 0.0 else 0.0
        bristle = lanes[contact + at.BRISTLE + k]
        bent = bristle_after(bristle, slip, lanes[contact + at.RATE + k], lanes[contact + at.PHI + k], step)
        lanes[contact + at.BRISTLE + k] = bent if sign != 0.0 else 0.0
        lanes[at.LOST_IN_FRICTION + k] += friction * slip
        lanes[at.LOST_IN_CONTACT + k] += lanes[contact + at.DAMPING + k] * approach * approach


@piece
def forget(state: State, count: int) -> None:
    """Leave all pinned rollers alone: nothing turns them, nothing touches them."""
    own = state.lanes
    for c in range(count):
        own[at.INNER_FORCE + c] = own[at.INNER_FRICTION + c] = own[at.INNER_BRISTLE + c] = 0.0
        own[at.OUTER_FORCE + c] = own[at.OUTER_FRICTION + c] = own[at.OUTER_BRISTLE + c] = own[at.CHANGE_SPIN + c] = 0.0


@piece
def keep_bound(payload: Payload, state: State, work: Workspace, count: int) -> None:
    """Keep what became of the bound rollers."""
    own, near, by_radius, h = state.lanes, work.bound, 1.0 / payload.roller_radius, payload.step
    surface = state.shaft[1] * payload.inner_raceway_radius
    settle(near, at.INNER, count, work.mean[INNER, 0], work.mean[INNER, 1], surface, 1.0, h)
    settle(near, at.OUTER, count, work.mean[OUTER, 0], work.mean[OUTER, 1], 0.0, -1.0, h)
    if payload.any_free:
        settle_bars(near, work.mean, count, h)
    for k in range(work.ends[work.ends.size - 1]):
        c = work.order[k]
        own[at.INNER_FORCE + c], own[at.OUTER_FORCE + c] = near[at.INNER + at.KNOWN + k], near[at.OUTER + at.KNOWN + k]
        own[at.INNER_FRICTION + c], own[at.OUTER_FRICTION + c] = near[at.INNER + at.FRICTION + k], near[at.OUTER + at.FRICTION + k]
        own[at.INNER_SLIP + c], own[at.OUTER_SLIP + c] = near[at.INNER + at.SLIP + k], near[at.OUTER + at.SLIP + k]
        own[at.INNER_BRISTLE + c], own[at.OUTER_BRISTLE + c] = near[at.INNER + at.BRISTLE + k], near[at.OUTER + at.BRISTLE + k]
        own[at.FRICTION_LOSS + c] += h * near[at.LOST_IN_FRICTION + k]
        own[at.CONTACT_LOSS + c] += h * near[at.LOST_IN_CONTACT + k]
        own[at.NOTCH_LOSS + c] += h * near[at.TAKEN_BY_NOTCH + k]
        own[at.DRIVE_WORK + c] += h * near[at.DRIVEN + k]
        before = near[at.BEFORE_RIM + k]
        own[at.CHANGE_SPIN + c] = 2.0 * (near[at.MEAN_RIM + k] - before) * by_radius
        own[at.SPIN + c] = (2.0 * near[at.MEAN_RIM + k] - before) * by_radius
        if near[at.MOVING + k] > 0.0:
            own[at.BAR_FORCE + c] = near[at.BAR + at.AHEAD + k] * near[at.BAR + at.KNOWN + k]
            own[at.BAR_BRISTLE + c] = near[at.BAR + at.BRISTLE + k]
            own[at.BAR_IMPACT + c] = near[at.BAR + at.IMPACT + k]
            x, y = near[at.MEAN_X + k], near[at.MEAN_Y + k]
            own[at.CHANGE_X + c], own[at.CHANGE_Y + c] = 2.0 * (x - near[at.BEFORE_X + k]), 2.0 * (y - near[at.BEFORE_Y + k])
            own[at.VX + c], own[at.VY + c] = 2.0 * x - near[at.BEFORE_X + k], 2.0 * y - near[at.BEFORE_Y + k]
