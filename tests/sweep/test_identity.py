"""No bearing and no machine is in two splits, whatever the conditions share."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.identity import Groups
from dcrb_ros.sweep.loader import sweep_of
from dcrb_ros.sweep.plan import Plan

BOTH = ["bearing_id", "machine"]
SHARED = {
    "surfaces.seed": list(range(1, 31)),
    "structure.seed": list(range(1, 31)),
    "operating.speed": {"low": 90.0, "high": 160.0},
}
CASES = {"healthy": {}, "outer": {"faults.outer_1.width": 0.002}}
TREE = {"base": "healthy", "duration": 0.1, "design": "random", "points": 12, "cases": CASES}


def plan_of(seed: int, vary: dict[str, Any], apart: list[str]) -> Plan:
    return Plan(sweep_of({**TREE, "seed": seed, "vary": vary, "split": {"apart": apart}}, "sweep.yaml"))


def splits_by(plan: Plan, name: str) -> list[set[str]]:
    found: dict[str, set[str]] = {}
    for run in plan.runs():
        found.setdefault(run.truth.get(name, run.condition), set()).add(run.split)
    return list(found.values())


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 1000))
def test_nothing_leaks_between_splits(seed: int) -> None:
    plan = plan_of(seed, SHARED, BOTH)
    for name in ("condition", "bearing_id", "machine"):
        assert all(len(splits) == 1 for splits in splits_by(plan, name))
    assert len({run.split for run in plan.runs()}) > 1


def test_without_it_bearings_and_machines_do_leak() -> None:
    plan = plan_of(3, {**SHARED, "surfaces.seed": [1, 2], "structure.seed": [1, 2]}, [])
    assert any(len(splits) > 1 for name in BOTH for splits in splits_by(plan, name))


def test_bearing_and_machine_follow_from_their_own_parameters() -> None:
    grid = {"surfaces.seed": [1, 2], "structure.seed": [1, 2, 3], "operating.load": [5e4, 1e5]}
    tree = {key: value for key, value in TREE.items() if key not in ("design", "points")}
    runs = list(Plan(sweep_of({**tree, "vary": grid}, "sweep.yaml")).runs())
    assert len({run.truth["bearing_id"] for run in runs}) == 2
    assert len({run.truth["machine"] for run in runs}) == 3
    assert len({run.condition for run in runs}) == 4


def test_conditions_that_all_share_a_machine_are_refused() -> None:
    with pytest.raises(Refusal, match=r"12 conditions make 1 group"):
        plan_of(1, {"operating.speed": {"low": 90.0, "high": 160.0}}, ["machine"])


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=1, max_size=20), st.randoms())
def test_groups_do_not_depend_on_the_order(pairs: list[tuple[int, int]], random: Any) -> None:
    def grouped(order: list[tuple[int, int]]) -> dict[str, str]:
        groups = Groups()
        for bearing, machine in order:
            groups.add(f"{bearing}/{machine}", {"bearing_id": str(bearing), "machine": str(machine)})
        return {f"{bearing}/{machine}": groups.group(f"{bearing}/{machine}") for bearing, machine in order}

    shuffled = list(pairs)
    random.shuffle(shuffled)
    assert grouped(pairs) == grouped(shuffled)
