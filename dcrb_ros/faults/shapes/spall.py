"""A spall: material broken out, with a shallow lip on the side of the smaller azimuths, a steep edge on the other, and a rough floor."""

from __future__ import annotations

import numpy as np

from dcrb_ros.faults.shapes.shape import Marks, Shape, half_width
from dcrb_ros.schema.arrays import Floats

ENTRY, EXIT = 0.5e-3, 0.2e-3
"""Length of the lip, and of the edge on the other side [m]; each takes a third of a small spall at most. When the shaft turns
counter-clockwise, rollers enter an outer raceway's spall over the lip, and an inner raceway's over the edge."""
GRAIN = 0.3e-3
"""Distance over which the floor is alike [m]."""
LEAST_DEPTH = 0.2
"""Least depth of the rough floor, as a share of the depth [-]."""


def heights(x: Floats, marks: Marks, random: np.random.Generator) -> Floats:
    """Return -h f (1 + rho n f) [m]: ramps f at both edges, and a floor of roughness rho."""
    width = marks.width
    entry, exit_ = min(ENTRY, width / 3.0), min(EXIT, width / 3.0)
    floor = np.clip((x + 0.5 * width) / entry, 0.0, 1.0) * np.clip((0.5 * width - x) / exit_, 0.0, 1.0)
    grains = random.standard_normal(int(np.ceil(width / GRAIN)) + 3)
    noise = np.interp((x + 0.5 * width) / GRAIN + 1.0, np.arange(len(grains)), grains)
    return np.asarray(-marks.depth * floor * np.maximum(1.0 + marks.roughness * noise * floor, LEAST_DEPTH))


def share(marks: Marks, length: float) -> float:
    """Return 0.3: as along a railway bearing's raceway, where a spall grows from a few millimetres on."""
    return 0.3


SHAPE = Shape("spall", "material broken out", heights, share, half_width)
