"""The Mahalanobis distance of one-third octave levels from healthy ones (Mahalanobis 1936; Worden, Manson and Fieller 2000)."""

import numpy as np
from novelty import Novelty

VARIANTS = {
    "octave bands": {},
    "octave bands, shape": {"relative": 1},
    "octave bands, factor 10": {"factor": 10.0},
}
"""Settings of each member of the family; the first has the published ones."""


class OctaveBands(Novelty):
    """Report a fault if the squared Mahalanobis distance has grown fivefold.

    Amplitude-based: where the gain differs between recordings, it measures the recording. With ``relative: 1`` levels are relative to
    their mean, which is independent of the gain. The covariance is shrunk halfway to the identity, since there are few healthy frames.
    """

    factor = 5.0
    relative = 0
    """1 for levels relative to their mean, 0 for levels [-]."""

    def described(self, frames):
        """Return ln of the power of the bands from 100 Hz on."""
        frequency = np.fft.rfftfreq(frames.shape[1], 1.0 / self.rate)
        power = np.abs(np.fft.rfft(frames * np.hanning(frames.shape[1]), axis=1)) ** 2
        edges = 100.0 * 2.0 ** (np.arange(0.0, 31.0) / 3.0)
        places = np.unique(np.searchsorted(frequency, edges[edges < 0.45 * self.rate]))
        levels = np.log(np.add.reduceat(power, places, axis=1)[:, :-1] + 1e-30)
        return levels - levels.mean(axis=1, keepdims=True) if self.relative else levels

    def fit(self, vectors):
        """Learn the inverse of the shrunk covariance."""
        self.inverse = np.linalg.inv(0.5 * np.cov(vectors.T) + 0.5 * np.eye(vectors.shape[1]))

    def strangeness(self, vectors):
        """Return the squared Mahalanobis distance [-]."""
        return np.einsum("fi,ij,fj->f", vectors, self.inverse, vectors)
