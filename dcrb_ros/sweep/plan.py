"""The plan: every run of a sweep with its name, twin and split, generated one at a time."""

from __future__ import annotations

import functools
import hashlib
import itertools
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from dcrb_ros.recordings.manifest import model_fingerprint
from dcrb_ros.runtime.version import __version__
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten
from dcrb_ros.sweep.design import GRID, Point, Value, grid_parts, points
from dcrb_ros.sweep.division import Unit, batches, checked_extents, divided, separation
from dcrb_ros.sweep.identity import BEARING_ID, TRUTH, drawn_by_noise, identities
from dcrb_ros.sweep.sweep_file import NO_FAULTS, SCENARIO, Sweep

SEED = "simulation.seed"
NOT_CONDITIONS = ("faults", "structure", "background", "sensor", "publishing", "recording", "time_scale")
"""Groups of parameters that do not belong to the condition of the bearing: faults, measurement and output."""


def digest(about: Any) -> str:
    """Return a short hash of a tree that can be written as JSON."""
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()[:20]


@dataclass(frozen=True)
class PlannedRun:
    """One run of a plan."""

    position: int
    """In the plan, from 0 [-]."""
    name: str
    """Hash of everything that the samples depend on."""
    case: str
    twin: str
    """Shared by the runs that differ in the fault only."""
    condition: str
    """Shared by the runs of one bearing at one speed and load, with any fault and seed."""
    split: str
    changes: Mapping[str, Value]
    """Parameters that differ from the sweep's base."""
    healthy: Mapping[str, Value]
    """Parameters that differ from the sweep's base in the healthy bearing from which the run branches, if it branches."""
    scenario: str
    seed: int
    truth: Mapping[str, Value] = field(default_factory=dict)
    """Further values of the label, by the columns in `Plan.truth`."""


Task = tuple[PlannedRun, ...]
"""Runs that one worker simulates one after the other."""


