"""How widely the impacts on damage differ between machines: priors of the group ``impacts`` for a laboratory rig and an axle box.

The numbers of the laboratory are measured on three rigs where `docs/explanation/surfaces.md` says so; the others, and all of the axle box,
are choices.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

BOUND = 2.0
"""Standard deviations of the logarithms at most [-]."""


class Lognormal(NamedTuple):
    """A quantity whose logarithm is normal, within two standard deviations."""

    median: float
    factor: float
    """Factor of one standard deviation [-]."""
    most: float = float("inf")

    def drawn(self, random: np.random.Generator) -> float:
        """Return a value."""
        deviation = min(max(float(random.standard_normal()), -BOUND), BOUND)
        return min(self.median * float(self.factor**deviation), self.most)


class ImpactPriors(NamedTuple):
    """Distributions of the parameters of unequal impacts."""

    spread: Lognormal
    """Of all causes together [-]."""
    element_share: tuple[float, float]
    """Parameters of a beta distribution."""
    shaft_share: tuple[float, float]
    """The same."""
    axial_share: tuple[float, float]
    """Lowest and highest of a uniform distribution [-]; the laboratory's gives the sidebands of inner rings on three rigs."""
    time_spread: Lognormal
    """[s]"""
    spin_memory: tuple[float, float]
    """Lowest and highest of a uniform distribution of the logarithm [s]; the laboratory's gives the correlation of impacts on CWRU."""


LABORATORY = ImpactPriors(Lognormal(0.5, 1.8, 1.3), (1.0, 2.5), (1.0, 5.0), (0.3, 0.8), Lognormal(4e-5, 3.0, 1e-3), (0.002, 0.05))
AXLE_BOX = ImpactPriors(Lognormal(0.25, 1.8, 1.3), (1.0, 3.0), (1.0, 4.0), (0.0, 0.1), Lognormal(5e-5, 2.0, 1e-3), (0.02, 2.0))


def remaining(spread: float, simulated: tuple[float, ...]) -> float:
    """Return what is left of a spread for `impacts.spread` when a bench causes some spreads itself: kappa^2 - sum kappa_i^2, at least 0."""
    return float(np.sqrt(max(spread**2 - sum(part**2 for part in simulated), 0.0)))


def draw_impacts(
    priors: ImpactPriors, random: np.random.Generator, *, balls: bool, of_element: float = 0.0, of_shaft: float = 0.0
) -> dict[str, float]:
    """Return settings of the group ``impacts`` for one machine, by dotted keys.

    ``balls`` says whether the rolling elements are balls, which alone have axial preload and a spin that wanders. ``of_element`` and
    ``of_shaft`` are the spreads (standard deviation over mean) of the strength that the bench causes itself, by ``surfaces.roller_spread``
    and by ``surfaces.run_out`` or ``structure.modulation``: they are taken from the variances of element and shaft, so that nothing counts
    twice. Each draw takes the same number of random numbers.
    """
    spread = priors.spread.drawn(random)
    element, shaft = float(random.beta(*priors.element_share)), float(random.beta(*priors.shaft_share))
    whole = element + shaft
    element, shaft = (element / whole, shaft / whole) if whole > 1.0 else (element, shaft)
    axial, late = float(random.uniform(*priors.axial_share)), priors.time_spread.drawn(random)
    low, high = np.log(priors.spin_memory)
    memory = float(np.exp(random.uniform(low, high)))
    parts = np.array(
        [
            remaining(spread * element**0.5, (of_element,)) ** 2,
            remaining(spread * shaft**0.5, (of_shaft,)) ** 2,
            spread**2 * max(1.0 - element - shaft, 0.0),
        ]
    )
    left = float(parts.sum())
    drawn = {
        "impacts.spread": left**0.5,
        "impacts.element_share": float(parts[0]) / left if left > 0.0 else 0.0,
        "impacts.shaft_share": float(parts[1]) / left if left > 0.0 else 0.0,
        "impacts.time_spread": late,
    }
    return drawn | ({"impacts.axial_share": axial, "impacts.spin_memory": memory} if balls else {})
