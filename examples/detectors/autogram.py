"""The autogram: demodulation of the band whose squared envelope has the most impulsive autocorrelation (Moshrefzadeh and Fasana 2018)."""

import numpy as np
from spectra import best_band, line_ratios, order_spectrum, strike_count
from trending import Trending

VARIANTS = {
    "autogram": {},
    "autogram, three levels": {"levels": 3},
    "autogram, factor 2": {"factor": 2.0},
}
"""Settings of each member of the family; the first has the published ones."""


def autocorrelation(envelope, first):
    """Return the unbiased autocorrelation of a squared envelope at lags from ``first`` [samples] to half its length."""
    centred, count = envelope - envelope.mean(), len(envelope)
    power = np.abs(np.fft.fft(centred, 2 * count)) ** 2
    lags = np.arange(first, count // 2)
    return np.fft.ifft(power).real[lags] / (count - lags)


def kurtosis_of(correlation):
    """Return sum (R - min R)^4 / (sum (R - min R)^2)^2, times the number of lags (Moshrefzadeh and Fasana 2018) [-]."""
    above = (correlation - correlation.min()) ** 2
    return len(above) * np.sum(above**2) / np.sum(above) ** 2


def most_periodic(acceleration, strikes, levels=5):
    """Return edges and squared envelope of the best band; ``strikes`` is the number of impacts of the fastest defect in the signal [-].

    Lags below three quarters of the period of these impacts are left out: there, an impact correlates with itself.
    """

    def score(envelope):
        return kurtosis_of(autocorrelation(envelope, int(0.75 * len(envelope) / strikes)))

    return best_band(acceleration, strikes, score, levels)


class Autogram(Trending):
    """Report the part whose lines have grown most, in the band that is most impulsive and periodic: single impacts do not attract it."""

    levels = 5
    """Levels of the tree of bands [-]."""

    def features(self, acceleration, angle):
        """Return the lines of every part relative to the spectrum around them."""
        _, _, envelope = most_periodic(acceleration, strike_count(self.orders, angle), self.levels)
        return line_ratios(*order_spectrum(envelope, angle), self.orders)
