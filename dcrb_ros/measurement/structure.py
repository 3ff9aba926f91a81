"""The way of the acceleration through the axle box: a bank of modes between outer ring and accelerometer."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.measurement.filters import side_by_side, transmissibility
from dcrb_ros.measurement.streams import stream
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.sensor import Structure, numbers

LOWEST, HIGHEST = 500.0, 8000.0
"""Band in which modes are drawn [Hz]."""
LEAST_DAMPING, MOST_DAMPING = 0.01, 0.05
"""Damping ratios that are drawn [-]."""
USUAL_DAMPING = 0.02
"""Damping ratio of a given mode without one [-]."""


class Mode(NamedTuple):
    """A mode of the axle box."""

    frequency: float
    """Natural frequency [Hz]."""
    damping: float
    """Damping ratio [-]."""
    share: tuple[float, float]
    """Part of the acceleration in X and Y that goes through it [-]; those of all modes add up to 1."""


def modes(structure: Structure) -> list[Mode]:
    """Return the modes of an axle box: given ones, or one drawn in each of so many equal stretches of the band's logarithm."""
    random = stream(structure.seed, "structure")
    frequencies = numbers(structure.frequencies, "structure.frequencies")
    dampings = numbers(structure.dampings, "structure.dampings") or [USUAL_DAMPING] * len(frequencies)
    if not frequencies:
        places = (np.arange(structure.modes) + random.random(structure.modes)) / max(1, structure.modes)
        frequencies = [float(frequency) for frequency in LOWEST * (HIGHEST / LOWEST) ** places]
        dampings = [float(damping) for damping in random.uniform(LEAST_DAMPING, MOST_DAMPING, structure.modes)]
    shares = random.uniform(0.2, 1.0, (len(frequencies), 2))
    shares /= shares.sum(axis=0)
    return [Mode(f, z, (float(x), float(y))) for f, z, (x, y) in zip(frequencies, dampings, shares, strict=True)]


def sections(structure: Structure, rate: float) -> tuple[Floats, Floats]:
    """Return the way through the axle box in X and in Y as sections at a rate [Hz]; acceleration at rest goes through unchanged."""
    found = modes(structure)
    bank = [transmissibility(mode.frequency, mode.damping, rate) for mode in found]
    x, y = ([structure.coupling * mode.share[axis] for mode in found] for axis in (0, 1))
    straight = 1.0 - structure.coupling
    return side_by_side(bank, x, straight), side_by_side(bank, y, straight)
