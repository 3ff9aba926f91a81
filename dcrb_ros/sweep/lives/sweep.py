"""A sweep of lives: the sweep of the inspections, and the population from which the lives are drawn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from dcrb_ros.faults.raceway_defect import NOTCH
from dcrb_ros.prognosis.rating_life import LIFE_MODEL
from dcrb_ros.sweep.design import Value
from dcrb_ros.sweep.lives.duty import Section
from dcrb_ros.sweep.lives.life import COMPONENTS, Population
from dcrb_ros.sweep.lives.recipe import LIFE, Recipe
from dcrb_ros.sweep.sweep_file import MOST_RUNS, Sweep

SPALL = "spall"


@dataclass(frozen=True)
class LifeSweep(Sweep):
    """A sweep of kind ``life``."""

    recipe: Recipe
    duty: tuple[dict[str, Any], ...]
    """Stations or levels as written, for the record."""
    sections: tuple[Section, ...]
    """Sections on which inspections are made."""
    population: Population

    @cached_property
    def count(self) -> int:
        """Number of runs: inspections of all lives, of which no more are drawn above `MOST_RUNS` [-]."""
        runs = 0
        for life in self.population.lives():
            runs += life.count(self.recipe.inspection.every)
            if runs > MOST_RUNS:
                break
        return runs

    @property
    def inputs(self) -> dict[str, Any]:
        """All inputs of the data set, as written to its description."""
        groups = {name: getattr(self.recipe, name).model_dump() for name in ("numbers", "inspection", "start", "damage", "growth")}
        climate = {"climate": self.recipe.climate.model_dump()} if self.recipe.climate is not None else {}
        return {**super().inputs, "kind": LIFE, "life_model": LIFE_MODEL, "duty": list(self.duty), **groups, **climate}

    def damage(self, component: str, location: Mapping[str, Value], individual: int, width: float) -> Iterator[tuple[str, Value]]:
        """Yield the parameters of the damage of a component: location, seed of the bearing, width [m]. Without width there are none."""
        if not width:
            return
        key = f"faults.{COMPONENTS[component]}"
        yield f"{key}.width", width
        yield f"{key}.depth", self.recipe.damage.depth
        for name, value in location.items():
            yield f"{key}.{name}", value
        if component != "roller":
            kind = SPALL if self.base["surfaces.law"] == "profile" else NOTCH
            yield f"{key}.kind", kind
            if kind == SPALL:
                yield f"{key}.seed", individual
                yield f"{key}.share", min(self.recipe.damage.aspect * width / float(self.base["bearing.roller_length"]), 1.0)
