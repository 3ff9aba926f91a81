"""The fast kurtogram: demodulation of the band with the largest spectral kurtosis (Antoni 2007)."""

import numpy as np
from spectra import line_ratios, order_spectrum
from trending import Trending, bands

VARIANTS = {
    "fast kurtogram": {},
    "fast kurtogram, three levels": {"levels": 3},
    "fast kurtogram, factor 2": {"factor": 2.0},
}
"""Settings of each member of the family; the first has the published ones."""


def spectral_kurtosis(envelope):
    """Return K = mean |z|^4 / (mean |z|^2)^2 - 2 of a complex envelope, given as |z|^2; 0 for noise (Antoni 2007) [-]."""
    return np.mean(envelope**2) / np.mean(envelope) ** 2 - 2.0


class Kurtogram(Trending):
    """Report the part whose lines in the squared envelope spectrum of the most impulsive band have grown most."""

    levels = 5
    """Levels of the tree of bands [-]."""

    def features(self, acceleration, angle):
        """Return the lines of every part relative to the spectrum around them, since every window has a band of its own."""
        usable = (envelope for _, _, envelope in bands(acceleration, self.levels) if len(envelope) >= len(acceleration) / 64)
        return line_ratios(*order_spectrum(max(usable, key=spectral_kurtosis), angle), self.orders)
