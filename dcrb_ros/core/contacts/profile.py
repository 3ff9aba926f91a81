"""Profiles of surfaces: depth over the angle on a raceway or a roller, from samples."""

from __future__ import annotations

import math

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.payload import Payload, Profiles

TURN = 2.0 * math.pi


@kernel
def sample(profiles: Profiles, depths: Floats, k: int, i: int) -> float:
    """Return sample ``i`` of profile ``k`` [m]: of a periodic one as often as it goes round, of another zero beyond its ends."""
    count = profiles.count[k]
    if not profiles.periodic[k] and not 0 <= i < count:
        return 0.0
    depth: float = depths[profiles.first[k] + i % count]
    return depth


@kernel
def profile_depth(profiles: Profiles, depths: Floats, k: int, angle: float) -> float:
    """Return the depth of profile ``k`` [m] at an angle from its azimuth [rad], by Catmull and Rom's cubic through the samples.

    It is continuous with its slope.
    """
    count, spacing = profiles.count[k], profiles.spacing[k]
    if profiles.periodic[k]:
        place = angle / spacing
    else:
        place = (angle - TURN * math.floor(angle / TURN + 0.5)) / spacing + 0.5 * (count - 1)
        if place <= -2.0 or place >= count + 1.0:
            return 0.0
    i = math.floor(place)
    u = place - i
    a, b = sample(profiles, depths, k, i - 1), sample(profiles, depths, k, i)
    c, d = sample(profiles, depths, k, i + 1), sample(profiles, depths, k, i + 2)
    depth: float = b + 0.5 * u * (c - a + u * (2.0 * a - 5.0 * b + 4.0 * c - d + u * (3.0 * (b - c) + d - a)))
    return depth


@kernel
def profiles_under(
    payload: Payload,
    row: int,
    i: int,
    nx: float,
    ny: float,
    orbit: float,
    spin: float,
    turn: float,
    turning: float,
    angle: float,
    inner: bool,
) -> tuple[float, float]:
    """Return the depth of all profiles under a contact in the middle of a step [m], and its growth over the step [m].

    (nx, ny) points from the ring to roller ``i`` of a row, ``orbit`` is the roller's angular speed about the ring's centre, ``spin`` its
    own, ``turning`` the ring's [rad/s]; ``turn`` and ``angle`` are the rotations of ring and roller [rad].
    """
    profiles, depths, h = payload.profiles, payload.profile_depths, payload.step
    ring, depth, change = 0 if inner else 1, 0.0, 0.0
    for k in range(profiles.row.size):
        if profiles.row[k] >= 0 and profiles.row[k] != row:
            continue
        if profiles.body[k] == ring:
            at, way = math.atan2(nx, -ny) - turn, h * (orbit - turning)
        elif profiles.body[k] == 2 and (profiles.roller[k] < 0 or profiles.roller[k] == i):
            at, way = (math.atan2(-nx, ny) if inner else math.atan2(nx, -ny)) - angle, h * (orbit - spin)
        else:
            continue
        at -= profiles.azimuth[k]
        depth += profile_depth(profiles, depths, k, at)
        change += profile_depth(profiles, depths, k, at + 0.5 * way) - profile_depth(profiles, depths, k, at - 0.5 * way)
    return depth, change
