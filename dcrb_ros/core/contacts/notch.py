"""Notches in raceways and rollers, by two laws.

*Sink*, the paper's (Eqs. 8, 9 and 13 to 15): the surface lies deeper by how far the roller sinks between the edges; the
contact keeps the raceway's normal. *Edge*: each edge is a fillet with a contact normal of its own, and the floor lies
deeper by h; then the blow has a tangential part, and the contact's energy a potential. Both edges and the floor press on one roller beside
each other, so that each sinks where the others press: see `joined`.
"""

from __future__ import annotations

import math
from typing import Any

from dcrb_ros.core.jit import YES, kernel
from dcrb_ros.core.laws.calls import normal_force
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.payload import Notches, Payload, RollerNotches

SEPARATION = 1e-4
"""Sink depth between two contacts at which half of the influence of one on the other is left [m], a choice. For edges 2 mm apart on an
outer raceway 0.78 is left, 0.80 by the elastic half-space."""
LEAST_WAY = 1e-12
"""Least way over a notch in a step, for a roller at rest [rad]."""


@kernel
def inner_notch_depth(edge: float, depth: float, raceway: float, roller: float) -> float:
    """Return the depth [m] at an angle ``edge`` [rad] inside the nearer edge of an inner notch, Eq. 8.

    A notch on the roller against either raceway follows from it by exchanging the bodies.
    """
    sine, cosine = math.sin(edge), math.cos(edge)
    return min(raceway * (1.0 - cosine) + roller - math.sqrt(roller * roller - raceway * raceway * sine * sine), depth)


@kernel
def outer_notch_depth(edge: float, depth: float, raceway: float, roller: float) -> float:
    """Return the depth [m] at an angle ``edge`` [rad] inside the nearer edge of an outer notch, Eq. 14."""
    sine, cosine = math.sin(edge), math.cos(edge)
    return min(raceway * (cosine - 1.0) + roller - math.sqrt(roller * roller - raceway * raceway * sine * sine), depth)


@kernel
def roller_notch_depth(edge: float, depth: float, raceway: float, roller: float, inner: bool) -> float:
    """Return the depth [m] at an angle ``edge`` [rad] inside the nearer edge of a notch on the roller.

    Its two edges lie on the inner raceway as on the roller of Eq. 8; on the outer, which is hollow, they sink less.
    """
    if inner:
        return inner_notch_depth(edge, depth, roller, raceway)
    sine, cosine = math.sin(edge), math.cos(edge)
    return min(roller * (1.0 - cosine) + math.sqrt(raceway * raceway - roller * roller * sine * sine) - raceway, depth)


@kernel
def passed(
    offset: float,
    way: float,
    half_angle: float,
    bottom: float,
    kink: float,
    depth: float,
    raceway: float,
    roller: float,
    inner: bool,
    on_roller: bool,
) -> tuple[float, float]:
    """Return the depth of a notch ``offset`` [rad] from its middle, for a step over a ``way`` [rad] there, and its change over it [m].

    At the ends of the ``bottom`` [rad] on either side of the middle the slope drops by ``kink`` [m/rad], within a step: no single depth
    represents it. Leapfrog joins one step's middle to the next, so the depth is the mean over a step before and after, with weights
    that fall to zero there. ``on_roller`` says that the notch is the roller's.
    """
    offsets, shares = (offset, offset - 0.5 * way, offset + 0.5 * way), (0.0, -1.0, 1.0)
    middle, change = 0.0, 0.0
    for k in range(len(offsets)):
        edge = max(half_angle - abs(offsets[k]), 0.0)
        if on_roller:
            here = roller_notch_depth(edge, depth, raceway, roller, inner)
        elif inner:
            here = inner_notch_depth(edge, depth, raceway, roller)
        else:
            here = outer_notch_depth(edge, depth, raceway, roller)
        middle = here if k == 0 else middle
        change += shares[k] * here
    reach = max(abs(way), LEAST_WAY)
    before, after = max(1.0 - abs(offset - bottom) / reach, 0.0), max(1.0 - abs(offset + bottom) / reach, 0.0)
    return middle - kink * reach * (before * before * before + after * after * after) / 6.0, change


@kernel
def turn_notches(notches: Notches, turn: float, direction: Floats) -> None:
    """Write the directions of a ring's notches, shape (notches, 2) [-], the ring having turned by ``turn`` [rad].

    The azimuth counts from -Y, so a notch at phi points to (sin phi, -cos phi).
    """
    for k in range(notches.row.size):
        azimuth = notches.azimuth[k] + turn
        direction[k, 0], direction[k, 1] = math.sin(azimuth), -math.cos(azimuth)


@kernel
def notch_under(notches: Notches, direction: Floats, row: int, nx: float, ny: float) -> tuple[int, float]:
    """Return which notch lies under a contact normal and how far the normal is past its middle [rad]; -1 for none."""
    for k in range(notches.row.size):
        if notches.row[k] >= 0 and notches.row[k] != row:
            continue
        if nx * direction[k, 0] + ny * direction[k, 1] > notches.nearness[k]:
            return k, math.asin(direction[k, 0] * ny - direction[k, 1] * nx)
    return -1, 0.0


