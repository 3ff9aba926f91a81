"""The envelope of the random part of a signal, after discrete/random separation (Antoni and Randall 2004)."""

import numpy as np
from scipy.signal import fftconvolve
from spectra import Demodulation, padded, squared_envelope

VARIANTS = {
    "discrete/random separation": {},
    "discrete/random separation, long filter": {"taps": 2048},
    "discrete/random separation, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


def random_part(signal, taps):
    """Return the signal less the part that can be predicted from its past, one filter length earlier.

    H(f) = sum X_d X* / sum |X_d|^2 over segments of the signal X and of the delayed signal X_d is near 1 at tones and near 0 for noise
    (Antoni and Randall 2004, part II, Eq. 10).
    """
    starts = range(taps, len(signal) - taps + 1, taps // 2)
    window = np.hanning(taps)
    now = np.fft.rfft([window * signal[k : k + taps] for k in starts])
    past = np.fft.rfft([window * signal[k - taps : k] for k in starts])
    gain = np.sum(past.conj() * now, axis=0) / np.maximum(np.sum(np.abs(past) ** 2, axis=0), 1e-300)
    impulse_response = np.roll(np.fft.irfft(gain, taps), taps // 2) * window
    predicted = fftconvolve(signal[: -(taps // 2)], impulse_response, "full")[: len(signal) - taps // 2]
    return signal[taps // 2 :] - predicted


class RandomPart(Demodulation):
    """Report the part whose lines have grown most in the squared envelope spectrum of the random part: gears are discrete."""

    taps = 512
    """Length of the filter and of its delay [samples]."""

    def demodulated(self, acceleration, angle):
        """Return the squared envelope of the random part."""
        return padded(squared_envelope(random_part(acceleration, min(self.taps, len(acceleration) // 4))), len(acceleration))
