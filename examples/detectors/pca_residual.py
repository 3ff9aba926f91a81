"""The residual of a principal component model of healthy spectra, its Q statistic (Jackson and Mudholkar 1979)."""

import numpy as np
from novelty import Novelty

VARIANTS = {
    "principal components": {},
    "principal components, four": {"kept": 4},
    "principal components, factor 3": {"factor": 3.0},
}
"""Settings of each member of the family; the first has the published ones."""


class PcaResidual(Novelty):
    """Report a fault if the squared residual of the spectrum's shape has grown fivefold.

    The model is a linear autoencoder: log-spectra of healthy frames are encoded by the first principal components, and what they cannot
    decode is the residual. Independent of the gain.
    """

    factor = 5.0
    kept = 8
    """Principal components of the model [-]."""

    def described(self, frames):
        """Return ln of the power of 48 bands of equal width relative to its mean."""
        power = np.abs(np.fft.rfft(frames * np.hanning(frames.shape[1]), axis=1))[:, 1:] ** 2
        levels = np.log(np.stack([part.sum(axis=1) for part in np.array_split(power, 48, axis=1)], axis=1) + 1e-30)
        return levels - levels.mean(axis=1, keepdims=True)

    def fit(self, vectors):
        """Learn the first right singular vectors."""
        self.components = np.linalg.svd(vectors, full_matrices=False)[2][: self.kept]

    def strangeness(self, vectors):
        """Return the squared norm of the residual [-]."""
        return np.sum((vectors - vectors @ self.components.T @ self.components) ** 2, axis=1)
