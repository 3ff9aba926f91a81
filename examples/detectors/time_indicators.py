"""Crest, impulse, shape and clearance factor of the waveform: alarms without a unit (Tandon and Choudhury 1999)."""

import numpy as np
from trending import Trending

VARIANTS = {
    "waveform factors": {},
    "waveform factors, factor 1.5": {"factor": 1.5},
    "waveform factors, factor 1.25": {"factor": 1.25},
}
"""Settings of each member of the family; the first has the published ones."""


class TimeIndicators(Trending):
    """Report the most frequent fault if one of four factors has doubled over the healthy level; no part is named.

    crest = peak / rms, impulse = peak / mean |a|, shape = rms / mean |a|, clearance = peak / (mean sqrt |a|)^2. Independent of the gain.
    """

    factor = 2.0

    def features(self, acceleration, angle):
        """Return the factors."""
        size = np.abs(acceleration)
        peak, rms, mean = size.max(), np.sqrt(np.mean(size**2)), size.mean()
        return {"crest": peak / rms, "impulse": peak / mean, "shape": rms / mean, "clearance": peak / np.mean(np.sqrt(size)) ** 2}
