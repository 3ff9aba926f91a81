"""Order tracking: a signal sampled in time, resampled over the angle of the shaft, so that a changing speed does not smear its lines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.arrays import Floats

LEAST_TURNS = 4.0
"""Turns that an envelope spectrum needs, in which the lines of the cage can be seen."""
JITTER = 0.02
"""Turns by which a measured angle may run back [-]."""


def unwrapped_turns(shaft_angle: npt.NDArray[Any]) -> Floats:
    """Return the signed turns since the first sample from wrapped angles [rad], shape (samples,)."""
    steps = np.diff(np.asarray(shaft_angle, np.float64)) / (2.0 * math.pi)
    steps -= np.round(steps)
    return np.concatenate([[0.0], np.cumsum(steps)])


def forward_turns(turns: Floats) -> Floats:
    """Return turns from 0 that rise from sample to sample, whichever way the shaft rotates, without the jitter; same shape."""
    return np.asarray(np.maximum.accumulate(turns if turns[-1] > 0.0 else -turns), np.float64)


def reverses(turns: Floats) -> bool:
    """Return whether the shaft rotated in both directions by more than `JITTER` [turns]."""
    if (np.maximum.accumulate(turns) - turns).max() <= JITTER:
        return False
    return bool((turns - np.minimum.accumulate(turns)).max() > JITTER)


def bin_edges(first: float, last: float, bins_per_turn: int) -> Floats:
    """Return the edges [turns] of equal bins within ``first`` < edge <= ``last``, and the edge before them."""
    return np.arange(math.floor(first * bins_per_turn), math.floor(last * bins_per_turn) + 1) / bins_per_turn


def bin_means(positions: Floats, values: Floats, edges: Floats) -> Floats:
    """Return the means of ``values``, sampled at equally spaced ``positions``, between rising ``edges``, shape (edges - 1,).

    A sample at an edge contributes to both bins in proportion, so that the energy is preserved and aliasing is reduced.
    """
    spacing = float(positions[1] - positions[0])
    integral = np.zeros(len(positions))
    np.cumsum(values[1:] + values[:-1], out=integral[1:])
    integral *= 0.5 * spacing
    samples = np.clip((edges - positions[0]) / spacing, 0.0, len(positions) - 1.0)
    before = np.minimum(samples.astype(np.intp), len(positions) - 2)
    energy = integral[before] + (samples - before) * (integral[before + 1] - integral[before])
    return np.asarray(np.diff(energy) / np.maximum(np.diff(edges), np.finfo(np.float64).tiny), np.float64)
