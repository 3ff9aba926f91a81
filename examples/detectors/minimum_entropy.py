"""Minimum entropy deconvolution: the filter with the most impulsive output (Wiggins 1978; Endo and Randall 2007)."""

from deconvolution import deconvolved
from spectra import Demodulation, padded, squared_envelope

VARIANTS = {
    "minimum entropy deconvolution": {},
    "minimum entropy deconvolution, 100 taps": {"taps": 100},
    "minimum entropy deconvolution, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


class MinimumEntropy(Demodulation):
    """Report the part whose lines have grown most in the squared envelope spectrum of the deconvolved signal.

    The filter maximises the kurtosis sum y^4 / (sum y^2)^2 of its output y.
    """

    taps = 50
    """Length of the filter [samples]."""
    iterations = 8
    """Steps of the iteration [-]."""

    def demodulated(self, acceleration, angle):
        """Return the squared envelope of the output of the filter."""
        output = deconvolved(acceleration, self.taps, self.iterations, lambda output: output**3)
        return padded(squared_envelope(output), len(acceleration))