@kernel
def roller_notch_under(
    notches: RollerNotches,
    row: int,
    i: int,
    nx: float,
    ny: float,
    angle: float,
    share: float,
    way: float,
    raceway: float,
    roller: float,
    inner: bool,
) -> tuple[float, float]:
    """Return mean depth of a roller's notches under a contact normal, and its change over a ``way`` [rad] of the normal [m].

    (nx, ny) points from the roller to the contact halfway, ``angle`` is the roller's rotation there [rad], and ``share`` the angle on its
    surface over that on the roller of the plane, cos(alpha) [-].
    """
    for k in range(notches.row.size):
        if notches.row[k] != row or notches.roller[k] != i:
            continue
        azimuth = notches.azimuth[k] + angle
        towards_x, towards_y = math.sin(azimuth), -math.cos(azimuth)
        if nx * towards_x + ny * towards_y > math.cos(share * notches.half_angle[k]):
            offset = math.asin(towards_x * ny - towards_y * nx) / share
            bottom, kink = (
                notches.inner_bottom[k] if inner else notches.outer_bottom[k],
                notches.inner_kink[k] if inner else notches.outer_kink[k],
            )
            return passed(offset, way, notches.half_angle[k], bottom, kink, notches.depth[k], raceway, roller, inner, YES)
    return 0.0, 0.0


@kernel
def separation(sink: float) -> float:
    """Return 1 less the influence of a contact on another [-], from the sink depth between them [m]: 0 for one contact, 1 far apart."""
    return sink / (sink + SEPARATION)


@kernel
def joined(first: float, second: float, apart: float) -> tuple[float, float, float]:
    """Return the penetration of one contact with the energy of two that share a load [m], and its slopes over both penetrations [-].

    Each sinks by its own compliance and, where the other presses, by the share gamma = 1 - ``apart`` of it. For linear contacts the energy
    of both is that of one with the square of the penetration

        (d_1^2 + d_2^2 - 2 gamma d_1 d_2)/(1 - gamma^2)

    and the other contact opens where its own penetration is below gamma times the larger one. One penetration is above zero [m].
    """
    high, low = max(first, second), min(first, second)
    if low <= (1.0 - apart) * high:
        return high, 1.0 if first >= second else 0.0, 0.0 if first >= second else 1.0
    by_apart = 1.0 / (apart * (2.0 - apart))
    difference = first - second
    whole = math.sqrt((difference * difference + 2.0 * apart * first * second) * by_apart)
    return whole, (difference + apart * second) * by_apart / whole, (apart * first - difference) * by_apart / whole


@kernel
def edge_contact(
    dx: float,
    dy: float,
    towards_x: float,
    towards_y: float,
    half_angle: float,
    depth: float,
    gap: float,
    memory: Any,
    inner: bool,
    payload: Payload,
) -> tuple[float, float, float, float]:
    """Return force [N], stiffness [N/m] and normal of a roller over a notch with edges, resultant of edges and floor.

    (dx, dy) is the roller's centre from the ring's, ``gap`` the smooth raceway's. The normal points from ring to
    roller at the inner ring, and the other way round at the outer, whose force is on the roller's far side.
    """
    raceway, site = payload.outer_raceway_radius + payload.edge_radius, payload.outer
    side = -1.0
    if inner:
        raceway, site, side = payload.inner_raceway_radius - payload.edge_radius, payload.inner, 1.0
    wide = half_angle + payload.edge_radius / raceway
    cosine, sine = raceway * math.cos(wide), raceway * math.sin(wide)
    reach = payload.roller_radius + payload.edge_radius
    bx, by = dx - (cosine * towards_x + sine * towards_y), dy - (cosine * towards_y - sine * towards_x)
    ax, ay = dx - (cosine * towards_x - sine * towards_y), dy - (cosine * towards_y + sine * towards_x)
    behind, ahead, centre = math.sqrt(bx * bx + by * by), math.sqrt(ax * ax + ay * ay), math.sqrt(dx * dx + dy * dy)
    floor = -gap - depth
    if max(max(reach - behind, reach - ahead), floor) <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    edges, of_behind, of_ahead = joined(reach - behind, reach - ahead, separation(0.5 * sine * sine / site.reduced_radius))
    # A roller that just touches the floor and an edge sinks between them by a quarter of the depth.
    penetration, of_edges, of_floor = joined(edges, floor, separation(0.25 * depth))
    of_behind, of_ahead = of_edges * of_behind, of_edges * of_ahead
    force, stiffness = normal_force(payload.normal_law, memory, penetration, site)
    nx = side * (of_behind * bx / behind + of_ahead * ax / ahead) + of_floor * dx / centre
    ny = side * (of_behind * by / behind + of_ahead * ay / ahead) + of_floor * dy / centre
    length = math.sqrt(nx * nx + ny * ny)
    return force * length, stiffness * length * length, nx / length, ny / length
