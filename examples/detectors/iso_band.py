"""A band alarm in the manner of ISO 20816: the rms of the vibration velocity between 10 and 1000 Hz. It names no part of the bearing."""

import numpy as np
from trending import Trending

VARIANTS = {
    "ISO 20816 band alarm": {},
    "ISO 20816 band alarm, class I": {"zone_b": 1.8e-3},
    "ISO 20816 band alarm, class IV": {"zone_b": 7.1e-3},
}
"""Settings of each member of the family; the first has the published ones."""


class IsoBand(Trending):
    """Report the most frequent fault if the velocity exceeds the healthy level by a quarter of the limit of zone B.

    ISO 20816-1 sets the alarm to the baseline plus 25 % of the upper limit of zone B.
    """

    factor = 1.0
    zone_b = 4.5e-3
    """Upper limit of zone B [m/s] of a large machine on a rigid foundation, class III of ISO 10816-1."""

    def features(self, acceleration, angle):
        """Return the rms velocity relative to the alarm."""
        frequency = np.fft.rfftfreq(len(acceleration), 1.0 / self.rate)
        band = (frequency >= 10.0) & (frequency <= 1000.0)
        velocity = np.fft.rfft(acceleration)[band] / (2.0 * np.pi * frequency[band])
        level = np.sqrt(2.0 * np.sum(np.abs(velocity) ** 2)) / len(acceleration)  # Parseval
        if len(self.healthy) < self.learning:
            self.alarm = max(level, getattr(self, "alarm", 0.0) - 0.25 * self.zone_b) + 0.25 * self.zone_b
            return {"outer_ring": 1.0}
        return {"outer_ring": level / self.alarm}
