"""The spectrum of the logarithm of the squared envelope, which outliers hardly change (Borghesani and Antoni 2017)."""

import numpy as np
from spectra import Demodulation, highpass, squared_envelope

VARIANTS = {
    "log-envelope": {},
    "log-envelope above 2 kHz": {"lowest": 2000.0},
    "log-envelope, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


class LogEnvelope(Demodulation):
    """Report the part whose lines have grown most in the spectrum of ln |a + i H(a)|^2."""

    lowest = 0.0
    """Lower end of the band [Hz]; 0 for the whole one."""

    def demodulated(self, acceleration, angle):
        """Return the logarithm of the squared envelope, relative to its mean."""
        squared = squared_envelope(highpass(acceleration, self.rate, self.lowest))
        return np.log(squared / squared.mean() + 1e-6)
