"""Level and peakedness: an alarm if the rms or the kurtosis of the acceleration has grown. Neither names a part of the bearing."""

import numpy as np
from trending import Trending

VARIANTS = {
    "rms and kurtosis": {},
    "rms and kurtosis, factor 1.5": {"factor": 1.5},
    "rms and kurtosis, factor 4": {"factor": 4.0},
}
"""Settings of each member of the family; the first has the published ones."""


class RmsKurtosis(Trending):
    """Report the most frequent fault, an outer ring defect, if the rms has doubled or the kurtosis has.

    rms = sqrt(mean a^2), kurtosis = mean a^4 / (mean a^2)^2, which is 3 for noise (Dyer and Stewart 1978).
    """

    factor = 2.0

    def features(self, acceleration, angle):
        """Return both."""
        power = np.mean(acceleration**2)
        return {"rms": np.sqrt(power), "kurtosis": np.mean(acceleration**4) / power**2}
