"""Morphological closing: impacts stretched by a flat element, and the spectrum of the result (Nikolaou and Antoniadis 2003)."""

from typing import Literal

import numpy as np
from scipy.ndimage import grey_closing, maximum_filter1d, minimum_filter1d
from spectra import Demodulation

VARIANTS = {
    "morphological closing": {},
    "morphological closing, short": {"share": 0.2},
    "morphological gradient": {"operator": "gradient"},
    "morphological closing, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


class Morphology(Demodulation):
    """Report the part whose lines have grown most in the spectrum of the closing (dilation, then erosion) of the signal."""

    share = 0.6
    """Length of the flat element relative to the period of BPFO [-]; 0.6 as published."""
    operator: Literal["closing", "gradient"] = "closing"
    """The gradient is dilation less erosion."""

    def demodulated(self, acceleration, angle):
        """Return the output of the operator."""
        period = len(acceleration) * 2.0 * np.pi / abs(angle[-1] - angle[0]) / self.orders["BPFO"]
        length = min(max(int(self.share * period), 3), len(acceleration) // 4)
        if self.operator == "closing":
            return grey_closing(acceleration, length)
        return maximum_filter1d(acceleration, length) - minimum_filter1d(acceleration, length)
