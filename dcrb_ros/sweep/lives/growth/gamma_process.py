"""Growth by a gamma process: independent jumps of random size, whose mean follows a power of time.

The share X of the way from the first to the last width has increments X(t) - X(s) ~ Gamma(c (t^b - s^b), 1/c), so its mean is t^b and its
variance t^b / c (van Noortwijk, A survey of the application of gamma processes in maintenance, Reliability Engineering and System Safety 94
(2009) 2-21). t is the number of revolutions over `revolutions`, times a factor of the bearing; c and b are assumptions. At t = 1 the
mean is 1, but the median time to X = 1 is longer: by 20 % for c = 1 and b = 1.5.
"""

from __future__ import annotations

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import quantity
from dcrb_ros.sweep.lives.growth.law import STEPS, Growth, GrowthPath, stepped


class GammaGrowth(Growth):
    """Parameters of a gamma process."""

    power: float = quantity(1.5, "-", "Power b of time in the mean", 0.2, 5.0, symbol="b")
    jumps: float = quantity(40.0, "-", "Mean over variance c of the process at failure: large jumps if it is small", 1.0, 1e6, symbol="c")
    scatter: float = quantity(0.3, "-", "Standard deviation of the logarithm of the rate of time between bearings", 0.0, 1.5)

    def path(self, first: float, last: float, random: np.random.Generator) -> GrowthPath:
        """Return the growth of a defect; see `Growth.path`."""
        factor = np.exp(self.scatter * random.standard_normal())

        def rates(begin: int) -> Floats:
            mean = np.diff((factor * np.arange(begin, begin + STEPS + 1) / STEPS) ** self.power)
            return np.asarray(STEPS * random.gamma(self.jumps * mean) / self.jumps)

        time, done = stepped(rates)
        return GrowthPath(time, first + (last - first) * done)
