"""Synchronous averaging of the envelope at the period of each part (McFadden and Toozhy 2000)."""

import numpy as np
from spectra import highpass, struck
from trending import SLIP, Trending, over_angle

VARIANTS = {
    "synchronous averaging": {},
    "synchronous averaging, factor 2": {"factor": 2.0},
    "synchronous averaging, no reference": {"learning": 0, "factor": 4.0},
}
"""Settings of each member of the family; the first has the published ones."""


def periodic_power(even, turns, order, bins):
    """Return sum_b n_b mean_b^2 / variance of an envelope folded at an order into bins; chi-squared with bins - 1 for white noise [-]."""
    place = (np.arange(len(even)) * (turns / len(even)) * order % 1.0 * bins).astype(int)
    counts = np.maximum(np.bincount(place, minlength=bins), 1)
    return np.sum(np.bincount(place, even, minlength=bins) ** 2 / counts) / even.var()


class OrderAveraging(Trending):
    """Report the part at whose period the averaged envelope has grown most, relative to that at orders without a part.

    The average keeps all harmonics of a defect at once. Independent of the gain. Without reference (``learning: 0``), the power must be
    ``factor`` times that of other orders: with 16 bins, three times the mean is exceeded by white noise once in 10^4 orders. No recording
    was used.
    """

    bins = 16
    """Parts of a period [-]."""
    lowest = 2000.0
    """Lower end of the band [Hz]."""
    trials = 9
    """Orders that are tried within the slip [-]."""

    def features(self, acceleration, angle):
        """Return the power of the averages of rings and rollers relative to the median over other orders."""
        even, turns = over_angle(highpass(acceleration, self.rate, self.lowest) ** 2, angle)
        even = even - even.mean()
        found = {}
        for part in ("outer_ring", "inner_ring", "roller"):
            order = struck(self.orders)[part]
            slips = 1.0 + 0.5 * SLIP * np.linspace(-1.0, 1.0, self.trials)
            around = [periodic_power(even, turns, order * slip, self.bins) for slip in np.linspace(1.05, 1.3, 25)]
            found[part] = max(periodic_power(even, turns, order * slip, self.bins) for slip in slips) / np.median(around)
        return found
