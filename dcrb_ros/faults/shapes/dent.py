"""A dent that a particle has left: a hollow with raised shoulders, over which the rollers roll."""

from __future__ import annotations

import numpy as np

from dcrb_ros.faults.shapes.shape import Marks, Shape
from dcrb_ros.schema.arrays import Floats

SHOULDER_HEIGHT, SHOULDER_PLACE, SHOULDER_WIDTH = 0.2, 0.75, 0.15
"""Height over the depth, distance from the middle and standard deviation over the width [-]."""


def heights(x: Floats, marks: Marks, random: np.random.Generator) -> Floats:
    """Return -h exp(-8 (x/w)^2) and a shoulder of 0.2 h on both sides [m]."""
    u = x / marks.width
    shoulders = sum(np.exp(-0.5 * ((u - side * SHOULDER_PLACE) / SHOULDER_WIDTH) ** 2) for side in (-1.0, 1.0))
    return np.asarray(marks.depth * (SHOULDER_HEIGHT * shoulders - np.exp(-8.0 * u**2)))


def share(marks: Marks, length: float) -> float:
    """Return the width over the length: a dent is as long as it is wide."""
    return marks.width / length


def reach(marks: Marks) -> float:
    """Return where the shoulders have faded [m]."""
    return 1.5 * marks.width


SHAPE = Shape("dent", "the dent of a particle, with shoulders", heights, share, reach)
