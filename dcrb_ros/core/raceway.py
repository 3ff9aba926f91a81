"""Notches in the raceways: how much deeper the raceway lies under a roller (Eqs. 8, 9 and 13 to 15)."""

from __future__ import annotations

import math

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.payload import Notches


@kernel
def inner_notch_depth(edge: float, depth: float, raceway: float, roller: float) -> tuple[float, float]:
    """Return depth [m] and its slope [m/rad] at an angle ``edge`` [rad] inside the nearer edge of an inner notch, Eq. 8."""
    sine, cosine = math.sin(edge), math.cos(edge)
    root = math.sqrt(roller * roller - raceway * raceway * sine * sine)
    sink = raceway * (1.0 - cosine) + roller - root
    if sink >= depth:
        return depth, 0.0
    return sink, raceway * sine + raceway * raceway * sine * cosine / root


@kernel
def outer_notch_depth(edge: float, depth: float, raceway: float, roller: float) -> tuple[float, float]:
    """Return depth [m] and its slope [m/rad] at an angle ``edge`` [rad] inside the nearer edge of an outer notch, Eq. 14."""
    sine, cosine = math.sin(edge), math.cos(edge)
    root = math.sqrt(roller * roller - raceway * raceway * sine * sine)
    sink = raceway * (cosine - 1.0) + roller - root
    if sink >= depth:
        return depth, 0.0
    return sink, -raceway * sine + raceway * raceway * sine * cosine / root


@kernel
def notch_under(
    notches: Notches, inner: bool, row: int, normal_x: float, normal_y: float, turn: float, raceway: float, roller: float
) -> tuple[float, float]:
    """Return depth [m] and slope over the azimuth [m/rad] of the notches under a contact normal.

    ``turn`` is the rotation of the ring [rad]. The azimuth counts from -Y, so a notch at phi points to
    (sin phi, -cos phi). Where notches overlap the deeper one counts.
    """
    deepest, slope = 0.0, 0.0
    for k in range(notches.row.size):
        if notches.row[k] >= 0 and notches.row[k] != row:
            continue
        azimuth = notches.azimuth[k] + turn
        notch_x, notch_y = math.sin(azimuth), -math.cos(azimuth)
        if normal_x * notch_x + normal_y * notch_y <= math.cos(notches.half_angle[k]):
            continue
        offset = math.asin(notch_x * normal_y - notch_y * normal_x)
        edge = notches.half_angle[k] - abs(offset)
        if inner:
            depth, rise = inner_notch_depth(edge, notches.depth[k], raceway, roller)
        else:
            depth, rise = outer_notch_depth(edge, notches.depth[k], raceway, roller)
        if depth > deepest:
            deepest = depth
            slope = -rise if offset > 0.0 else rise
    return deepest, slope
