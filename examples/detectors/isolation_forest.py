"""An isolation forest on statistics of short frames: strange frames are isolated by few random cuts (Liu, Ting and Zhou 2008)."""

import numpy as np
from novelty import Novelty

VARIANTS = {
    "isolation forest": {},
    "isolation forest, factor 1.15": {"factor": 1.15},
    "isolation forest, 300 trees": {"trees": 300},
}
"""Settings of each member of the family; the first has the published ones."""


class IsolationForest(Novelty):
    """Report a fault if the mean anomaly score has grown by a quarter; the score 2^(-depth / c) is near 0.5 for healthy frames, at most 1.

    Independent of the gain. The random numbers have a fixed seed. The factor has seen no recording.
    """

    factor = 1.25
    trees = 100
    """Trees of the forest [-]."""

    def described(self, frames):
        """Return logarithms of kurtosis, crest and shape factor, of the kurtosis of the difference, and of the mean frequency."""
        power, difference = np.mean(frames**2, axis=1) + 1e-30, np.diff(frames, axis=1)
        rough = np.mean(difference**2, axis=1) + 1e-30
        numbers = [
            np.mean(frames**4, axis=1) / power**2,
            np.abs(frames).max(axis=1) / np.sqrt(power),
            np.sqrt(power) / (np.abs(frames).mean(axis=1) + 1e-30),
            np.mean(difference**4, axis=1) / rough**2,
            rough / power,
        ]
        return np.log(np.stack(numbers, axis=1) + 1e-30)

    def grown(self, vectors, random, left):
        """Return a tree: a cut at a random place of a random number and two subtrees, or the number of vectors of a leaf."""
        if left == 0 or len(vectors) <= 1:
            return len(vectors)
        low, high = vectors.min(axis=0), vectors.max(axis=0)
        if not (high > low).any():
            return len(vectors)
        place = random.choice(np.flatnonzero(high > low))
        cut = random.uniform(low[place], high[place])
        below = vectors[:, place] < cut
        return place, cut, self.grown(vectors[below], random, left - 1), self.grown(vectors[~below], random, left - 1)

    def fit(self, vectors):
        """Grow the trees."""
        random, deepest = np.random.default_rng(1), int(np.ceil(np.log2(max(len(vectors), 2))))
        self.scale = path_length(len(vectors))
        self.forest = [self.grown(vectors, random, deepest) for _ in range(self.trees)]

    def strangeness(self, vectors):
        """Return the anomaly score (Liu, Ting and Zhou 2008, Eq. 2) [-]."""
        depths = np.mean([[depth(tree, vector) for vector in vectors] for tree in self.forest], axis=0)
        return 2.0 ** (-depths / self.scale)


def path_length(count):
    """Return the mean depth of an unsuccessful search among ``count`` vectors (Liu, Ting and Zhou 2008, Eq. 1) [-]."""
    return 2.0 * (np.log(count - 1.0) + 0.5772156649) - 2.0 * (count - 1.0) / count if count > 2 else float(count == 2)


def depth(tree, vector):
    """Return the depth at which a vector is isolated [-]."""
    found = 0
    while isinstance(tree, tuple):
        place, cut, below, above = tree
        tree, found = below if vector[place] < cut else above, found + 1
    return found + path_length(tree)
