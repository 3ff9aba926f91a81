"""Brinelling: dents at the distance of the rollers, from an overload (true) or from vibration (false) at standstill."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dcrb_ros.faults.shapes.shape import Marks, Place, Shape, half_width, whole_length
from dcrb_ros.schema.arrays import Floats

LOAD_EXPONENT = 1.5
"""Exponent of the cosine with which the dents become shallower away from the load line [-]."""


def heights(x: Floats, marks: Marks, random: np.random.Generator) -> Floats:
    """Return a dent [m], a cosine over its width."""
    inside = np.abs(x) < 0.5 * marks.width
    return np.asarray(np.where(inside, -0.5 * marks.depth * (1.0 + np.cos(2.0 * math.pi * x / marks.width)), 0.0))


def places(pitch: float) -> Iterator[Place]:
    """Yield every roller's place within a quarter turn of the azimuth."""
    for k in range(-int(0.5 * math.pi / pitch), int(0.5 * math.pi / pitch) + 1):
        scale = math.cos(k * pitch) ** LOAD_EXPONENT if abs(k * pitch) < 0.5 * math.pi else 0.0
        if scale > 0.0:
            yield Place(k * pitch, scale)


SHAPE = Shape("brinelling", "dents at the distance of the rollers, deepest at the azimuth", heights, whole_length, half_width, places)
