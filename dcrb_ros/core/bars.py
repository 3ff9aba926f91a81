"""Conformal contacts: cages with their lands, and bound rollers with the bars of their pockets.

Few of them are closed at any time. They are found one by one and put side by side, so that their law, three powers each, is
worked out for all of them at once.
"""

from __future__ import annotations

import math

from dcrb_ros.core import lanes as at
from dcrb_ros.core.cage import LEAST_IMPACT, impact_damping, strike
from dcrb_ros.core.friction import bristle_after, friction_line
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import Floats, Integers, Payload
from dcrb_ros.core.place import bar_at, filled
from dcrb_ros.core.state import CAGE, FRICTION, LOSS, OUTER, State
from dcrb_ros.core.work import Workspace

CONCENTRIC = 1e-15
"""Least distance of two centres, so that there is a direction from one to the other [m]."""


@piece
def find_lands(payload: Payload, state: State, work: Workspace) -> int:
    """Write how the cages in reach of the outer ring's land lie to it, in the first conformal lanes; return where they end."""
    lanes, h, found = work.conformal, payload.step, 0
    for row in range(payload.free.shape[0]):
        dx, dy = state.position[CAGE + row, 0] - state.position[OUTER, 0], state.position[CAGE + row, 1] - state.position[OUTER, 1]
        distance = max(math.sqrt(dx * dx + dy * dy), CONCENTRIC)
        nx, ny = dx / distance, dy / distance
        before = (state.velocity[CAGE + row, 0] - state.velocity[OUTER, 0]) * nx + (
            state.velocity[CAGE + row, 1] - state.velocity[OUTER, 1]
        ) * ny
        if distance + 0.5 * h * abs(before) <= payload.land_clearance:
            state.land_force[row] = state.land_impact[row] = state.land_bristle[row] = 0.0
            continue
        vx, vy = work.mean[CAGE + row, 0] - work.mean[OUTER, 0], work.mean[CAGE + row, 1] - work.mean[OUTER, 1]
        lanes[at.TOWARDS_X + found], lanes[at.TOWARDS_Y + found] = nx, ny
        lanes[at.BEGIN + found] = distance - payload.land_clearance - 0.5 * h * before
        lanes[at.BEFORE + found], lanes[at.CLOSING + found] = before, vx * nx + vy * ny
        lanes[at.SLIDING + found] = vy * nx - vx * ny + payload.land_radius * work.mean[CAGE + row, 2]
        lanes[at.LAST + found], lanes[at.CLOSED_AT + found] = state.land_force[row], state.land_impact[row]
        lanes[at.BENT + found] = state.land_bristle[row]
        lanes[at.COEFFICIENT + found], lanes[at.EXPONENT + found] = payload.land_coefficient, payload.land_exponent
        lanes[at.LIGHTNESS + found] = 0.5 * h * (1.0 / payload.train_mass[row] + 1.0 / payload.outer_ring_mass)
        work.touched[found] = row
        found += 1
    return found


