"""Cepstrum pre-whitening: the envelope of a signal whose spectrum has the same magnitude everywhere (Borghesani et al. 2013)."""

import numpy as np
from spectra import Demodulation, squared_envelope

VARIANTS = {
    "cepstrum pre-whitening": {},
    "cepstrum pre-whitening, factor 2": {"factor": 2.0},
    "cepstrum pre-whitening, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


class CepstrumPrewhitening(Demodulation):
    """Report the part whose lines have grown most in the squared envelope spectrum of the pre-whitened signal.

    Setting the real cepstrum to zero, save its first value, is x_w = F^-1(F x / |F x|): tones of gears and resonances vanish, and the phase
    that holds the impacts together remains (Borghesani et al. 2013, Eq. 5).
    """

    def demodulated(self, acceleration, angle):
        """Return the squared envelope of the pre-whitened window."""
        transform = np.fft.rfft(acceleration)
        return squared_envelope(np.fft.irfft(transform / np.maximum(np.abs(transform), 1e-300), len(acceleration)))
