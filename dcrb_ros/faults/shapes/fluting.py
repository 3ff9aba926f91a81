"""Fluting: grooves at a constant distance, left by electric current."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.faults.shapes.shape import Marks, Shape, half_width, whole_length
from dcrb_ros.schema.arrays import Floats

SECOND = 0.3
"""Amplitude of the second harmonic of the grooves [-]."""


def heights(x: Floats, marks: Marks, random: np.random.Generator) -> Floats:
    """Return h/2 (cos k x + 0.3 cos 2 k x) below its crests [m], k = 2 pi/period, fading over a period at both ends."""
    phase = 2.0 * math.pi * x / marks.period
    fade = np.clip((0.5 * marks.width - np.abs(x)) / marks.period, 0.0, 1.0)
    return np.asarray(0.5 * marks.depth * fade * (np.cos(phase) + SECOND * np.cos(2.0 * phase) - 1.0 - SECOND))


SHAPE = Shape("fluting", "grooves a period apart", heights, whole_length, half_width)