@piece
def find_bars(payload: Payload, state: State, work: Workspace, found: int) -> int:
    """Write how bound rollers lie to bars in reach, from lane ``found`` of the conformal contacts on; return where they end."""
    near, lanes, radius, h = work.bound, work.conformal, payload.roller_radius, payload.step
    for k in range(work.ends[work.ends.size - 1]):
        if near[at.BAR_NEAR + k] <= 0.0:
            continue
        c, row = work.order[k], work.rows[k]
        tx, ty = near[at.TAU_X + k], near[at.TAU_Y + k]
        ax, ay = near[at.PLACE_X + k] - state.position[CAGE + row, 0], near[at.PLACE_Y + k] - state.position[CAGE + row, 1]
        along = ax * tx + ay * ty
        ahead = along > 0.0
        if not bar_at(payload, row, c - row * payload.free.shape[1], ahead):
            continue
        sign = 1.0 if ahead else -1.0
        rx, ry = ax + sign * radius * tx, ay + sign * radius * ty
        body = CAGE + row
        turn, old_turn = work.mean[body, 2], state.velocity[CAGE + row, 2]
        vx, vy = near[at.COMING_X + k] - work.mean[body, 0] + turn * ry, near[at.COMING_Y + k] - work.mean[body, 1] - turn * rx
        ux = near[at.BEFORE_X + k] - state.velocity[CAGE + row, 0] + old_turn * ry
        uy = near[at.BEFORE_Y + k] - state.velocity[CAGE + row, 1] - old_turn * rx
        before = sign * (ux * tx + uy * ty)
        lanes[at.BEGIN + found], lanes[at.BEFORE + found] = abs(along) - payload.pocket_clearance - 0.5 * h * before, before
        lanes[at.CLOSING + found] = sign * (vx * tx + vy * ty)
        lanes[at.SLIDING + found] = vx * ty - vy * tx - sign * near[at.COMING_RIM + k]
        lanes[at.LAST + found], lanes[at.CLOSED_AT + found] = abs(state.lanes[at.BAR_FORCE + c]), state.lanes[at.BAR_IMPACT + c]
        lanes[at.BENT + found] = near[at.BAR + at.BRISTLE + k]
        lanes[at.COEFFICIENT + found], lanes[at.EXPONENT + found] = payload.bar_coefficient, payload.bar_exponent
        lanes[at.LIGHTNESS + found] = 0.5 * h / payload.roller_mass
        near[at.BAR + at.AHEAD + k], near[at.BAR + at.LEVER_X + k], near[at.BAR + at.LEVER_Y + k] = sign, rx, ry
        work.touched[found] = k
        found += 1
    return found


@piece
def meet(payload: Payload, lanes: Floats, found: int) -> None:
    """Write the law of all conformal contacts found: elastic force and its slope, damping, friction."""
    count = filled(found)
    for c in range(found, count):
        lanes[at.BEGIN + c], lanes[at.CLOSING + c], lanes[at.BEFORE + c], lanes[at.LAST + c] = -1.0, 0.0, 0.0, 0.0
    for c in range(count):
        force, give, rate = strike(
            lanes[at.BEGIN + c],
            lanes[at.CLOSING + c],
            lanes[at.LAST + c],
            lanes[at.LIGHTNESS + c],
            payload.step,
            lanes[at.COEFFICIENT + c],
            lanes[at.EXPONENT + c],
        )
        closed_at = lanes[at.CLOSED_AT + c]
        impact = closed_at if closed_at > 0.0 else max(lanes[at.BEFORE + c], LEAST_IMPACT)
        damping = impact_damping(force, rate, impact, payload.impact_loss)
        constant, slope, relaxation, phi = friction_line(
            lanes[at.SLIDING + c], lanes[at.BENT + c], payload.bar_friction, payload.bar_friction, 0.0, payload
        )
        lanes[at.ELASTIC + c], lanes[at.YIELD + c], lanes[at.CLOSING + c], lanes[at.LOSING + c] = force, give, rate, damping
        lanes[at.HOLD + c], lanes[at.HOLD_SLOPE + c] = constant, slope
        lanes[at.RELAXATION + c], lanes[at.WEIGHT + c] = relaxation, phi
        lanes[at.CLOSED_AT + c] = impact if force > 0.0 else 0.0


@piece
def land_rate(lanes: Floats, mean: Floats, c: int, row: int) -> float:
    """Return the speed of penetration of a cage's contact with its land at the present mean velocities [m/s]."""
    vx, vy = mean[CAGE + row, 0] - mean[OUTER, 0], mean[CAGE + row, 1] - mean[OUTER, 1]
    rate: float = vx * lanes[at.TOWARDS_X + c] + vy * lanes[at.TOWARDS_Y + c]
    return rate


