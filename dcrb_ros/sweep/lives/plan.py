"""The plan of a sweep of lives: one run for each inspection of each bearing, with its truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.sweep.design import Point
from dcrb_ros.sweep.division import batches, splits
from dcrb_ros.sweep.lives.card import design_text
from dcrb_ros.sweep.lives.duty import Section
from dcrb_ros.sweep.lives.life import Life
from dcrb_ros.sweep.lives.sweep import LifeSweep
from dcrb_ros.sweep.lives.table import TRUTH, lives_table
from dcrb_ros.sweep.plan import SEED, Plan, PlannedRun, Task, digest
from dcrb_ros.sweep.sweep_file import EXTENDED

AMBIENT = "thermal.ambient"
COLDEST_AND_HOTTEST = (-40.0, 60.0)
"""Range of that parameter [deg C]; a draw beyond it is set to the limit."""


class LifePlan(Plan):
    """The runs of a sweep of lives; a bearing is in one split with all its inspections."""

    sweep: LifeSweep
    unit, remedy = "bearing", "increase lives"
    truth = TRUTH
    split_text = "All inspections of a bearing are in one split. All bearings are on one machine, that of the base."

    def __init__(self, sweep: LifeSweep) -> None:
        # The parts of the sweep are lives, not points.
        super().__init__(replace(sweep, file=sweep.file.model_copy(update={EXTENDED: []})))
        self.sweep = sweep
        # Neither the version nor the model is part of these hashes, so that splits and noise stay what they are.
        self._bearings = [digest([sweep.recipe.numbers.seed, number]) for number in range(sweep.recipe.numbers.lives)]
        parts = batches(sweep.file.extended, len(self._bearings))
        self._splits = {
            name: split for part in parts for name, split in splits(set(self._bearings[slice(*part)]), sweep.file.split).items()
        }
        self.shared = {}
        self.conditions = len(self._bearings)
        weights = np.cumsum([section.steady for section in sweep.sections])
        self._shares = weights / weights[-1]

    def groups(self) -> Iterator[Task]:
        """Yield the inspections one by one."""
        position = 0
        for life in self.sweep.population.lives():
            hours = list(life.inspections(self.sweep.recipe.inspection.every))
            conditions = zip(hours, self._sections(life, len(hours)), self._ambient(life, hours), strict=True)
            for number, (hour, section, ambient) in enumerate(conditions):
                yield (self._inspection(position, life, number, hour, section, ambient),)
                position += 1

    def design_text(self) -> str:
        """Return the section of the data card about the lives."""
        return design_text(self.sweep)

    def tables(self) -> Iterator[tuple[str, bytes]]:
        """Yield the table of the lives."""
        yield "lives.parquet", lives_table(self.sweep, lambda life: self._splits[self._bearings[life.number]])

    def _inspection(self, position: int, life: Life, number: int, hour: float, section: Section, ambient: Point) -> PlannedRun:
        bearing, width = self._bearings[life.number], life.width(hour)
        twin = digest([bearing, number])
        seed = int(twin[:8], 16) >> 1
        healthy: Point = {
            "operating.speed": section.speed,
            "operating.load": section.load,
            "surfaces.seed": life.individual,
            SEED: seed,
            **ambient,
        }
        changes = {**healthy, **dict(self.sweep.damage(life.component, life.location, life.individual, width))}
        return PlannedRun(
            position,
            digest([self._common, self._difference(changes), None]),
            life.component if width else "healthy",
            twin,
            bearing,
            self._splits[bearing],
            changes,
            healthy,
            "",
            seed,
            truth={
                "bearing_id": life.bearing_id,
                "inspection": number,
                "hours": hour,
                "section": section.name,
                "damage": width,
                "remaining_life": life.failure - hour,
                "censored": life.censored,
            },
        )

    def _sections(self, life: Life, count: int) -> list[Section]:
        """Return the sections on which the inspections of a life are made, drawn by the hours at constant speed."""
        seed = self.sweep.recipe.numbers.seed
        shares = random_stream(seed, f"life {life.number} sections").random(count)
        numbers = np.minimum(np.searchsorted(self._shares, shares, side="right"), len(self._shares) - 1)
        return [self.sweep.sections[number] for number in numbers]

    def _ambient(self, life: Life, hours: list[float]) -> Iterator[Point]:
        """Yield the temperature of the surroundings at the inspections of a life as a parameter; none without a climate."""
        climate = self.sweep.recipe.climate
        if climate is None:
            yield from ({} for _ in hours)
            return
        random = random_stream(self.sweep.recipe.numbers.seed, f"life {life.number} climate")
        turns = float(random.random()) + np.array(hours) / climate.hours_per_year
        drawn = climate.mean + climate.season * np.sin(2.0 * np.pi * turns) + climate.day * random.standard_normal(len(hours))
        yield from ({AMBIENT: value} for value in np.clip(drawn, *COLDEST_AND_HOTTEST).tolist())
