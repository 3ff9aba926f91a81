"""The enhanced envelope spectrum: cyclic coherence integrated over all carriers (Antoni, Xin and Hamzaoui 2017)."""

import numpy as np
from coherence import cyclic_coherence
from spectra import line_ratios
from trending import Trending

VARIANTS = {
    "enhanced envelope spectrum": {},
    "enhanced envelope spectrum, factor 1.5": {"factor": 1.5},
    "enhanced envelope spectrum, factor 3": {"factor": 3.0},
}
"""Settings of each member of the family; the first has the published ones."""


class EnhancedEnvelope(Trending):
    """Report the part whose lines have grown most in sqrt(sum_f |gamma(f, alpha)|^2): each carrier has the same weight.

    Independent of the gain. The background of a sum of many carriers is even, so lines must only double; the factor has seen no recording.
    """

    factor = 2.0

    def features(self, acceleration, angle):
        """Return the ratio of the lines of every part to the spectrum around them."""
        coherence, turns = cyclic_coherence(acceleration, angle, self.rate)
        return line_ratios(np.sqrt(coherence.sum(axis=0)), turns, self.orders)
