"""Contacts of bound rollers with the bars of their pockets, each as a straight line over the mean velocities of the step.

Few of them are closed at any time: one after the other, not all lanes at once.
"""

from __future__ import annotations

from dcrb_ros.core import lanes as at
from dcrb_ros.core.cage import LEAST_IMPACT, impact_damping, strike
from dcrb_ros.core.friction import friction_line
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import Floats, Payload
from dcrb_ros.core.place import bar_at
from dcrb_ros.core.state import State
from dcrb_ros.core.work import CAGE, Workspace


@piece
def clear_bars(near: Floats, count: int) -> None:
    """Write that no bar is touched."""
    for k in range(count):
        near[at.BAR + at.PUSH + k] = near[at.BAR + at.GIVE + k] = near[at.BAR + at.CONSTANT + k] = near[at.BAR + at.SLOPE + k] = 0.0
        near[at.BAR + at.KNOWN + k] = near[at.BAR + at.DAMPING + k] = near[at.BAR + at.RATE + k] = near[at.BAR + at.PHI + k] = 0.0
        near[at.BAR + at.AHEAD + k] = near[at.BAR + at.LEVER_X + k] = near[at.BAR + at.LEVER_Y + k] = 0.0
        near[at.BAR + at.IMPACT + k] = 0.0


@piece
def touch_bars(payload: Payload, state: State, work: Workspace, used: int, count: int) -> None:
    """Write the contacts of bound rollers with their bars: along the pocket's tangent, friction is radial."""
    near, radius, h = work.bound, payload.roller_radius, payload.step
    clear_bars(near, count)
    yielding = 0.5 * h / payload.roller_mass
    for k in range(used):
        if near[at.BAR_NEAR + k] <= 0.0:
            continue
        row = work.rows[k]
        i = work.order[k] - row * payload.free.shape[1]
        tx, ty = near[at.TAU_X + k], near[at.TAU_Y + k]
        ax, ay = near[at.PLACE_X + k] - state.cage_position[row, 0], near[at.PLACE_Y + k] - state.cage_position[row, 1]
        along = ax * tx + ay * ty
        ahead = along > 0.0
        if not bar_at(payload, row, i, ahead):
            continue
        sign = 1.0 if ahead else -1.0
        rx, ry = ax + sign * radius * tx, ay + sign * radius * ty
        body = CAGE + row
        turn, old_turn = work.mean[body, 2], state.cage_velocity[row, 2]
        vx, vy = near[at.COMING_X + k] - work.mean[body, 0] + turn * ry, near[at.COMING_Y + k] - work.mean[body, 1] - turn * rx
        ux = near[at.BEFORE_X + k] - state.cage_velocity[row, 0] + old_turn * ry
        uy = near[at.BEFORE_Y + k] - state.cage_velocity[row, 1] - old_turn * rx
        before = sign * (ux * tx + uy * ty)
        begin = abs(along) - payload.pocket_clearance - 0.5 * h * before
        last = abs(state.bar_force[row, i])
        force, slope, rate = strike(begin, sign * (vx * tx + vy * ty), last, yielding, h, payload.bar_coefficient, payload.bar_exponent)
        impact = state.bar_impact[row, i] if state.bar_impact[row, i] > 0.0 else max(before, LEAST_IMPACT)
        damping = impact_damping(force, rate, impact, payload.impact_loss)
        known, slip = force + damping * rate, vx * ty - vy * tx - sign * near[at.COMING_RIM + k]
        constant, line, relaxation, phi = friction_line(
            slip, near[at.BAR + at.BRISTLE + k], payload.bar_friction, payload.bar_friction, 0.0, payload
        )
        near[at.BAR + at.PUSH + k], near[at.BAR + at.GIVE + k] = force - slope * rate, slope + damping
        near[at.BAR + at.CONSTANT + k], near[at.BAR + at.SLOPE + k] = constant * known, line * known
        near[at.BAR + at.RATE + k], near[at.BAR + at.PHI + k] = relaxation, phi
        near[at.BAR + at.KNOWN + k], near[at.BAR + at.DAMPING + k] = known, damping
        near[at.BAR + at.AHEAD + k], near[at.BAR + at.LEVER_X + k], near[at.BAR + at.LEVER_Y + k] = sign, rx, ry
        near[at.BAR + at.IMPACT + k] = impact if force > 0.0 else 0.0
