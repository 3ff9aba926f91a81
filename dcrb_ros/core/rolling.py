"""Rollers that lie free on the outer raceway, or on nothing: most of those in pockets.

They need no solution together with others: the raceway's normal and tangent do not mix, each is a scalar equation. So a whole step of
such a roller is one pass of one loop, from its place to its new velocity, and nothing but its state goes through memory.
"""

from __future__ import annotations

import math

from dcrb_ros.core import lanes as at
from dcrb_ros.core.friction import bristle_after
from dcrb_ros.core.jit import piece
from dcrb_ros.core.normal import elastic, lasting_line
from dcrb_ros.core.payload import SINK, Payload
from dcrb_ros.core.place import filled
from dcrb_ros.core.state import OUTER, State
from dcrb_ros.core.touch import notch_depth, raceway_friction
from dcrb_ros.core.work import Workspace

LEAST_DISTANCE = 1e-12
"""Least distance from the ring's centre, for lanes without a roller [m]."""


@piece
def find_notches(payload: Payload, state: State, work: Workspace) -> None:
    """Write how much deeper free rollers stand over notches of the outer raceway or of their own, and how fast that grows."""
    light, count = work.light, payload.free.shape[1]
    for c in range(filled(payload.free.size)):
        light[at.CUT + c] = light[at.SINK + c] = light[at.OVER + c] = 0.0
    if payload.notch_law == SINK:
        reach, x, y = payload.outer_raceway_radius - payload.roller_radius, state.position[OUTER, 0], state.position[OUTER, 1]
        for k in range(payload.outer_notches.row.size):
            tx, ty, least = work.outer_towards[k, 0], work.outer_towards[k, 1], payload.outer_notches.nearness[k] * reach
            for c in range(payload.free.size):
                over = (light[at.PLACE_X + c] - x) * tx + (light[at.PLACE_Y + c] - y) * ty > least
                light[at.OVER + c] = 1.0 if over else light[at.OVER + c]
    for k in range(payload.roller_notches.row.size):
        light[at.OVER + payload.roller_notches.row[k] * count + payload.roller_notches.roller[k]] = 1.0
    for c in range(payload.free.size):
        if light[at.OVER + c] > 0.0 and light[at.OUTER_NEAR + c] > 0.0:
            sink_free(payload, state, work, c)


@piece
def sink_free(payload: Payload, state: State, work: Workspace, c: int) -> None:
    """Write depth and sinking of the notches under a free roller that touches the outer raceway."""
    own, row = state.lanes, c // payload.free.shape[1]
    dx, dy = own[at.X + c] - state.position[OUTER, 0], own[at.Y + c] - state.position[OUTER, 1]
    distance = math.sqrt(dx * dx + dy * dy)
    nx, ny = dx / distance, dy / distance
    vx = own[at.VX + c] + 0.5 * own[at.CHANGE_X + c] - work.mean[OUTER, 0]
    vy = own[at.VY + c] + 0.5 * own[at.CHANGE_Y + c] - work.mean[OUTER, 1]
    orbit, spin = (vy * nx - vx * ny) / distance, own[at.SPIN + c] + 0.5 * own[at.CHANGE_SPIN + c]
    depth, sink = notch_depth(payload, state, work, row, c - row * payload.free.shape[1], nx, ny, orbit, spin, False)
    work.light[at.CUT + c], work.light[at.SINK + c] = depth, sink


