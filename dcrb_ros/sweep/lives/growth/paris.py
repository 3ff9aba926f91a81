"""Paris-like growth: the rate is a power of the width, with a factor of the bearing and one that changes from step to step.

    dw/dN = C w^m exp(Z + Y)

after Paris and Erdogan (1963) for cracks, and Li, Billington, Zhang, Kurfess, Danyluk and Liang, Adaptive prognostics for rolling element
bearing condition, Mechanical Systems and Signal Processing 13 (1999) 103-113, for the defects of bearings. Exponent and deviations are
assumptions. On the test rig of Tarawneh et al. (Defect prognostics models for spall growth in railroad bearing rolling elements, ASME Joint
Rail Conference 2018) the area of spalls above a critical size grows linearly with the mileage, which is an exponent of 0 for a spall
of constant length and of -1 for a square one, after a faster first stage.
"""

from __future__ import annotations

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import quantity
from dcrb_ros.sweep.lives.growth.law import STEPS, Growth, GrowthPath, stepped


class ParisGrowth(Growth):
    """Parameters of Paris-like growth."""

    exponent: float = quantity(1.5, "-", "Power m of the width in the rate of growth", -2.0, 4.0, symbol="m")
    scatter: float = quantity(0.4, "-", "Standard deviation Z of the logarithm of the rate between bearings", 0.0, 1.5)
    noise: float = quantity(
        0.3, "-", "Standard deviation Y of the logarithm of the rate between fiftieths of the time of mean growth", 0.0, 1.5
    )

    def path(self, first: float, last: float, random: np.random.Generator) -> GrowthPath:
        """Return the growth of a defect; see `Growth.path`."""
        factor = np.exp(self.scatter * random.standard_normal())
        time, done = stepped(lambda _: factor * np.exp(self.noise * random.standard_normal(STEPS) - 0.5 * self.noise**2))
        return GrowthPath(time, grown(done, first, last, self.exponent))


def grown(done: Floats, first: float, last: float, exponent: float) -> Floats:
    """Return the width [m] after a share ``done`` [-] of the time from ``first`` to ``last`` [m] with dw/dt = C w^exponent."""
    if abs(exponent - 1.0) < 1e-9:
        return np.asarray(first * (last / first) ** done)
    power = 1.0 - exponent
    return np.asarray((first**power + done * (last**power - first**power)) ** (1.0 / power))
