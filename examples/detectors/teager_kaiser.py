"""The Teager-Kaiser energy operator in the place of the envelope (Kaiser 1990; Henriquez Rodriguez et al. 2013)."""

import numpy as np
from spectra import Demodulation, highpass

VARIANTS = {
    "Teager-Kaiser energy": {},
    "Teager-Kaiser energy above 2 kHz": {"lowest": 2000.0},
    "Teager-Kaiser energy, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


class TeagerKaiser(Demodulation):
    """Report the part whose lines have grown most in the spectrum of the energy a_n^2 - a_(n-1) a_(n+1), weighted by frequency."""

    lowest = 0.0
    """Lower end of the band [Hz]; 0 for the whole one."""

    def demodulated(self, acceleration, angle):
        """Return the energy of the window."""
        signal = highpass(acceleration, self.rate, self.lowest)
        return np.abs(signal[1:-1] ** 2 - signal[:-2] * signal[2:])
