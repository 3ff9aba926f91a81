"""Corrosion: pits of random sizes over a patch."""

from __future__ import annotations

import numpy as np

from dcrb_ros.faults.shapes.shape import Marks, Shape, half_width
from dcrb_ros.schema.arrays import Floats

NARROWEST, WIDEST = 40e-6, 150e-6
"""Standard deviations of the pits [m]."""
SHALLOWEST = 0.25
"""Depth of the shallowest pit as a share of the depth [-]."""


def heights(x: Floats, marks: Marks, random: np.random.Generator) -> Floats:
    """Return the lowest of ``count`` Gaussian pits [m]."""
    surface = np.zeros(len(x))
    half = max(0.5 * marks.width - 3.0 * WIDEST, 0.0)
    for _ in range(marks.count):
        middle, width = half * (2.0 * random.random() - 1.0), NARROWEST + (WIDEST - NARROWEST) * random.random()
        depth = marks.depth * (SHALLOWEST + (1.0 - SHALLOWEST) * random.random())
        np.minimum(surface, -depth * np.exp(-0.5 * ((x - middle) / width) ** 2), out=surface)
    return surface


def share(marks: Marks, length: float) -> float:
    """Return 0.1: pits are short."""
    return 0.1


SHAPE = Shape("corrosion", "pits over a patch", heights, share, half_width)
