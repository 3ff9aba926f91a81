"""Maximum correlated kurtosis deconvolution, MCKD, at the period of each part (McDonald, Zhao and Zuo 2012)."""

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import correlate, fftconvolve
from spectra import Demodulation, line_ratios, order_spectrum, padded, squared_envelope, struck

VARIANTS = {
    "MCKD": {},
    "MCKD, factor 2": {"factor": 2.0},
    "MCKD, 100 taps": {"taps": 100},
}
"""Settings of each member of the family; the first has the published ones."""


def deconvolved(signal, period, taps, iterations):
    """Return the output y = f * x of the filter with the largest correlated kurtosis sum (y_n y_(n-T))^2 / (sum y^2)^2, T the period.

    In a stationary point R f = c sum_n (y_n y_(n-T)^2 x_(n-l) + y_n^2 y_(n-T) x_(n-T-l)), with R the autocorrelation of x, which is
    solved in turn (McDonald, Zhao and Zuo 2012, Eq. 14 with one shift).
    """
    column = np.fft.irfft(np.abs(np.fft.rfft(signal, 2 * len(signal))) ** 2)[:taps].copy()
    column[0] *= 1.0 + 1e-6
    output = signal[taps // 2 : len(signal) - taps + 1 + taps // 2]
    for _ in range(iterations):
        weights = np.zeros(len(output))
        weights[period:] += output[period:] * output[:-period] ** 2
        weights[:-period] += output[:-period] * output[period:] ** 2
        gradient = correlate(signal, weights, "valid", method="fft")[::-1]
        output = fftconvolve(signal, solve_toeplitz(column, gradient / np.abs(gradient).max()), "valid")
        output /= output.std()
    return output


class CorrelatedKurtosis(Demodulation):
    """Report the part whose lines have grown most, each part in the output of the filter for its own period."""

    taps = 50
    """Length of the filter [samples]."""
    iterations = 4
    """Steps of the iteration [-]."""

    def demodulated(self, acceleration, angle):
        """Return the squared envelope for impacts on the outer ring."""
        return self.output(acceleration, angle, self.orders["BPFO"])

    def output(self, acceleration, angle, order):
        """Return the squared envelope of the output of the filter for impacts at an order [-]."""
        period = round(len(acceleration) * 2.0 * np.pi / abs(angle[-1] - angle[0]) / order)
        period = min(max(period, 2), len(acceleration) // 2)
        return padded(squared_envelope(deconvolved(acceleration, period, self.taps, self.iterations)), len(acceleration))

    def features(self, acceleration, angle):
        """Return the ratio of the lines of rings and rollers to the spectrum around them."""
        found = {}
        for part in ("outer_ring", "inner_ring", "roller"):
            spectrum, turns = order_spectrum(self.output(acceleration, angle, struck(self.orders)[part]), angle)
            found[part] = line_ratios(spectrum, turns, self.orders)[part]
        return found
