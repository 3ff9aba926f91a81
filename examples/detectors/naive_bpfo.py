"""A line at BPFO in the spectrum of the rectified acceleration.

A healthy bearing has one, too: its compliance varies as rollers pass the load.
"""

import numpy as np
from spectra import HARMONICS, line_ratios, order_spectrum
from trending import Trending

VARIANTS = {
    "naive BPFO": {},
    "naive BPFO, 15 dB": {"factor": 5.6},
    "naive BPFO, 18 dB": {"factor": 8.0},
}
"""Settings of each member of the family; the first has the published ones."""


class NaiveBpfo(Trending):
    """Report an outer ring defect if the line at BPFO is 12 dB above the spectrum around it; there is no healthy level."""

    factor = 4.0
    learning = 0

    def features(self, acceleration, angle):
        """Return the mean ratio of the harmonics of BPFO to the spectrum around them."""
        return {"outer_ring": line_ratios(*order_spectrum(np.abs(acceleration), angle), self.orders)["outer_ring"] / HARMONICS}
