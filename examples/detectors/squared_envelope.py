"""The squared envelope spectrum of a fixed band, over the shaft angle (Antoni 2006)."""

from scipy.signal import butter, sosfilt
from trending import Trending, lines

LOWEST = 2000.0
"""Lower end of the band [Hz]; gears, unbalance and wheel are below it."""


class SquaredEnvelope(Trending):
    """Report the part of the bearing whose lines in the squared envelope spectrum above 2 kHz have grown most."""

    factor = 4.0

    def __init__(self, orders, rate):
        super().__init__(orders, rate)
        self.filter = butter(4, LOWEST, "highpass", fs=rate, output="sos")

    def features(self, acceleration, angle):
        """Return the amplitude of the lines of every part."""
        return lines(sosfilt(self.filter, acceleration) ** 2, angle, self.orders)
