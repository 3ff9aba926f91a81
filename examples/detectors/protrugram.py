"""The protrugram: demodulation of the narrow band whose envelope spectrum has the largest kurtosis (Barszcz and Jablonski 2011)."""

import numpy as np
from scipy.signal.windows import tukey
from spectra import Demodulation

VARIANTS = {
    "protrugram": {},
    "protrugram, five lines": {"lines_in_band": 5.5},
    "protrugram, no reference": {"reference": "noise"},
}
"""Settings of each member of the family; the first has the published ones."""


def kurtosis(values):
    """Return mean (v - mean v)^4 / (mean (v - mean v)^2)^2; the spectrum of an envelope with few strong lines has a large one [-]."""
    centred = values - values.mean()
    return np.mean(centred**4) / max(np.mean(centred**2) ** 2, 1e-300)


class Protrugram(Demodulation):
    """Report the part whose lines have grown most in the band with the most protruding lines.

    All bands have the same width, slightly above three times the BPFI, and their centres lie half a width apart. The kurtosis is that of
    the amplitudes of the envelope spectrum, so a single impact does not attract the band.
    """

    lines_in_band = 3.5
    """Width of the bands relative to BPFI [-]."""

    def demodulated(self, acceleration, angle):
        """Return the squared envelope of the band with the largest kurtosis."""
        transform = np.fft.rfft(acceleration * tukey(len(acceleration), 0.1))
        turns = abs(angle[-1] - angle[0]) / (2.0 * np.pi)
        slow = int(0.3 * turns)  # lines below 0.3 orders are those of the taper and of slow variation
        wide = int(self.lines_in_band * self.orders["BPFI"] * turns)
        wide = min(max(wide, len(transform) // 128), len(transform) // 2)
        best, found = -1.0, None
        for low in range(1, len(transform) - wide, max(wide // 2, 1)):
            envelope = np.abs(np.fft.ifft(transform[low : low + wide]))
            score = kurtosis(np.abs(np.fft.rfft(envelope - envelope.mean()))[slow:])
            if score > best:
                best, found = score, envelope**2
        return found
