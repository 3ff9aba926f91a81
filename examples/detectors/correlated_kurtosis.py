"""Maximum correlated kurtosis deconvolution, MCKD, at the period of each part (McDonald, Zhao and Zuo 2012)."""

import numpy as np
from deconvolution import deconvolved
from spectra import Demodulation, line_ratios, order_spectrum, padded, squared_envelope, struck

VARIANTS = {
    "MCKD": {},
    "MCKD, factor 2": {"factor": 2.0},
    "MCKD, 100 taps": {"taps": 100},
}
"""Settings of each member of the family; the first has the published ones."""


def slope(output, period):
    """Return y_n y_(n-T)^2 + y_n y_(n+T)^2 of an output y, half the slope of sum (y_n y_(n-T))^2, T the period [samples]."""
    slopes = np.zeros(len(output))
    slopes[period:] += output[period:] * output[:-period] ** 2
    slopes[:-period] += output[:-period] * output[period:] ** 2
    return slopes


class CorrelatedKurtosis(Demodulation):
    """Report the part whose lines have grown most, each part in the output of the filter for its own period.

    The filter maximises the correlated kurtosis sum (y_n y_(n-T))^2 / (sum y^2)^2 of its output y, T the period (McDonald, Zhao and Zuo
    2012, with one shift).
    """

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
        output = deconvolved(acceleration, self.taps, self.iterations, lambda output: slope(output, period))
        return padded(squared_envelope(output), len(acceleration))

    def features(self, acceleration, angle):
        """Return the ratio of the lines of rings and rollers to the spectrum around them."""
        found = {}
        for part in ("outer_ring", "inner_ring", "roller"):
            spectrum, turns = order_spectrum(self.output(acceleration, angle, struck(self.orders)[part]), angle)
            found[part] = line_ratios(spectrum, turns, self.orders)[part]
        return found
