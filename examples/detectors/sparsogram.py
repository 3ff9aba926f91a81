"""The sparsogram: demodulation of the band whose envelope spectrum is sparsest (Tse and Wang 2013, MSSP 40, 499 to 519)."""

import numpy as np
from spectra import Demodulation, best_band, strike_count

VARIANTS = {
    "sparsogram": {},
    "sparsogram, three levels": {"levels": 3},
    "sparsogram, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


def hoyer(values):
    """Return (sqrt(N) - |v|_1 / |v|_2) / (sqrt(N) - 1): 0 for a constant, 1 for a single line (Hoyer 2004) [-]."""
    root = np.sqrt(len(values))
    return (root - np.sum(np.abs(values)) / max(np.linalg.norm(values), 1e-300)) / (root - 1.0)


class Sparsogram(Demodulation):
    """Report the part whose lines have grown most in the band with the sparsest power spectrum of its envelope.

    Published with wavelet packets and the ratio of the norms L2 and L1; here the bands are those of the kurtogram, and Hoyer's index, a
    function of the same ratio, compares envelopes of different lengths.
    """

    levels = 5
    """Levels of the tree of bands [-]."""

    def demodulated(self, acceleration, angle):
        """Return the squared envelope of the band whose envelope spectrum is sparsest."""
        slow = max(int(0.3 * abs(angle[-1] - angle[0]) / (2.0 * np.pi)), 1)  # lower lines are those of the taper and of slow variation

        def score(envelope):
            return hoyer(np.abs(np.fft.rfft(np.sqrt(envelope))[slow:]) ** 2)

        return best_band(acceleration, strike_count(self.orders, angle), score, self.levels)[2]
