"""What blind deconvolutions share: the autocorrelation of a signal, and the iteration to the filter of the best output."""

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import correlate, fftconvolve


def autocorrelation(signal, lags):
    """Return R_l = sum_n x_n x_(n-l) for the first ``lags``, with a millionth more at 0, so that its Toeplitz matrix is regular."""
    correlation = np.fft.irfft(np.abs(np.fft.rfft(signal, 2 * len(signal))) ** 2)[:lags]
    correlation[0] *= 1.0 + 1e-6
    return correlation


def deconvolved(signal, taps, iterations, slope):
    """Return the output y = f * x of the filter f that maximises C(y) / (sum y^2)^2; ``slope`` returns dC/dy up to a factor.

    In a stationary point R f = c sum_n slope(y)_n x_(n-l), with R the autocorrelation of x, which is solved in turn from f = a unit
    impulse in the middle (Endo and Randall 2007).
    """
    column = autocorrelation(signal, taps)
    output = signal[taps // 2 : len(signal) - taps + 1 + taps // 2]
    for _ in range(iterations):
        gradient = correlate(signal, slope(output), "valid", method="fft")[::-1]
        output = fftconvolve(signal, solve_toeplitz(column, gradient / np.abs(gradient).max()), "valid")
        output /= output.std()
    return output
