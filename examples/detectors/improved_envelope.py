"""The improved envelope spectrum, IESFO: cyclic coherence integrated over the best carriers of each part (Mauricio et al. 2020)."""

from itertools import pairwise

import numpy as np
from coherence import cyclic_coherence
from spectra import line_ratios
from trending import Trending

VARIANTS = {
    "improved envelope spectrum": {},
    "improved envelope spectrum, factor 2": {"factor": 2.0},
    "improved envelope spectrum, two levels": {"levels": 2},
}
"""Settings of each member of the family; the first has the published ones."""


class ImprovedEnvelope(Trending):
    """Report the part whose lines have grown most; the band of carriers is the one in which the lines of this part are strongest.

    Bands form a 1/3-binary tree over the carriers (Mauricio, Smith, Randall, Antoni and Gryllias 2020, section 3). Independent of the
    gain. The factor has seen no recording: a maximum over bands of noise is even, so that lines must grow by ``factor`` only.
    """

    levels = 4
    """Levels of the tree of bands [-]."""

    def features(self, acceleration, angle):
        """Return the largest ratio over the bands of the lines of every part to the spectrum around them."""
        coherence, turns = cyclic_coherence(acceleration, angle, self.rate)
        best = line_ratios(np.sqrt(coherence.sum(axis=0)), turns, self.orders)
        for level in range(1, self.levels + 1):
            for count in (2**level, 3 * 2 ** (level - 1)):
                for low, high in pairwise(np.linspace(0, len(coherence), count + 1).astype(int)):
                    if high > low:
                        found = line_ratios(np.sqrt(coherence[low:high].sum(axis=0)), turns, self.orders)
                        best = {part: max(best[part], ratio) for part, ratio in found.items()}
        return best
