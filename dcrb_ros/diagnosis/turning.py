"""What is sampled in time, over the angle of the shaft instead: then a changing speed smears no line."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

TURN = 2.0 * math.pi
"""A turn [rad]."""


def turns_of(shaft_angle: npt.NDArray[Any]) -> Floats:
    """Return the turns since the first sample, signed, from angles wrapped to a turn [rad]."""
    steps = np.diff(np.asarray(shaft_angle, np.float64)) / TURN
    steps -= np.round(steps)
    return np.concatenate([[0.0], np.cumsum(steps)])


def turns_back(turns: Floats, tolerance: float) -> bool:
    """Return whether the shaft turned both ways by more than ``tolerance`` [turns], a jitter of the angle set aside."""
    if (np.maximum.accumulate(turns) - turns).max() <= tolerance:
        return False
    return bool((turns - np.minimum.accumulate(turns)).max() > tolerance)


def borders_between(first: float, last: float, bins_per_turn: int) -> Floats:
    """Return the borders [turns] within ``first`` < border <= ``last`` of bins as wide as a turn has them, and the one before."""
    return np.arange(math.floor(first * bins_per_turn), math.floor(last * bins_per_turn) + 1) / bins_per_turn


def bin_means(places: Floats, values: Floats, borders: Floats) -> Floats:
    """Return the means of ``values``, sampled at ``places``, between ``borders`` in the same unit, which must rise.

    Bins share the samples at their borders in proportion: an anti-alias filter that keeps the energy.
    """
    sums = np.zeros(len(places))
    np.cumsum(np.diff(places) * 0.5 * (values[1:] + values[:-1]), out=sums[1:])
    energy = np.interp(borders, places, sums)
    return np.asarray(np.diff(energy) / np.maximum(np.diff(borders), np.finfo(np.float64).tiny), np.float64)
