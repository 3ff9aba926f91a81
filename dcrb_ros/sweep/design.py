"""Experimental designs: points in the space of the varied parameters, generated one at a time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

Value = bool | int | float | str

GRID, RANDOM, LATIN_HYPERCUBE = "grid", "random", "latin_hypercube"


@dataclass(frozen=True)
class Choice:
    """An axis with listed values."""

    values: tuple[Value, ...]

    def at(self, share: float) -> Value:
        """Return the value at a position on the axis, 0 .. 1 [-]."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]

    def grid(self) -> tuple[Value, ...]:
        """Return the values of a grid."""
        return self.values


@dataclass(frozen=True)
class Span:
    """An axis with a closed range of values."""

    low: float
    high: float
    log: bool = False
    """Whether the axis is logarithmic."""
    whole: bool = False
    """Whether the values are integers."""
    count: int = 0
    """Number of values in a grid [-]."""

    def at(self, share: float) -> Value:
        """Return the value at a position on the axis, 0 .. 1 [-]."""
        if self.whole and not self.log:
            return min(math.floor(self.low + share * (self.high - self.low + 1.0)), int(self.high))
        exact = self.low * (self.high / self.low) ** share if self.log else self.low + share * (self.high - self.low)
        value = min(max(exact, self.low), self.high)
        return round(value) if self.whole else value

    def grid(self) -> tuple[Value, ...]:
        """Return the values of a grid, including both ends."""
        last = max(self.count - 1, 1)
        if self.whole and not self.log:
            return tuple(round(self.low + k * (self.high - self.low) / last) for k in range(self.count))
        return tuple(self.at(k / last) for k in range(self.count))


Axis = Choice | Span
Axes = Mapping[str, Axis]
Point = dict[str, Value]


def size(design: str, axes: Axes, count: int) -> int:
    """Return the number of points of a design [-]; ``count`` gives it for all designs except a grid."""
    return math.prod(len(axis.grid()) for axis in axes.values()) if design == GRID else count


def grid_parts(axes: Axes, extents: Sequence[Mapping[str, int]]) -> Iterator[Iterator[Point]]:
    """Yield the points of a grid that were added together: those of the first values of each axis, then those that more values add.

    ``extents`` are the numbers of the first values of each axis, from the smallest grid to the whole one [-].
    """
    values = {key: axis.grid() for key, axis in axes.items()}
    for inner, outer in itertools.pairwise([dict.fromkeys(axes, 0), *extents]):
        numbers = itertools.product(*(range(outer[key]) for key in axes))
        added = (chosen for chosen in numbers if not axes or any(k >= inner[key] for key, k in zip(axes, chosen, strict=True)))
        yield ({key: values[key][k] for key, k in zip(axes, chosen, strict=True)} for chosen in added)


def points(design: str, axes: Axes, count: int, seed: int, first: int = 0) -> Iterator[Point]:
    """Yield the points of a design; equal arguments yield equal points. Points from a ``first`` number on are added to earlier ones."""
    if design == GRID:
        for values in itertools.product(*(axis.grid() for axis in axes.values())):
            yield dict(zip(axes, values, strict=True))
    else:
        for shares in _shares(design, len(axes), count, seed, first):
            yield {key: axis.at(float(share)) for (key, axis), share in zip(axes.items(), shares, strict=True)}


def _shares(design: str, axes: int, count: int, seed: int, first: int) -> Iterator[np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    """Yield ``count`` points in the unit cube, each of shape (axes,) [-]."""
    if not axes:
        yield from (np.zeros(0) for _ in range(count))
    elif design == RANDOM:
        for number in range(first, first + count):
            yield np.random.default_rng([seed, number]).random(axes)
    else:
        from scipy.stats import qmc  # imported here since it takes a second, and the workers do not need it

        # The stratification needs all points at once: 8 bytes per point and axis.
        yield from qmc.LatinHypercube(axes, seed=np.random.default_rng([seed, first]) if first else seed).random(count)
