"""Minimum entropy deconvolution: the filter with the most impulsive output (Wiggins 1978; Endo and Randall 2007)."""

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import correlate, fftconvolve
from spectra import Demodulation, padded, squared_envelope

VARIANTS = {
    "minimum entropy deconvolution": {},
    "minimum entropy deconvolution, 100 taps": {"taps": 100},
    "minimum entropy deconvolution, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


def deconvolved(signal, taps, iterations):
    """Return the output of the filter f that maximises the kurtosis sum y^4 / (sum y^2)^2 of y = f * x.

    A stationary point satisfies R f = c sum_n y_n^3 x_(n-l), with R the autocorrelation of x, which is solved in turn from f = a unit
    impulse in the middle (Endo and Randall 2007, Eqs. 7 to 10).
    """
    power = np.abs(np.fft.rfft(signal, 2 * len(signal))) ** 2
    column = np.fft.irfft(power)[:taps].copy()
    column[0] *= 1.0 + 1e-6
    output = signal[taps // 2 : len(signal) - taps + 1 + taps // 2]
    for _ in range(iterations):
        cubed = correlate(signal, output**3, "valid", method="fft")[::-1]
        f = solve_toeplitz(column, cubed / np.abs(cubed).max())
        output = fftconvolve(signal, f, "valid")
        output /= output.std()
    return output


class MinimumEntropy(Demodulation):
    """Report the part whose lines have grown most in the squared envelope spectrum of the deconvolved signal."""

    taps = 50
    """Length of the filter [samples]."""
    iterations = 8
    """Steps of the iteration [-]."""

    def demodulated(self, acceleration, angle):
        """Return the squared envelope of the output of the filter."""
        return padded(squared_envelope(deconvolved(acceleration, self.taps, self.iterations)), len(acceleration))
