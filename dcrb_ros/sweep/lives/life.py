"""The life of one bearing: its individual, the start and place of its damage, its growth to failure, and its inspections."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.prognosis.rating_life import LIFE_EXPONENT, life_survived_by, survivors
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.sweep.design import Value
from dcrb_ros.sweep.lives.duty import Duty
from dcrb_ros.sweep.lives.recipe import Recipe

COMPONENTS = {"outer": "outer_1", "inner": "inner_1", "roller": "roller_1"}
"""Key of the fault below ``faults`` by the component in `Damage`."""
FARTHEST = 1.2
"""Largest azimuth of damage of the outer raceway from the load line [rad]: beyond it no roller presses on the damage."""


@dataclass(frozen=True)
class Life:
    """One bearing from its first hour to its failure."""

    number: int
    """From 0 [-]."""
    individual: int
    """Seed of its surfaces."""
    component: str
    """``outer``, ``inner`` or ``roller``."""
    location: dict[str, Value]
    """Row, azimuth and roller of the damage by the parameter's name."""
    hours: Floats
    """From the start of the damage to failure, shape (points,) [h]."""
    widths: Floats
    """Width of the damage at these hours, shape (points,) [m]."""
    overhaul: float
    """Hours at which it leaves service at the latest [h]; infinite without an overhaul."""

    @property
    def bearing_id(self) -> str:
        """Name of the bearing."""
        return f"bearing{self.number:06d}"

    @property
    def start(self) -> float:
        """Start of the damage [h]."""
        return float(self.hours[0])

    @property
    def failure(self) -> float:
        """Functional failure: the damage has its last width [h]."""
        return float(self.hours[-1])

    @property
    def censored(self) -> bool:
        """Whether the bearing leaves service before it fails."""
        return self.failure > self.overhaul

    @property
    def end(self) -> float:
        """End of its service [h]."""
        return min(self.failure, self.overhaul)

    def width(self, hour: float) -> float:
        """Return the width of the damage at an hour, 0 before its start [m]."""
        return float(np.interp(hour, self.hours, self.widths)) if hour >= self.start else 0.0

    def count(self, every: float) -> int:
        """Return the number of `inspections` at an interval [h]."""
        return math.ceil(self.end / every) + (not self.censored)

    def inspections(self, every: float) -> Iterator[float]:
        """Yield the hours of the inspections: from 0 on at an interval [h], and at failure."""
        for count in range(math.ceil(self.end / every)):
            yield count * every
        if not self.censored:
            yield self.failure


@dataclass(frozen=True)
class Population:
    """All lives of a recipe; each is drawn from random numbers of its own, so that the others do not depend on it."""

    recipe: Recipe
    duty: Duty
    rating: float
    """Basic reference rating life [revolutions]."""
    zone_load: float
    """Equivalent load of the duty with its load zones, from which that life follows (ISO/TS 16281) [N]."""
    bearing: Bearing

    @property
    def rating_hours(self) -> float:
        """Basic reference rating life [h]."""
        return self.rating / self.duty.revolutions_per_hour

    @property
    def in_service(self) -> float:
        """Share of bearings whose damage starts before the overhaul [-]."""
        overhaul = self.recipe.inspection.overhaul
        return 1.0 - survivors(overhaul, self.rating_hours, self.recipe.start.slope) if overhaul else 1.0

    @property
    def growth_hours(self) -> float:
        """Time of mean growth from the start of the damage to failure under the duty [h]; large jumps make the median longer."""
        growth, duty = self.recipe.growth, self.duty
        return float(growth.revolutions * (growth.reference_load / duty.load) ** LIFE_EXPONENT / duty.revolutions_per_hour)

    def life(self, number: int) -> Life:
        """Return a life by its number, from 0."""
        recipe, seed = self.recipe, self.recipe.numbers.seed
        component = _component(recipe, float(self._random(number, "component").random()))
        failed = float(self._random(number, "start").random()) * (self.in_service if recipe.start.in_service else 1.0)
        start = life_survived_by(1.0 - failed, self.rating_hours, recipe.start.slope)
        path = recipe.growth.path(recipe.damage.first_width, recipe.damage.last_width, self._random(number, "growth"))
        return Life(
            number,
            1 + int(random_stream(seed, f"life {number} individual").integers(2**31 - 2)),
            component,
            self._location(component, self._random(number, "place")),
            start + self.growth_hours * path.time,
            path.width,
            recipe.inspection.overhaul or math.inf,
        )

    def lives(self) -> Iterator[Life]:
        """Yield all lives."""
        return map(self.life, range(self.recipe.numbers.lives))

    def _random(self, number: int, purpose: str) -> np.random.Generator:
        return random_stream(self.recipe.numbers.seed, f"life {number} {purpose}")

    def _location(self, component: str, random: np.random.Generator) -> dict[str, Value]:
        """Return where the damage is: under the load on the outer raceway, anywhere on the bodies that turn."""
        row, turn = 1 + int(random.integers(self.bearing.rows)), float(random.uniform(-3.14, 3.14))
        if component == "outer":
            azimuth = float(self.recipe.damage.azimuth_deviation * random.standard_normal())
            return {"row": row, "azimuth": min(max(azimuth, -FARTHEST), FARTHEST)}
        if component == "inner":
            return {"row": row, "azimuth": turn}
        return {"row": row, "azimuth": turn, "roller": 1 + int(random.integers(self.bearing.rollers_per_row))}


def _component(recipe: Recipe, share: float) -> str:
    """Return the component at a position on the shares of all components, 0 .. 1 [-]."""
    shares = [float(getattr(recipe.damage, name)) for name in COMPONENTS]
    last = next(name for name, part in reversed([*zip(COMPONENTS, shares, strict=True)]) if part > 0.0)
    return next((name for name, below in zip(COMPONENTS, accumulate(shares), strict=True) if share < below), last)
