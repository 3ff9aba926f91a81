"""A random stream for every stage, so that switching one stage on changes no random number of another."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator

import numpy as np


def random_stream(seed: int, stage: str) -> np.random.Generator:
    """Return the random numbers of a stage: a Philox stream whose key is a hash of the seed and the stage's name."""
    key = hashlib.sha256(f"{seed}/{stage}".encode()).digest()
    return np.random.Generator(np.random.Philox(key=int.from_bytes(key[:16], "little")))


class PoissonTimes:
    """Times of a Poisson process, in ticks: the intervals between them are exponentially distributed."""

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._next, self._per_tick = -math.inf, 0.0

    def within(self, first: int, count: int, per_tick: float) -> Iterator[tuple[float, float]]:
        """Yield the times within ``count`` ticks from ``first`` on, each with a random number from 0 to 1.

        ``per_tick`` is the mean number of times in a tick. Where it changes, the rest of the present interval changes with it.
        """
        if self._next < first:
            self._next = first + self._gap(per_tick)
        elif per_tick != self._per_tick:
            self._next = first + (self._next - first) * (self._per_tick / per_tick)
        self._per_tick = per_tick
        while self._next < first + count:
            yield self._next, float(self._random.random())
            self._next += self._gap(per_tick)

    def _gap(self, per_tick: float) -> float:
        return -math.log1p(-float(self._random.random())) / per_tick
