"""A scratch across the raceway with a burr on one side, which the first passages have rolled down."""

from __future__ import annotations

import numpy as np

from dcrb_ros.faults.shapes.shape import Marks, Shape, whole_length
from dcrb_ros.schema.arrays import Floats

BURR = 0.02
"""Height of the burr over the depth [-], a choice."""
STEEPEST_BURR = 1e-3
"""Largest height of the burr over the width [-], a choice: flattening a wave of this steepness elastically takes the pressure pi E*/1000
(Johnson, Contact Mechanics, Sec. 13.2), 0.36 GPa for steel, on top of the contact's; what is higher yields under the first passages."""


def burr_height(marks: Marks) -> float:
    """Return the height of the burr [m]."""
    return min(BURR * marks.depth, STEEPEST_BURR * marks.width)


def heights(x: Floats, marks: Marks, random: np.random.Generator) -> Floats:
    """Return a groove -h exp(-8 (x/w)^2) with a burr of 0.02 h, at most w/1000, beside it [m]."""
    u = x / marks.width
    return np.asarray(burr_height(marks) * np.exp(-8.0 * (u - 1.0) ** 2) - marks.depth * np.exp(-8.0 * u**2))


def reach(marks: Marks) -> float:
    """Return where the burr has faded [m]."""
    return 2.5 * marks.width


SHAPE = Shape("scratch", "a scratch across with a burr", heights, whole_length, reach)
