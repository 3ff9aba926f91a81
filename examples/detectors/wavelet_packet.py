"""The distance of wavelet packet energies to their nearest healthy neighbours (Yen and Lin 2000; Fix and Hodges 1951)."""

import numpy as np
from novelty import Novelty

VARIANTS = {
    "wavelet packets": {},
    "wavelet packets, three levels": {"levels": 3},
    "wavelet packets, one neighbour": {"neighbours": 1},
}
"""Settings of each member of the family; the first has the published ones."""


DB4 = np.array([0.23037781, 0.71484657, 0.63088077, -0.02798377, -0.18703481, 0.03084138, 0.03288301, -0.01059740])
"""Low-pass filter of Daubechies with four vanishing moments [-] (Daubechies 1992)."""


class WaveletPacket(Novelty):
    """Report a fault if the mean squared distance to the nearest healthy frames has grown threefold.

    A frame is described by the logarithms of the shares of the wavelet packets in its energy, which are independent of the gain.
    """

    levels = 4
    """Levels of the tree of packets [-]."""
    neighbours = 5
    """Healthy frames over which the distance is averaged [-]."""

    def described(self, frames):
        """Return ln of the share of every packet in the energy of a frame."""
        low, high = DB4, DB4[::-1] * (-1.0) ** np.arange(len(DB4))
        packets = [frames]
        for _ in range(self.levels):
            if packets[0].shape[1] < len(DB4):
                break
            views = [np.lib.stride_tricks.sliding_window_view(packet, len(DB4), axis=1)[:, ::2] for packet in packets]
            packets = [view @ taps for view in views for taps in (low, high)]
        energy = np.stack([np.mean(packet**2, axis=1) for packet in packets], axis=1) + 1e-30
        return np.log(energy / energy.sum(axis=1, keepdims=True))

    def fit(self, vectors):
        """Keep the healthy vectors."""
        self.kept = vectors

    def strangeness(self, vectors):
        """Return the mean squared distance to the nearest healthy vectors [-]."""
        squared = np.sum((vectors[:, None, :] - self.kept) ** 2, axis=2)
        return np.sort(squared, axis=1)[:, : self.neighbours].mean(axis=1)