@piece
def push_lands(payload: Payload, work: Workspace, lands: int) -> None:
    """Add what the cages and the outer ring's lands do to each other at the present mean velocities to the forces on both."""
    lanes = work.conformal
    for c in range(lands):
        row = work.touched[c]
        rate = land_rate(lanes, work.mean, c, row)
        force = max(lanes[at.ELASTIC + c] + lanes[at.YIELD + c] * (rate - lanes[at.CLOSING + c]) + lanes[at.LOSING + c] * rate, 0.0)
        # The mean velocities are those under the force before: a step of Newton's method, or a stiff land would swing up.
        yielding = lanes[at.LIGHTNESS + c] * (lanes[at.YIELD + c] + lanes[at.LOSING + c])
        normal = (force + yielding * lanes[at.LAST + c]) / (1.0 + yielding)
        lanes[at.LAST + c] = normal
        friction = normal * (lanes[at.HOLD + c] + lanes[at.HOLD_SLOPE + c] * lanes[at.SLIDING + c])
        nx, ny = lanes[at.TOWARDS_X + c], lanes[at.TOWARDS_Y + c]
        fx, fy = -normal * nx + friction * ny, -normal * ny - friction * nx
        work.tight[CAGE + row, 0] += fx
        work.tight[CAGE + row, 1] += fy
        work.tight[CAGE + row, 2] -= payload.land_radius * friction
        work.tight[OUTER, 0] -= fx
        work.tight[OUTER, 1] -= fy


@piece
def keep_lands(payload: Payload, state: State, work: Workspace, lands: int) -> None:
    """Keep what became of the contacts of the cages with their lands."""
    lanes, h = work.conformal, payload.step
    for c in range(lands):
        row = work.touched[c]
        normal, rate, slip = lanes[at.LAST + c], land_rate(lanes, work.mean, c, row), lanes[at.SLIDING + c]
        bent = bristle_after(lanes[at.BENT + c], slip, lanes[at.RELAXATION + c], lanes[at.WEIGHT + c], h)
        state.land_force[row], state.land_bristle[row] = normal, bent if normal > 0.0 else 0.0
        state.land_impact[row] = lanes[at.CLOSED_AT + c]
        state.account[FRICTION] += h * normal * (lanes[at.HOLD + c] + lanes[at.HOLD_SLOPE + c] * slip) * slip
        state.account[LOSS] += h * lanes[at.LOSING + c] * rate * rate


@piece
def draw_bars(near: Floats, lanes: Floats, touched: Integers, lands: int, found: int) -> None:
    """Write contacts with bars as lines over the mean velocities of the step; the normal is the pocket's tangent, friction radial."""
    for c in range(lands, found):
        k, force, slope, rate = touched[c], lanes[at.ELASTIC + c], lanes[at.YIELD + c], lanes[at.CLOSING + c]
        damping = lanes[at.LOSING + c]
        known = force + damping * rate
        near[at.BAR + at.PUSH + k], near[at.BAR + at.GIVE + k] = force - slope * rate, slope + damping
        near[at.BAR + at.CONSTANT + k], near[at.BAR + at.SLOPE + k] = lanes[at.HOLD + c] * known, lanes[at.HOLD_SLOPE + c] * known
        near[at.BAR + at.RATE + k], near[at.BAR + at.PHI + k] = lanes[at.RELAXATION + c], lanes[at.WEIGHT + c]
        near[at.BAR + at.KNOWN + k], near[at.BAR + at.DAMPING + k] = known, damping
        near[at.BAR + at.IMPACT + k] = lanes[at.CLOSED_AT + c]


@piece
def clear_bars(near: Floats, count: int) -> None:
    """Write that no bar is touched."""
    for k in range(count):
        near[at.BAR + at.PUSH + k] = near[at.BAR + at.GIVE + k] = near[at.BAR + at.CONSTANT + k] = near[at.BAR + at.SLOPE + k] = 0.0
        near[at.BAR + at.KNOWN + k] = near[at.BAR + at.DAMPING + k] = near[at.BAR + at.RATE + k] = near[at.BAR + at.PHI + k] = 0.0
        near[at.BAR + at.AHEAD + k] = near[at.BAR + at.LEVER_X + k] = near[at.BAR + at.LEVER_Y + k] = 0.0
        near[at.BAR + at.IMPACT + k] = 0.0


@piece
def touch_cages(payload: Payload, state: State, work: Workspace, count: int) -> int:
    """Write the contacts of cages with lands and of bound rollers, in ``count`` lanes, with bars; return how many lands are touched."""
    lands = find_lands(payload, state, work)
    found = lands
    if payload.any_free:
        clear_bars(work.bound, count)
        found = find_bars(payload, state, work, lands)
    if found > 0:
        meet(payload, work.conformal, found)
        draw_bars(work.bound, work.conformal, work.touched, lands, found)
    return lands
