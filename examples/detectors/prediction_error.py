"""The envelope of the error of an autoregressive model of the healthy machine (Wang and Wong 2002; Sawalhi, Randall and Endo 2007)."""

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter
from spectra import Demodulation, padded, squared_envelope

VARIANTS = {
    "prediction error": {},
    "prediction error, order 20": {"coefficients": 20},
    "prediction error, order 200": {"coefficients": 200},
}
"""Settings of each member of the family; the first has the published ones."""


class PredictionError(Demodulation):
    """Report the part whose lines have grown most in the squared envelope spectrum of the prediction error.

    The model a_n = sum_k c_k a_(n-k) is learnt from the first windows by the Yule-Walker equations, and kept: resonances and tones of
    the healthy machine are predicted, impacts are not. The published order maximises the kurtosis; 100 is a usual value.
    """

    coefficients = 100
    """Order of the model [-]."""

    def demodulated(self, acceleration, angle):
        """Return the squared envelope of the prediction error."""
        if len(self.healthy) < self.learning or not hasattr(self, "model"):
            power = np.abs(np.fft.rfft(acceleration, 2 * len(acceleration))) ** 2
            correlation = np.fft.irfft(power)[: self.coefficients + 1] / power.mean()
            self.correlation = getattr(self, "correlation", 0.0) + correlation
            column = self.correlation[:-1].copy()
            column[0] *= 1.0 + 1e-6
            self.model = np.concatenate([[1.0], -solve_toeplitz(column, self.correlation[1:])])
        return padded(squared_envelope(lfilter(self.model, 1.0, acceleration)[self.coefficients :]), len(acceleration))
