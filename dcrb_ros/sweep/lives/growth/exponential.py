"""Exponential growth with a random rate: w = w_0 exp(b N), in which each bearing has its own b.

After Gebraeel, Lawley, Li and Ryan, Residual-life distributions from component degradation signals: A Bayesian approach, IIE Transactions
37 (2005) 543-557, without the errors of their signal, which here come from the measurement. The deviation of the rate is an assumption.
"""

from __future__ import annotations

import numpy as np

from dcrb_ros.schema.fields import quantity
from dcrb_ros.sweep.lives.growth.law import STEPS, Growth, GrowthPath, stepped
from dcrb_ros.sweep.lives.growth.paris import grown


class ExponentialGrowth(Growth):
    """Parameters of exponential growth."""

    scatter: float = quantity(0.5, "-", "Standard deviation of the logarithm of the rate between bearings", 0.0, 1.5)

    def path(self, first: float, last: float, random: np.random.Generator) -> GrowthPath:
        """Return the growth of a defect; see `Growth.path`."""
        factor = np.exp(self.scatter * random.standard_normal())
        time, done = stepped(lambda _: np.full(STEPS, factor))
        return GrowthPath(time, grown(done, first, last, 1.0))
