"""Peaks of the cepstrum at the period of each part, its rahmonics (Bogert, Healy and Tukey 1963; Randall 2011)."""

from typing import Literal

import numpy as np
from spectra import highpass, struck
from trending import SLIP, Trending

VARIANTS = {
    "cepstrum": {},
    "cepstrum of the envelope": {"of": "envelope"},
    "cepstrum, factor 1.5": {"factor": 1.5},
}
"""Settings of each member of the family; the first has the published ones."""


class Rahmonics(Trending):
    """Report the part whose rahmonics have grown most in the real cepstrum c = F^-1 ln |F a|^2.

    A family of harmonics and sidebands of equal spacing is one peak of the cepstrum at the period. Independent of the gain, which is the
    value at zero. Slip blurs the harmonics at high frequency, so the cepstrum of the envelope is a member, too. No recording was used.
    """

    factor = 2.0
    of: Literal["signal", "envelope"] = "signal"
    """The envelope is the squared signal above 2 kHz."""
    highest = 3
    """Rahmonics that are added [-]."""

    def features(self, acceleration, angle):
        """Return the sum over rahmonics of peak over median of the cepstrum around it, for rings and rollers."""
        signal = acceleration if self.of == "signal" else highpass(acceleration, self.rate, 2000.0) ** 2
        power = np.abs(np.fft.rfft((signal - signal.mean()) * np.hanning(len(signal)))) ** 2
        cepstrum = np.abs(np.fft.irfft(np.log(np.maximum(power, 1e-12 * power.max()))))
        turn, found = len(acceleration) * 2.0 * np.pi / abs(angle[-1] - angle[0]), {}
        for part in ("outer_ring", "inner_ring", "roller"):
            found[part] = 0.0
            for place in turn / struck(self.orders)[part] * np.arange(1, self.highest + 1):
                near = cepstrum[int((1.0 - SLIP) * place) : int((1.0 + SLIP) * place) + 2]
                found[part] += near.max() / np.median(cepstrum[int(0.8 * place) : int(1.2 * place) + 3])
        return found