@piece
def roll_free(payload: Payload, state: State, work: Workspace, johnson: bool) -> None:
    """Move all rollers over the step as if none were bound; what bound ones did is put in its place afterwards."""
    own, light, h, radius = state.lanes, work.light, payload.step, payload.roller_radius
    by_mass, by_inertia = 0.5 * h / payload.roller_mass, 0.5 * h * radius * radius / payload.roller_inertia
    by_radius, fall, reach = 1.0 / radius, by_mass * payload.roller_mass * payload.gravity, payload.outer_raceway_radius - radius
    ring_x, ring_y, mean_x, mean_y = state.position[OUTER, 0], state.position[OUTER, 1], work.mean[OUTER, 0], work.mean[OUTER, 1]
    old_x, old_y = state.velocity[OUTER, 0], state.velocity[OUTER, 1]
    for c in range(filled(payload.free.size)):
        dx, dy = own[at.X + c] - ring_x, own[at.Y + c] - ring_y
        distance = max(math.sqrt(dx * dx + dy * dy), LEAST_DISTANCE)
        nx, ny, sink, bristle = dx / distance, dy / distance, light[at.SINK + c], own[at.OUTER_BRISTLE + c]

        own_x, own_y, spin = own[at.VX + c], own[at.VY + c], own[at.SPIN + c]
        vx, vy = own_x + 0.5 * own[at.CHANGE_X + c] - mean_x, own_y + 0.5 * own[at.CHANGE_Y + c] - mean_y
        along, rim = vy * nx - vx * ny, radius * spin
        before = (own_x - old_x) * nx + (own_y - old_y) * ny - sink
        force, stiffness = elastic(distance - reach - light[at.CUT + c], payload.outer_scale, johnson, payload)
        push, give, known, damping, expected = lasting_line(force, stiffness, vx * nx + vy * ny - sink, before, sink, payload)
        coming_slip = along + rim + 0.5 * radius * own[at.CHANGE_SPIN + c]
        constant, slope, rate, phi = raceway_friction(coming_slip, bristle, along, distance, 0.0, known, False, payload)
        constant, slope = constant * known, slope * known

        alone_x, alone_y = own_x - mean_x, own_y - fall - mean_y
        normal = (push + give * (alone_x * nx + alone_y * ny)) / (1.0 + by_mass * give)
        friction = (constant + slope * (alone_y * nx - alone_x * ny + rim)) / (1.0 + (by_mass + by_inertia) * slope)
        fx, fy = normal * nx - friction * ny, normal * ny + friction * nx
        x, y, turned = alone_x - by_mass * fx, alone_y - by_mass * fy, rim - by_inertia * friction
        slip, closing = y * nx - x * ny + turned, x * nx + y * ny - sink
        bent, found = bristle_after(bristle, slip, rate, phi, h), max(known + damping * (closing - expected), 0.0)

        bound = light[at.BOUND + c]
        light[at.ON_OUTER_X + c], light[at.ON_OUTER_Y + c] = (1.0 - bound) * fx, (1.0 - bound) * fy
        change_x, change_y, change = 2.0 * (x + mean_x - own_x), 2.0 * (y + mean_y - own_y), 2.0 * (turned - rim) * by_radius
        own[at.CHANGE_X + c], own[at.CHANGE_Y + c], own[at.CHANGE_SPIN + c] = change_x, change_y, change
        own[at.VX + c], own[at.VY + c], own[at.SPIN + c] = own_x + change_x, own_y + change_y, spin + change
        own[at.OUTER_FORCE + c], own[at.OUTER_FRICTION + c], own[at.OUTER_SLIP + c] = found, friction, slip
        own[at.OUTER_BRISTLE + c] = bent if known > 0.0 else 0.0
        time = h * (1.0 - bound)
        own[at.FRICTION_LOSS + c] += time * friction * slip
        own[at.CONTACT_LOSS + c] += time * damping * closing * closing
        own[at.NOTCH_LOSS + c] += time * normal * sink


@piece
def let_go(payload: Payload, state: State, work: Workspace) -> None:
    """Forget the inner raceway and the bars of rollers that do not touch them."""
    own, light = state.lanes, work.light
    for c in range(filled(payload.free.size)):
        touching = light[at.BOUND + c]
        own[at.INNER_FORCE + c] *= touching
        own[at.INNER_FRICTION + c] *= touching
        own[at.INNER_BRISTLE + c] *= touching
        own[at.BAR_FORCE + c] *= touching
        own[at.BAR_BRISTLE + c] *= touching
        own[at.BAR_IMPACT + c] *= touching


@piece
def push_free(payload: Payload, work: Workspace) -> None:
    """Add what free rollers that are not bound do to the outer ring."""
    x, y = 0.0, 0.0
    for c in range(payload.free.size):
        x += work.light[at.ON_OUTER_X + c]
        y += work.light[at.ON_OUTER_Y + c]
    work.loose[OUTER, 0] += x
    work.loose[OUTER, 1] += y
