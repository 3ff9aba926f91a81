"""Order tracking: a signal sampled in time, resampled over the angle of the shaft, so that a changing speed does not smear its lines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.arrays import Floats


def unwrapped_turns(shaft_angle: npt.NDArray[Any]) -> Floats:
    """Return the signed turns since the first sample from wrapped angles [rad], shape (samples,)."""
    steps = np.diff(np.asarray(shaft_angle, np.float64)) / (2.0 * math.pi)
    steps -= np.round(steps)
    return np.concatenate([[0.0], np.cumsum(steps)])


def reverses(turns: Floats, tolerance: float) -> bool:
    """Return whether the shaft turned in both directions by more than ``tolerance`` [turns], which allows for jitter of the angle."""
    if (np.maximum.accumulate(turns) - turns).max() <= tolerance:
        return False
    return bool((turns - np.minimum.accumulate(turns)).max() > tolerance)


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
    places = np.clip((edges - positions[0]) / spacing, 0.0, len(positions) - 1.0)
    before = np.minimum(places.astype(np.intp), len(positions) - 2)
    energy = integral[before] + (places - before) * (integral[before + 1] - integral[before])
    return np.asarray(np.diff(energy) / np.maximum(np.diff(edges), np.finfo(np.float64).tiny), np.float64)
