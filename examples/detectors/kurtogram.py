"""The fast kurtogram: demodulation of the band with the largest spectral kurtosis (Antoni 2007)."""

import numpy as np
from trending import Trending, bands, lines


def spectral_kurtosis(envelope):
    """Return K = mean |z|^4 / (mean |z|^2)^2 - 2 of a complex envelope, given as |z|^2; 0 for noise (Antoni 2007, Eq. 7) [-]."""
    return np.mean(envelope**2) / np.mean(envelope) ** 2 - 2.0


class Kurtogram(Trending):
    """Report the part whose lines in the squared envelope spectrum of the most impulsive band have grown most."""

    def features(self, acceleration, angle):
        """Return the lines of every part relative to the spectrum around them, since every window has a band of its own."""
        usable = (envelope for _, _, envelope in bands(acceleration) if len(envelope) >= len(acceleration) / 64)
        return lines(max(usable, key=spectral_kurtosis), angle, self.orders, relative=True)
