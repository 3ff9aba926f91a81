"""Random numbers: a stream of its own for every stage, so that switching one stage changes no other."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator

import numpy as np


def stream(seed: int, stage: str) -> np.random.Generator:
    """Return the random numbers of a stage: a Philox stream whose key is a hash of the seed and the stage's name."""
    key = hashlib.sha256(f"{seed}/{stage}".encode()).digest()
    return np.random.Generator(np.random.Philox(key=int.from_bytes(key[:16], "little")))


class RandomTimes:
    """Times without a period, in ticks: the gaps between them are exponential, as a Poisson process has them."""

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._next = -math.inf

    def within(self, first: int, count: int, per_tick: float) -> Iterator[tuple[float, float]]:
        """Yield the times of ``count`` ticks from ``first`` on, so many ``per_tick`` on average, each with a number from 0 to 1."""
        if self._next < first:
            self._next = first + self._gap(per_tick)
        while self._next < first + count:
            yield self._next, float(self._random.random())
            self._next += self._gap(per_tick)

    def _gap(self, per_tick: float) -> float:
        return -math.log1p(-float(self._random.random())) / per_tick
