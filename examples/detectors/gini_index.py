"""Demodulation of the band whose squared envelope is most unequal, by the Gini index (Miao, Zhao and Lin 2017)."""

import numpy as np
from spectra import Demodulation, best_band, strike_count

VARIANTS = {
    "Gini index": {},
    "Gini index, three levels": {"levels": 3},
    "Gini index, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


def gini(values):
    """Return 1 - 2 sum_k v_k (N - k + 1/2) / (N |v|_1) of sorted values: 0 if equal, 1 for one impact (Hurley and Rickard 2009) [-]."""
    ordered, count = np.sort(np.abs(values)), len(values)
    return 1.0 - 2.0 * np.sum(ordered * (count - np.arange(1, count + 1) + 0.5)) / (count * max(ordered.sum(), 1e-300))


class GiniIndex(Demodulation):
    """Report the part whose lines have grown most in the band of the largest Gini index: less attracted by one outlier than kurtosis."""

    levels = 5
    """Levels of the tree of bands [-]."""

    def demodulated(self, acceleration, angle):
        """Return the squared envelope of the band with the largest Gini index."""
        return best_band(acceleration, strike_count(self.orders, angle), gini, self.levels)[2]
