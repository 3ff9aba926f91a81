"""The infogram: demodulation of the band with the largest negentropy of squared envelope and of its spectrum (Antoni 2016)."""

from typing import Literal

import numpy as np
from spectra import Demodulation, best_band, strike_count

VARIANTS = {
    "infogram": {},
    "infogram, impulsive": {"domain": "time"},
    "infogram, cyclic": {"domain": "spectrum"},
    "infogram, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


def negentropy(power):
    """Return mean(r ln r) with r = power / mean(power); 0 for a constant, 1 - 0.577 for noise (Antoni 2016) [-]."""
    r = power / power.mean()
    return np.mean(r * np.log(np.maximum(r, 1e-300)))


class Infogram(Demodulation):
    """Report the part whose lines have grown most in the most informative band.

    Negentropy of the squared envelope measures impulses, that of its squared spectrum measures lines; ``domain: average`` takes the mean
    of both, as published.
    """

    domain: Literal["average", "time", "spectrum"] = "average"

    def information(self, envelope):
        """Return the negentropy of a squared envelope in the chosen domain [-]."""
        share = {"time": 1.0, "average": 0.5, "spectrum": 0.0}[self.domain]
        return share * negentropy(envelope) + (1.0 - share) * negentropy(np.abs(np.fft.rfft(envelope)[1:]) ** 2)

    def demodulated(self, acceleration, angle):
        """Return the squared envelope of the most informative band."""
        return best_band(acceleration, strike_count(self.orders, angle), self.information)[2]
