"""The spectrum of peaks held over short intervals, in the manner of PeakVue (Robinson, Canada and Walker 2001)."""

import numpy as np
from spectra import Demodulation, highpass

VARIANTS = {
    "peak hold": {},
    "peak hold above 2 kHz": {"lowest": 2000.0},
    "peak hold, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


class PeakHold(Demodulation):
    """Report the part whose lines have grown most in the spectrum of held peaks.

    An interval holds the largest rectified value above ``lowest``; 2.56 of them make a cycle of the highest frequency, which is
    ``lines_shown`` times BPFI.
    """

    lowest = 1000.0
    """Lower end of the band [Hz]."""
    lines_shown = 5.0
    """Highest frequency relative to BPFI [-]."""

    def demodulated(self, acceleration, angle):
        """Return the held peaks."""
        strikes = self.orders["BPFI"] * abs(angle[-1] - angle[0]) / (2.0 * np.pi)
        hold = max(int(len(acceleration) / (2.56 * self.lines_shown * strikes)), 1)
        rectified = np.abs(highpass(acceleration, self.rate, self.lowest))
        return rectified[: len(rectified) // hold * hold].reshape(-1, hold).max(axis=1)
