"""A scratch across the raceway with a burr on one side, over which the rollers roll."""

from __future__ import annotations

import numpy as np

from dcrb_ros.faults.shapes.shape import Marks, Shape, whole_length
from dcrb_ros.schema.arrays import Floats

BURR = 0.3
"""Height of the burr over the depth [-]."""


def heights(x: Floats, marks: Marks, random: np.random.Generator) -> Floats:
    """Return a groove -h exp(-8 (x/w)^2) with a burr of 0.3 h beside it [m]."""
    u = x / marks.width
    return np.asarray(marks.depth * (BURR * np.exp(-8.0 * (u - 1.0) ** 2) - np.exp(-8.0 * u**2)))


def reach(marks: Marks) -> float:
    """Return where the burr has faded [m]."""
    return 2.5 * marks.width


SHAPE = Shape("scratch", "a scratch across with a burr", heights, whole_length, reach)
