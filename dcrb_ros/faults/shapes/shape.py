"""The interface of a shape of damage: the heights of a raceway where it is damaged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from dcrb_ros.schema.arrays import Floats


class Marks(Protocol):
    """The parameters of a defect that shapes use; lengths [m]."""

    @property
    def width(self) -> float: ...
    @property
    def depth(self) -> float: ...
    @property
    def roughness(self) -> float: ...
    @property
    def period(self) -> float: ...
    @property
    def count(self) -> int: ...


class Place(NamedTuple):
    """One of the places of a shape."""

    angle: float
    """From the defect's azimuth [rad]."""
    scale: float
    """Factor on the depth [-]."""


def one_place(pitch: float) -> Iterator[Place]:
    """Yield the defect's azimuth."""
    yield Place(0.0, 1.0)


@dataclass(frozen=True)
class Shape:
    """A shape of damage; a file with a ``SHAPE`` and a line of the registry add one."""

    name: str
    """Value of ``kind``."""
    summary: str
    """For the description of ``kind``."""
    heights: Callable[[Floats, Marks, np.random.Generator], Floats]
    """Function (x, marks, random): heights [m] at places [m] along the raceway from the middle of the damage, below zero where metal is
    missing; zero beyond ``reach``."""
    share: Callable[[Marks, float], float]
    """Function (marks, length): share of a roller's length [m] that the damage takes, unless the user gives one [-]."""
    reach: Callable[[Marks], float]
    """Function (marks): distance from the middle at which the damage ends [m]."""
    places: Callable[[float], Iterator[Place]] = one_place
    """Function (pitch): the places of the shape, for rollers a pitch apart [rad]."""


def half_width(marks: Marks) -> float:
    """Return half the width [m]."""
    return 0.5 * marks.width


def whole_length(marks: Marks, length: float) -> float:
    """Return the whole length [-]."""
    return 1.0
