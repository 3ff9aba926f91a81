"""A band alarm in the manner of ISO 20816: the rms of the vibration velocity between 10 and 1000 Hz. It names no part of the bearing."""

import numpy as np
from trending import Trending

ZONE_B = 4.5e-3
"""Upper limit of zone B of a medium machine on a rigid foundation [m/s], as in ISO 10816-1 class II to III."""


class IsoBand(Trending):
    """Report the most frequent fault if the velocity exceeds the healthy level by a quarter of the limit of zone B.

    ISO 20816-1 sets the alarm to the baseline plus 25 % of the upper limit of zone B.
    """

    factor = 1.0

    def features(self, acceleration, angle):
        """Return the rms velocity relative to the alarm."""
        frequency = np.fft.rfftfreq(len(acceleration), 1.0 / self.rate)
        band = (frequency >= 10.0) & (frequency <= 1000.0)
        velocity = np.fft.rfft(acceleration)[band] / (2.0 * np.pi * frequency[band])
        level = np.sqrt(2.0 * np.sum(np.abs(velocity) ** 2)) / len(acceleration)  # Parseval
        if len(self.healthy) < self.learning:
            self.alarm = max(level, getattr(self, "alarm", 0.0) - 0.25 * ZONE_B) + 0.25 * ZONE_B
            return {"outer_ring": 1.0}
        return {"outer_ring": level / self.alarm}