class Plan:
    """The runs of a sweep, in a fixed order and without duplicates."""

    unit, remedy = "condition", "vary speed or load"
    """Name of one of the units that are divided into splits, and how to get more of them."""
    unit_column = "condition"
    """Column of the labels with the name of the unit."""
    truth: Mapping[str, tuple[type, str]] = TRUTH
    """Type and meaning of the columns that the labels have beside those of every sweep."""

    def __init__(self, sweep: Sweep) -> None:
        self.sweep = sweep
        file, base = sweep.file, dict(sweep.base)
        self._common = digest([base, __version__, model_fingerprint(), file.duration, file.settle, file.branch_at])
        self._defaults = flatten(Configuration().model_dump())
        self._own = identities(base, self._defaults)
        self.batches = [] if file.design == GRID else batches(file.extended, file.points)
        """First number and number after the last of the points that were added together; empty for a grid."""
        parts = [{self._unit(point) for point in points} for points in self._point_batches()]
        self._splits, self.shared = divided(parts, file.split)
        self.conditions = len(self._splits)

    @functools.cached_property
    def name(self) -> str:
        """Hash of the sweep, the version and the model; equal names give equal data sets."""
        return digest([self.sweep.inputs, dict(self.sweep.base), dict(self.sweep.scenarios), __version__, model_fingerprint()])

    @property
    def split_text(self) -> str:
        """How the data are divided, for the data card."""
        return (
            "A condition is a bearing at one speed and load. All its runs, with any seed, fault or sensor, are in one split. So are twins, "
            "the runs\nof one condition and seed that differ in the fault only.\n\n" + "\n".join(separation(self.shared))
        )

    def design_text(self) -> str:
        """Return the design for the data card; empty for the one that follows from the sweep file."""
        return ""

    def tables(self) -> Iterator[tuple[str, bytes]]:
        """Yield name and contents of further tables of the data set."""
        return iter(())

    def runs(self) -> Iterator[PlannedRun]:
        """Yield every run."""
        return itertools.chain.from_iterable(self.groups())

    def groups(self) -> Iterator[Task]:
        """Yield the runs of each condition and seed as a group."""
        known: set[bytes] = set()
        cases_of_groups = self._cases()
        for point in self._points():
            condition = self._condition(point)
            for seed in self._seeds(condition):
                group = []
                for case, values in next(cases_of_groups):
                    run = self._run(len(known), condition, seed, point, case, values)
                    brief = bytes.fromhex(run.name)
                    if brief not in known:
                        known.add(brief)
                        group.append(run)
                if group:
                    yield tuple(group)

    def tasks(self, done: set[str], seconds: float) -> Iterator[Task]:
        """Yield the runs that are not ``done`` in tasks of at least ``seconds`` of simulated time [s]; a group is never divided."""
        run_time, task = self.sweep.file.duration + self.sweep.file.settle, []
        for group in self.groups():
            task += [run for run in group if run.name not in done]
            if task and len(task) * run_time >= seconds:
                yield tuple(task)
                task = []
        if task:
            yield tuple(task)

    def _points(self) -> Iterator[Point]:
        return itertools.chain.from_iterable(self._point_batches())

    def _point_batches(self) -> Iterator[Iterator[Point]]:
        """Yield the points that were added together; the first ones are those of the sweep before it was extended."""
        file = self.sweep.file
        if file.design == GRID:
            yield from grid_parts(self.sweep.vary, checked_extents(file.extended, self.sweep.vary))
        for first, last in self.batches:
            yield points(file.design, self.sweep.vary, last - first, file.seed, first)

    def _unit(self, point: Point) -> Unit:
        condition = self._condition(point)
        return Unit(condition, **self._identities(point, condition))

    def _cases(self) -> Iterator[list[tuple[str, Point]]]:
        """Yield the cases of each condition and seed: all values of a grid, or one random point per case."""
        file, cases = self.sweep.file, self.sweep.cases
        if file.design == GRID:
            yield from itertools.repeat([(name, values) for name, axes in cases.items() for values in points(GRID, axes, 0, file.seed)])
        for first, last in self.batches:
            count, start = (last - first) * self.sweep.seeds, first * self.sweep.seeds
            drawn = [points(file.design, axes, count, int(digest([file.seed, name])[:8], 16), start) for name, axes in cases.items()]
            for values in zip(*drawn, strict=True):
                yield list(zip(cases, values, strict=True))

    def _difference(self, changes: Point) -> Point:
        """Return the parameters that differ from the base; equal bearings have equal differences.

        Another preset replaces the sensor of the base, so that all parameters of the sensor are kept with it.
        """
        base = self.sweep.base
        replaced = changes.get("sensor.preset", base.get("sensor.preset")) != base.get("sensor.preset")
        return {key: value for key, value in changes.items() if base.get(key) != value or (replaced and key.startswith("sensor."))}

    def _condition(self, point: Point) -> str:
        """Return the hash of the differences from the defaults, so that a parameter added later does not change splits and seeds."""
        values = {key: value for key, value in {**self.sweep.base, **point}.items() if key.split(".")[0] not in NOT_CONDITIONS}
        return digest({key: value for key, value in values.items() if key not in (SEED, SCENARIO) and value != self._defaults.get(key)})

    def _identities(self, point: Point, condition: str) -> dict[str, str]:
        """Return the hashes of bearing and machine; without a seed of the surfaces, all seeds of a condition count as one bearing."""
        parameters = identities(point, self._defaults, self._own)
        if isinstance(self.sweep.file.seeds, int) and drawn_by_noise(parameters[BEARING_ID], self._defaults):
            parameters[BEARING_ID]["condition"] = condition
        return {name: digest(values) for name, values in parameters.items()}

    def _seeds(self, condition: str) -> list[int]:
        """Return the seeds of a condition: as given, or derived from the condition so that no two conditions share their noise."""
        seeds = self.sweep.file.seeds
        return seeds if isinstance(seeds, list) else [int(digest([condition, k])[:8], 16) >> 1 for k in range(seeds)]

    def _run(self, position: int, condition: str, seed: int, point: Point, case: str, values: Point) -> PlannedRun:
        parameters = {**point, **values}
        scenario = str(parameters.pop(SCENARIO, ""))
        changes = {**parameters, SEED: seed}
        healthy = self._difference({**{key: value for key, value in point.items() if key != SCENARIO}, **NO_FAULTS, SEED: seed})
        return PlannedRun(
            position,
            digest([self._common, self._difference(changes), self.sweep.scenarios.get(scenario)]),
            case,
            digest([self._common, healthy, point.get(SCENARIO, "")]),
            condition,
            self._splits[condition],
            changes,
            healthy,
            scenario,
            seed,
            self._identities(point, condition),
        )
