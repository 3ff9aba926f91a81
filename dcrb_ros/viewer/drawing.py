"""Geometry of the picture of the bearing: positions in mm, X right and Y down as in Rerun.

The rows are drawn side by side. Azimuth is measured from the load line (-Y of the model), counter-clockwise positive. Radii are to
scale, except the thickness of the rings and the smallest width of a defect.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.parameters import Bearing

MILLIMETRES = 1e3
ARC_STEP = math.radians(2.0)
ROUND = (1.0, 1.2, 1.6, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)


def on_circle(radius: Floats | float, azimuth: Floats | float) -> Floats:
    """Return points at ``azimuth`` [rad] on a circle about the origin, shape (..., 2), in the unit of ``radius``."""
    radius, azimuth = np.broadcast_arrays(np.asarray(radius, np.float64), np.asarray(azimuth, np.float64))
    return np.stack([radius * np.sin(azimuth), radius * np.cos(azimuth)], axis=-1)


def arc(radius: float, start: float, end: float) -> Floats:
    """Return the points of an arc between two azimuths [rad], shape (points, 2)."""
    count = max(3, math.ceil(abs(end - start) / ARC_STEP) + 1)
    return on_circle(radius, np.linspace(start, end, count))


def circle(radius: float) -> Floats:
    """Return the points of a full circle, shape (points, 2)."""
    return arc(radius, 0.0, 2.0 * math.pi)


def quaternions(angle: Floats) -> Floats:
    """Return counter-clockwise rotations by ``angle`` [rad] as quaternions x, y, z, w, shape (angles, 4)."""
    half = -0.5 * np.asarray(angle)
    zero = np.zeros_like(half)
    return np.stack([zero, zero, np.sin(half), np.cos(half)], axis=-1)


def rounded_up(value: float) -> float:
    """Return the smallest round number, one of `ROUND` times a power of ten, that is not below ``value``."""
    if not value > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in ROUND if step * power >= value * (1.0 - 1e-9))


@dataclass(frozen=True)
class Drawing:
    """Geometry of the picture of one bearing; all lengths are in millimetres."""

    bearing: Bearing
    largest_force: float
    """Force at the outermost circle of the scale [N]."""

    @property
    def inner_raceway(self) -> float:
        """Radius of the inner raceway [mm]."""
        return self.bearing.inner_raceway_radius * MILLIMETRES

    @property
    def outer_raceway(self) -> float:
        """Radius of the outer raceway [mm]."""
        return self.bearing.outer_raceway_radius * MILLIMETRES

    @property
    def pitch(self) -> float:
        """Pitch radius [mm]."""
        return self.bearing.pitch_radius * MILLIMETRES

    @property
    def roller(self) -> float:
        """Roller radius [mm]."""
        return self.bearing.roller_radius * MILLIMETRES

    @property
    def ring_thickness(self) -> float:
        """Thickness at which both rings are drawn [mm]."""
        return 0.9 * self.roller

    @property
    def rim(self) -> float:
        """Outer radius of the outer ring as drawn [mm]."""
        return self.outer_raceway + self.ring_thickness

    @property
    def bore(self) -> float:
        """Inner radius of the inner ring as drawn [mm]."""
        return max(self.inner_raceway - self.ring_thickness, 0.3 * self.inner_raceway)

    @property
    def bars_start(self) -> float:
        """Radius at which the force bars start [mm]."""
        return self.rim + 0.45 * self.roller

    @property
    def bars_length(self) -> float:
        """Length of the bar of the largest force [mm]."""
        return 0.32 * self.outer_raceway

    @property
    def extent(self) -> float:
        """Radius of a row including its force bars [mm]."""
        return self.bars_start + self.bars_length

    def centre(self, row: int) -> Floats:
        """Return the centre of a row, counted from 0, shape (2,) [mm]."""
        spacing = 2.0 * self.extent + 0.6 * self.roller
        return np.array([(row - 0.5 * (self.bearing.rows - 1)) * spacing, 0.0])

    def bars(self, azimuth: Floats, force: Floats) -> Floats:
        """Return the radial bar of each force [N], shape (..., 2, 2)."""
        length = self.bars_length * np.clip(force / self.largest_force, 0.0, 1.25)
        return np.stack([on_circle(self.bars_start, azimuth), on_circle(self.bars_start + length, azimuth)], axis=-2)

    def cage_bars(self) -> list[Floats]:
        """Return the bars of a cage with its first pocket at azimuth zero."""
        pitch = 2.0 * math.pi / self.bearing.rollers_per_row
        half = 0.5 * pitch - math.asin(min(self.roller / self.pitch, 0.95)) - 0.012
        half = max(half, 0.06 * pitch)
        return [arc(self.pitch, (i + 0.5) * pitch - half, (i + 0.5) * pitch + half) for i in range(self.bearing.rollers_per_row)]

    def broken_bar(self, number: int) -> Floats:
        """Return the radial mark of a broken bar, counted from 1: it runs through the gap between two rollers, shape (2, 2) [mm]."""
        azimuth = (number - 0.5) * 2.0 * math.pi / self.bearing.rollers_per_row
        return on_circle(np.array([self.pitch - 0.85 * self.roller, self.pitch + 0.85 * self.roller]), azimuth)

    def defect(self, radius: float, azimuth: float, width: float) -> Floats:
        """Return the arc of a defect with ``width`` [m] at ``radius`` [mm], at least 4 degrees wide so that it is visible."""
        half = max(0.5 * width * MILLIMETRES / radius, math.radians(2.0))
        return arc(radius, azimuth - half, azimuth + half)
