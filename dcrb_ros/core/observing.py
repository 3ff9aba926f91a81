"""What is published of the state, gathered in one pass over the rollers: a hundred times a second it would cost more than the motion."""

from __future__ import annotations

import math

from dcrb_ros.core import lanes as at
from dcrb_ros.core.jit import loop
from dcrb_ros.core.payload import Flags, Floats
from dcrb_ros.core.state import CAGE, INNER, OUTER

OBSERVED = 9
(AZIMUTH, SPEED, INNER_FORCE, OUTER_FORCE, SLIP, FRICTION, TORQUE, RELATIVE_SPEED, BAR_FORCE) = range(OBSERVED)
"""Rows of what is observed; see `dcrb_ros.bearing.states.States`."""


@loop
def place_pinned(lanes: Floats, free: Flags, tangent: Floats, position: Floats, velocity: Floats, pitch_radius: float) -> None:
    """Write position and velocity of the pinned rollers, which their cages carry, into the lanes."""
    for row in range(free.shape[0]):
        turn, vx, vy, speed = position[CAGE + row, 2], velocity[CAGE + row, 0], velocity[CAGE + row, 1], velocity[CAGE + row, 2]
        cosine, sine = math.cos(turn), math.sin(turn)
        for i in range(free.shape[1]):
            if not free[row, i]:
                c = row * free.shape[1] + i
                # A pocket lies a quarter turn behind its tangent.
                arm_x = pitch_radius * (sine * tangent[row, i, 0] + cosine * tangent[row, i, 1])
                arm_y = pitch_radius * (sine * tangent[row, i, 1] - cosine * tangent[row, i, 0])
                lanes[at.X + c], lanes[at.Y + c] = position[CAGE + row, 0] + arm_x, position[CAGE + row, 1] + arm_y
                lanes[at.VX + c], lanes[at.VY + c] = vx - speed * arm_y, vy + speed * arm_x


@loop
def observe_rollers(
    lanes: Floats, free: Flags, position: Floats, velocity: Floats, surface: float, roller_radius: float, found: Floats
) -> tuple[float, float]:
    """Write what is observed of each roller, shape (OBSERVED, rollers or more); return the force on the inner ring in X and Y [N].

    ``surface`` is the speed of the inner ring's surface [m/s]. The azimuth counts from -Y; the slip is that at the inner raceway,
    of open contacts too.
    """
    force_x = force_y = 0.0
    for row in range(free.shape[0]):
        for i in range(free.shape[1]):
            c = row * free.shape[1] + i
            x, y, spin = lanes[at.X + c], lanes[at.Y + c], lanes[at.SPIN + c]
            nx, ny = x - position[INNER, 0], y - position[INNER, 1]
            distance = math.sqrt(nx * nx + ny * ny)
            nx, ny = nx / distance, ny / distance
            passing = (lanes[at.VY + c] - velocity[INNER, 1]) * nx - (lanes[at.VX + c] - velocity[INNER, 0]) * ny
            push, hold = lanes[at.INNER_FORCE + c], lanes[at.INNER_FRICTION + c]
            force_x -= push * nx + hold * ny
            force_y += hold * nx - push * ny
            found[AZIMUTH, c] = math.atan2(x - position[OUTER, 0], position[OUTER, 1] - y)
            found[SPEED, c], found[RELATIVE_SPEED, c] = spin, spin - velocity[CAGE + row, 2]
            found[INNER_FORCE, c], found[OUTER_FORCE, c] = push, lanes[at.OUTER_FORCE + c]
            found[SLIP, c] = passing - spin * roller_radius - surface
            found[FRICTION, c], found[TORQUE, c] = hold, roller_radius * (hold - lanes[at.OUTER_FRICTION + c])
            found[BAR_FORCE, c] = lanes[at.BAR_FORCE + c]
    return force_x, force_y
