"""The squared envelope spectrum of a fixed band, over the shaft angle (Randall, Antoni and Chobsaard 2001)."""

from spectra import highpass, line_regions, order_spectrum, struck
from trending import Trending

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

    def features(self, acceleration, angle):
        """Return the amplitude of the lines of every part."""
        spectrum, turns = order_spectrum(highpass(acceleration, self.rate, self.lowest) ** 2, angle)
        regions = {part: line_regions(spectrum, turns, order) for part, order in struck(self.orders).items()}
        return {part: sum(near.max() for near, _ in harmonics) for part, harmonics in regions.items()}
