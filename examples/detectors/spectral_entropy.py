"""Spectral entropy and flatness: how evenly the power is spread over the frequencies (Pan, Chen and Li 2009; Dubnov 2004)."""

from typing import Literal

import numpy as np
from trending import Trending

VARIANTS = {
    "spectral entropy": {},
    "spectral entropy, factor 2": {"factor": 2.0},
    "spectral flatness": {"of": "flatness"},
}
"""Settings of each member of the family; the first has the published ones."""


class SpectralEntropy(Trending):
    """Report the most frequent fault if the effective number of bands has changed by ``factor``, up or down; no part is named.

    With the shares p of 128 bands of equal width in the power, exp(-sum p ln p) is the effective number of bands, and flatness is their
    geometric over their arithmetic mean. Resonances that impacts excite concentrate or spread the power. Independent of the gain. The
    factor has seen no recording.
    """

    factor = 1.5
    of: Literal["entropy", "flatness"] = "entropy"

    def __init__(self, orders, rate, **settings):
        super().__init__(orders, rate, **settings)
        self.levels = []

    def features(self, acceleration, angle):
        """Return the ratio of the measure to its healthy mean, or its inverse, whichever is larger."""
        power = np.abs(np.fft.rfft(acceleration * np.hanning(len(acceleration)))) ** 2
        shares = np.array([part.sum() for part in np.array_split(power[1:], 128)]) / power[1:].sum() + 1e-12
        value = np.exp(-np.sum(shares * np.log(shares)) if self.of == "entropy" else np.mean(np.log(shares)))
        if len(self.healthy) < self.learning:
            self.levels.append(value)
        ratio = value / np.mean(self.levels)
        return {"outer_ring": max(ratio, 1.0 / ratio)}
