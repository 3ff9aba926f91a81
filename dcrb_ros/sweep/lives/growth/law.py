"""The interface of a law of growing damage: the width of a defect over revolutions, from its first size to failure."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, choice, quantity
from dcrb_ros.schema.refusal import Refusal

STEPS = 50
"""Steps in the time of mean growth [-]."""
LONGEST = 1000
"""Longest growth over the time of mean growth [-]."""


class GrowthPath(NamedTuple):
    """The growth of one defect; its width is interpolated linearly between the points."""

    time: Floats
    """Revolutions since the damage started over those of mean growth to failure, from 0 on, shape (points,) [-]."""
    width: Floats
    """From the first to the last width, shape (points,) [m]."""


class Growth(Group):
    """Parameters common to all laws. The constants are assumptions; a user replaces them by data of a fleet."""

    law: str = choice("paris", "Law of growth: paris, exponential or gamma")
    revolutions: float = quantity(
        5e7,
        "-",
        "Revolutions from the start of the damage to failure at the reference load, at the median rate of a bearing and with mean steps",
        1.0,
        1e14,
    )
    reference_load: float = quantity(1e5, "N", "Load of these revolutions; the rate of growth rises with its power 10/3", 1.0, 1e8)

    @abstractmethod
    def path(self, first: float, last: float, random: np.random.Generator) -> GrowthPath:
        """Return the growth of a defect from its ``first`` to its ``last`` width [m]; equal random numbers give equal paths."""


def stepped(chunk_of: Callable[[int], Floats]) -> tuple[Floats, Floats]:
    """Return times and progress from 0 to exactly 1, shape (points,) [-]; each step progresses by its rate over `STEPS`.

    ``chunk_of`` (first) gives the rates of `STEPS` steps from the ``first`` on.

    Raises:
        Refusal: the damage does not reach its last width.
    """
    rates: list[Floats] = []
    total = 0.0
    while total < STEPS:
        if len(rates) == LONGEST:
            raise Refusal(
                f"a life cannot end: after {LONGEST} times the time of mean growth its damage has made {total / STEPS:.2g} of the way to "
                "failure; give a smaller growth.scatter or a larger growth.jumps"
            )
        rates.append(chunk_of(len(rates) * STEPS))
        total += float(rates[-1].sum())
    done = np.concatenate([[0.0], np.cumsum(np.concatenate(rates)) / STEPS])
    end = int(np.argmax(done >= 1.0))
    part = (1.0 - done[end - 1]) / (done[end] - done[end - 1])
    return np.append(np.arange(end), end - 1 + part) / STEPS, np.append(done[:end], 1.0)
