"""What is published of the state, gathered in one pass over the rollers: a hundred times a second it would cost more than the motion."""

from __future__ import annotations

import math

from dcrb_ros.core.jit import loop
from dcrb_ros.core.layout.records import Flags, Floats, OneRecord
from dcrb_ros.core.layout.rollers import Rollers
from dcrb_ros.core.layout.state import CAGE, INNER, OUTER

OBSERVED = 9
(AZIMUTH, SPEED, INNER_FORCE, OUTER_FORCE, SLIP, FRICTION, TORQUE, RELATIVE_SPEED, BAR_FORCE) = range(OBSERVED)
"""Rows of what is observed; see `dcrb_ros.stream.states.States`."""


@loop
def place_pinned(table: OneRecord[Rollers], free: Flags, tangent: Floats, position: Floats, velocity: Floats, pitch_radius: float) -> None:
    """Write position and velocity of the pinned rollers, which their cages carry, into the table of rollers."""
    rollers = table[0]
    for row in range(free.shape[0]):
        turn, vx, vy, speed = position[CAGE + row, 2], velocity[CAGE + row, 0], velocity[CAGE + row, 1], velocity[CAGE + row, 2]
        cosine, sine = math.cos(turn), math.sin(turn)
        for i in range(free.shape[1]):
            if not free[row, i]:
                c = row * free.shape[1] + i
                # A pocket lies a quarter turn behind its tangent.
                arm_x = pitch_radius * (sine * tangent[row, i, 0] + cosine * tangent[row, i, 1])
                arm_y = pitch_radius * (sine * tangent[row, i, 1] - cosine * tangent[row, i, 0])
                rollers.x[c], rollers.y[c] = position[CAGE + row, 0] + arm_x, position[CAGE + row, 1] + arm_y
                rollers.vx[c], rollers.vy[c] = vx - speed * arm_y, vy + speed * arm_x


@loop
def observe_rollers(
    table: OneRecord[Rollers], free: Flags, position: Floats, velocity: Floats, surface: float, roller_radius: float, found: Floats
) -> tuple[float, float]:
    """Write what is observed of each roller, shape (OBSERVED, rollers or more); return the force on the inner ring in X and Y [N].

    ``surface`` is the speed of the inner ring's surface [m/s]. The azimuth counts from -Y; the slip is that at the inner raceway,
    of open contacts too.
    """
    rollers, force_x, force_y = table[0], 0.0, 0.0
    for row in range(free.shape[0]):
        for i in range(free.shape[1]):
            c = row * free.shape[1] + i
            x, y, spin = rollers.x[c], rollers.y[c], rollers.spin[c]
            nx, ny = x - position[INNER, 0], y - position[INNER, 1]
            distance = math.sqrt(nx * nx + ny * ny)
            nx, ny = nx / distance, ny / distance
            passing = (rollers.vy[c] - velocity[INNER, 1]) * nx - (rollers.vx[c] - velocity[INNER, 0]) * ny
            normal, friction = rollers.inner.force[c], rollers.inner.friction[c]
            force_x -= normal * nx + friction * ny
            force_y += friction * nx - normal * ny
            found[AZIMUTH, c] = math.atan2(x - position[OUTER, 0], position[OUTER, 1] - y)
            found[SPEED, c], found[RELATIVE_SPEED, c] = spin, spin - velocity[CAGE + row, 2]
            found[INNER_FORCE, c], found[OUTER_FORCE, c] = normal, rollers.outer.force[c]
            found[SLIP, c] = passing - spin * roller_radius - surface
            found[FRICTION, c], found[TORQUE, c] = friction, roller_radius * (friction - rollers.outer.friction[c])
            found[BAR_FORCE, c] = rollers.bar.force[c]
    return force_x, force_y
