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
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten
from dcrb_ros.sweep.design import GRID, Point, Value, points
from dcrb_ros.sweep.identity import TRUTH, Groups, identities
from dcrb_ros.sweep.sweep_file import NO_FAULTS, SCENARIO, Shares, Sweep

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

    unit, remedy = "conditions", "vary speed or load"
    """Name of the units that are divided into splits, and how to get more of them."""
    split_text = (
        "A condition is a bearing at one speed and load. All its runs, with any seed, fault or sensor, are in one split. So are twins, the "
        "runs\nof one condition and seed that differ in the fault only."
    )
    """How the data are divided, for the data card."""

    def __init__(self, sweep: Sweep) -> None:
        self.sweep = sweep
        file, base = sweep.file, dict(sweep.base)
        self._common = digest([base, __version__, model_fingerprint(), file.duration, file.settle, file.branch_at])
        self._defaults = flatten(Configuration().model_dump())
        self._own = identities(base, self._defaults)
        groups, conditions = Groups(), set[str]()
        for point in self._points():
            condition = self._condition(point)
            conditions.add(condition)
            shared = self._identities(point) if file.split.apart else {}
            groups.add(condition, {name: shared[name] for name in file.split.apart})
        group_of = {condition: groups.group(condition) for condition in conditions}
        split_of = splits(set(group_of.values()), file.split)
        _check_groups(len(set(group_of.values())), len(conditions), file.split)
        self._splits = {condition: split_of[group] for condition, group in group_of.items()}
        self.conditions = len(conditions)

    @functools.cached_property
    def name(self) -> str:
        """Hash of the sweep, the version and the model; equal names give equal data sets."""
        return digest([self.sweep.inputs, dict(self.sweep.base), dict(self.sweep.scenarios), __version__, model_fingerprint()])

    @property
    def truth(self) -> Mapping[str, tuple[type, str]]:
        """Type and meaning of the columns that the labels have beside those of every sweep."""
        return TRUTH

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
        position = 0
        cases_of_groups = self._cases()
        for point in self._points():
            condition = self._condition(point)
            for seed in self._seeds(condition):
                group = []
                for case, values in next(cases_of_groups):
                    run = self._run(position, condition, seed, point, case, values)
                    brief = bytes.fromhex(run.name)
                    if brief not in known:
                        known.add(brief)
                        group.append(run)
                        position += 1
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
        file = self.sweep.file
        return points(file.design, self.sweep.vary, file.points, file.seed)

    def _cases(self) -> Iterator[list[tuple[str, Point]]]:
        """Yield the cases of each condition and seed: all values of a grid, or one random point per case."""
        file, cases = self.sweep.file, self.sweep.cases
        if file.design == GRID:
            yield from itertools.repeat([(name, values) for name, axes in cases.items() for values in points(GRID, axes, 0, file.seed)])
        count = file.points * self.sweep.seeds
        drawn = [points(file.design, axes, count, int(digest([file.seed, name])[:8], 16)) for name, axes in cases.items()]
        for values in zip(*drawn, strict=True):
            yield list(zip(cases, values, strict=True))

    def _difference(self, changes: Point) -> Point:
        """Return the parameters that differ from the base; equal bearings have equal differences."""
        return {key: value for key, value in changes.items() if self.sweep.base.get(key) != value}

    def _condition(self, point: Point) -> str:
        """Return the hash of the differences from the defaults, so that a parameter added later does not change splits and seeds."""
        values = {**self.sweep.base, **point}
        return digest({key: value for key, value in values.items() if not _not_a_condition(key) and value != self._defaults.get(key)})

    def _identities(self, point: Point) -> dict[str, str]:
        """Return the hashes of bearing and machine; without a seed of the surfaces, all seeds of a condition count as one bearing."""
        return {name: digest(values) for name, values in identities(point, self._defaults, self._own).items()}

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
            self._identities(point),
        )


def _not_a_condition(key: str) -> bool:
    """Return whether a parameter is independent of the bearing, its speed and its load."""
    return key.split(".")[0] in NOT_CONDITIONS or key in (SEED, SCENARIO)


def _check_groups(groups: int, conditions: int, shares: Shares) -> None:
    """Refuse ``split.apart`` where the conditions share too few bearings or machines to fill the splits."""
    filled = sum(share > 0.0 for share in (shares.train, shares.validation, shares.test))
    if shares.apart and groups < min(filled, conditions):
        raise Refusal(
            f"split.apart = {', '.join(shares.apart)}: the {conditions} conditions make {groups} group(s) that share none of these, fewer "
            f"than the {filled} splits: vary surfaces.seed for other bearings and structure.seed for other machines, or take more points"
        )


def splits(conditions: set[str], shares: Shares) -> dict[str, str]:
    """Return the split of each condition: the sorted hashes are divided in proportion to the shares.

    Sorting makes the result independent of the iteration order of the set. Every split with a share above zero gets at least
    one condition if there are enough; if not, validation is left empty first.
    """
    order, given = sorted(conditions), {"train": shares.train, "validation": shares.validation, "test": shares.test}
    named = [(name, share) for name, share in given.items() if share > 0.0]
    if len(order) < len(named):
        named = [(name, share) for name, share in named if name != "validation"]
    counts = [max(round(share * len(order)), 1) for _, share in named]
    while sum(counts[1:]) >= len(order) and max(counts[1:]) > 1:
        counts[counts.index(max(counts[1:]), 1)] -= 1
    # The training split absorbs the rounding error.
    counts[0] = max(len(order) - sum(counts[1:]), 1)
    names = itertools.chain.from_iterable([name] * count for (name, _), count in zip(named, counts, strict=True))
    return dict(zip(order, names, strict=False))
