"""The squared envelope spectrum of a fixed band, over the shaft angle (Randall, Antoni and Chobsaard 2001)."""

from scipy.signal import butter, sosfilt
from trending import Trending, lines

VARIANTS = {
    "squared envelope, fixed band": {},
    "squared envelope above 1 kHz": {"lowest": 1000.0},
    "squared envelope, factor 2": {"factor": 2.0},
    "squared envelope, half a second": {"window": 0.5, "hop": 0.25},
}
"""Settings of each member of the family; the first has the published ones."""


class SquaredEnvelope(Trending):
    """Report the part of the bearing whose lines in the squared envelope spectrum above 2 kHz have grown most."""

    factor = 4.0
    lowest = 2000.0
    """Lower end of the band [Hz]; gears, unbalance and wheel are below it."""

    def __init__(self, orders, rate, **settings):
        super().__init__(orders, rate, **settings)
        self.filter = butter(4, min(self.lowest, 0.25 * rate), "highpass", fs=rate, output="sos")

    def features(self, acceleration, angle):
        """Return the amplitude of the lines of every part."""
        return lines(sosfilt(self.filter, acceleration) ** 2, angle, self.orders)
