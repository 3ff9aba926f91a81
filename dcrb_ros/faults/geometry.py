"""Geometry of the faults as the kernels take it: one record per notch, broken bar or damaged surface.

Rows and rollers count from zero, angles from the load line (-Y), counter-clockwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

Ring = Literal["inner_ring", "outer_ring"]


class RacewayNotch(NamedTuple):
    """A notch across a raceway, with the fields of `dcrb_ros.core.payload.NOTCH`."""

    ring: Ring
    row: int
    """Row of the notch; -1 for all rows."""
    half_angle: float
    """Half the angular width b/(2 r) [rad]."""
    nearness: float
    """Cosine of the angle from the middle at which the notch begins, the fillets of its edges included [-]."""
    bottom: float
    """Angle on either side of the middle over which the roller touches the floor [rad]."""
    kink: float
    """Drop of the slope of the depth at either end of that angle [m/rad]."""
    depth: float
    """[m]"""
    azimuth: float
    """Azimuth of the middle; on the inner ring at shaft angle zero [rad]."""


class RollerNotch(NamedTuple):
    """A notch across a roller, with the fields of `dcrb_ros.core.payload.ROLLER_NOTCH`."""

    row: int
    roller: int
    half_angle: float
    """Half the angular width b/(2 r_R) [rad]."""
    inner_bottom: float
    """Angle on either side of the middle over which the inner raceway touches the floor [rad]."""
    outer_bottom: float
    """The same for the outer raceway [rad]."""
    inner_kink: float
    """Drop of the slope of the depth at either end of that angle [m/rad]."""
    outer_kink: float
    depth: float
    """[m]"""
    azimuth: float
    """Angle of the middle on the roller at spin angle zero [rad]."""


class BrokenBar(NamedTuple):
    """A missing cage bar."""

    row: int
    bar: int
    """Number of the roller before it, from zero."""


class SurfaceHeights(NamedTuple):
    """The heights of a raceway where it is damaged, from samples; the envelope of the rollers and the width of the contact follow."""

    ring: Ring
    row: int
    """Row; -1 for all rows."""
    heights: Sequence[float]
    """Samples at an odd number of places about the middle, zero at both ends; below zero where metal is missing [m]."""
    azimuth: float
    """Azimuth of the middle; on the inner ring at shaft angle zero [rad]."""
    spacing: float
    """Distance between the samples along the raceway [m]."""
    share: float
    """Share of the roller's length that the damage takes [-]."""


Damage = RacewayNotch | RollerNotch | BrokenBar | SurfaceHeights
