"""Spectral amplitude modulation: a spectrum raised to several powers before demodulation (Moshrefzadeh, Fasana and Antoni 2019)."""

import numpy as np
from spectra import Demodulation, line_ratios, order_spectrum, squared_envelope

VARIANTS = {
    "spectral amplitude modulation": {},
    "spectral amplitude modulation, factor 2": {"factor": 2.0},
}
"""Settings of each member of the family; the first has the published ones."""


class AmplitudeModulation(Demodulation):
    """Report the part whose lines have grown most, at the power of the spectrum at which they are strongest.

    The modified signal is F^-1(|F a|^m exp(i arg F a)). The power m = 1 keeps the signal, 0 whitens it, and larger or smaller ones favour
    strong or weak bands.
    """

    lowest_power, highest_power = -0.5, 1.5
    """Range of the power m, in steps of 0.25 [-]."""

    def demodulated(self, acceleration, angle, power=1.0):
        """Return the squared envelope of the signal whose spectrum is raised to a power."""
        transform = np.fft.rfft(acceleration)
        magnitude = np.maximum(np.abs(transform), 1e-9 * np.abs(transform).max())
        return squared_envelope(np.fft.irfft(transform * magnitude ** (power - 1.0), len(acceleration)))

    def features(self, acceleration, angle):
        """Return the largest ratio of the lines of every part to the spectrum around them, over the powers."""
        best = {}
        for power in np.arange(self.lowest_power, self.highest_power + 0.01, 0.25):
            spectrum, turns = order_spectrum(self.demodulated(acceleration, angle, power), angle)
            for part, ratio in line_ratios(spectrum, turns, self.orders).items():
                best[part] = max(ratio, best.get(part, 0.0))
        return best
