"""What learned detectors of novelty share: frames of the healthy windows, and the score of later ones relative to theirs."""

from abc import abstractmethod

import numpy as np
from trending import Trending

FRAMES = 20
"""Frames of a window [-]."""


class Novelty(Trending):
    """Report the most frequent fault if frames are much stranger than healthy ones; a subclass describes frames and scores them.

    The model is fitted to the even frames of the first windows, and the mean score of the odd ones is the healthy level, so that the level
    is not that of fitted data. No part is named. Factors have seen no recording.
    """

    def __init__(self, orders, rate, **settings):
        super().__init__(orders, rate, **settings)
        self.frames, self.level = [], None

    @abstractmethod
    def described(self, frames):
        """Return a vector of numbers of every frame, of shape (frames, numbers); ``frames`` has the shape (frames, samples)."""

    @abstractmethod
    def fit(self, vectors):
        """Learn the vectors of healthy frames, of shape (frames, numbers), with a mean of 0 and a deviation of 1."""

    @abstractmethod
    def strangeness(self, vectors):
        """Return a positive score of every vector, larger for stranger ones."""

    def features(self, acceleration, angle):
        """Return the mean strangeness of the frames relative to that of healthy ones; 1 while learning."""
        length = len(acceleration) // FRAMES
        vectors = self.described(acceleration[: FRAMES * length].reshape(FRAMES, length))
        if len(self.healthy) < self.learning:
            self.frames.append(vectors)
            return {"outer_ring": 1.0}
        if self.level is None:
            healthy = np.concatenate(self.frames)
            self.mean, self.deviation = healthy.mean(axis=0), healthy.std(axis=0) + 1e-9
            self.fit((healthy[::2] - self.mean) / self.deviation)
            self.level = max(np.mean(self.strangeness((healthy[1::2] - self.mean) / self.deviation)), 1e-9)
        return {"outer_ring": np.mean(self.strangeness((vectors - self.mean) / self.deviation)) / self.level}
