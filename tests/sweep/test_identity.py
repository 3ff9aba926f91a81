"""No bearing and no machine is in two splits, whatever the conditions share."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from dcrb_ros.cli.app import app
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.division import Unit, divided, grouped
from dcrb_ros.sweep.kinds import plan_of as plan_of_lives
from dcrb_ros.sweep.loader import read_sweep, sweep_of
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.sweep_file import Shares

BOTH = ["bearing_id", "machine"]
SHARED = {
    "surfaces.seed": list(range(1, 31)),
    "structure.seed": list(range(1, 31)),
    "operating.speed": {"low": 90.0, "high": 160.0},
}
CASES = {"healthy": {}, "outer": {"faults.outer_1.width": 0.002}}
TREE = {"base": "healthy", "set": {"structure.modes": 4}, "duration": 0.1, "design": "random", "points": 12, "cases": CASES}


def plan_of(seed: int, vary: dict[str, Any], apart: list[str] | None) -> Plan:
    return Plan(sweep_of({**TREE, "seed": seed, "vary": vary, "split": {} if apart is None else {"apart": apart}}, "sweep.yaml"))


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


def test_a_bearing_that_is_mounted_again_is_on_the_same_machine() -> None:
    vary = {"operating.speed": SHARED["operating.speed"], "structure.mounting": {"low": 1, "high": 2_000_000_000}}
    tree = {"base": "healthy", "duration": 0.1, "design": "random", "points": 12, "cases": CASES, "vary": vary}
    assert len({run.truth["machine"] for run in Plan(sweep_of(tree, "sweep.yaml")).runs()}) == 1
    with pytest.raises(Refusal, match="machine"):
        Plan(sweep_of({**tree, "split": {"apart": ["machine"]}}, "sweep.yaml"))


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
    units = [Unit(f"{bearing}/{machine}", str(bearing), str(machine)) for bearing, machine in pairs]
    shuffled = list(units)
    random.shuffle(shuffled)
    assert grouped([units], BOTH) == grouped([shuffled], BOTH)


OTHERS = {"surfaces.seed": {"low": 1, "high": 2_000_000_000}, "structure.seed": {"low": 1, "high": 2_000_000_000}}


@pytest.mark.parametrize("name", ["two_hundred", "twin"])
def test_the_shipped_sweeps_have_other_bearings_and_machines_in_each_split(name: str) -> None:
    plan = plan_of_lives(read_sweep(name))
    runs = list(plan.runs())
    for identity in BOTH:
        assert len({run.truth[identity] for run in runs}) == 40
        assert all(len({run.split for run in runs if run.truth[identity] == value}) == 1 for value in {run.truth[identity] for run in runs})
    for fault in ("outer", "inner"):
        assert len({run.changes[f"faults.{fault}_1.seed"] for run in runs if run.case == fault}) == 40
    assert plan.shared == {}
    assert "* Every bearing is in one split (`bearing_id`).\n* Every machine is in one split" in plan.split_text


@pytest.mark.parametrize("name", ["ten_lives", "twenty_lives"])
def test_the_lives_of_a_shipped_sweep_are_individuals_in_one_split(name: str) -> None:
    plan = plan_of_lives(read_sweep(name))
    bearings = {run.truth["bearing_id"]: (run.changes["surfaces.seed"], run.split) for run in plan.runs()}
    assert all(bearings[run.truth["bearing_id"]] == (run.changes["surfaces.seed"], run.split) for run in plan.runs())
    assert len({seed for seed, _ in bearings.values()}) == len(bearings)
    assert "All bearings are on one machine" in plan.split_text


def test_bearings_and_machines_are_kept_apart_by_default() -> None:
    plan = plan_of(1, SHARED, None)
    assert plan.shared == {}
    assert all(len(splits) == 1 for name in BOTH for splits in splits_by(plan, name))


@pytest.mark.parametrize(
    ("vary", "shared"),
    [({"operating.speed": SHARED["operating.speed"]}, BOTH), ({**OTHERS, "structure.seed": [7]}, ["machine"]), (OTHERS, [])],
)
def test_a_bearing_in_two_splits_warns(vary: dict[str, Any], shared: list[str], tmp_path: Path) -> None:
    plan = plan_of(1, vary, None)
    assert plan.shared == dict.fromkeys(shared, 1)
    file = tmp_path / "sweep.yaml"
    file.write_text(yaml.safe_dump({**TREE, "vary": vary}), encoding="utf-8")
    done = CliRunner().invoke(app, ["sweep", str(file), "-o", "memory://set"])
    warned = [line for line in done.stderr.splitlines() if line.startswith("warning: ")]
    assert len(warned) == len(shared)
    for name, line in zip(shared, warned, strict=True):
        assert f"is in more than one split ({name})" in line
        assert f"1 {name.removesuffix('_id')} is in more than one split ({name})" in plan.split_text


def test_a_seed_without_an_effect_makes_no_other_bearing_or_machine() -> None:
    tree = {**TREE, "set": {}, "base": "dry", "vary": OTHERS}
    assert Plan(sweep_of(tree, "sweep.yaml")).shared == {"bearing_id": 1, "machine": 1}
    noise = {**TREE, "set": {"surfaces.seed": 0}, "vary": {"operating.speed": {"low": 90.0, "high": 160.0}}}
    assert Plan(sweep_of(noise, "sweep.yaml")).shared == {"machine": 1}
    assert Plan(sweep_of({**noise, "seeds": [1, 2]}, "sweep.yaml")).shared == {"bearing_id": 1, "machine": 1}


def test_three_sensors_in_all_splits_do_not_change_the_shares() -> None:
    plan = plan_of(1, {**OTHERS, "sensor.noise_density": [0.001, 0.002, 0.004]}, None)
    train = Counter(run.split for run in plan.runs())["train"]
    assert abs(train / 24 - 0.6) < 0.15
    assert all(len(splits) == 1 for splits in splits_by(plan, "bearing_id"))


def units(first: int, last: int, bearings: int) -> list[Unit]:
    """Conditions with a few bearings, each on a machine of its own."""
    return [Unit(f"{number:03x}", f"bearing {number % bearings}", f"machine {number}") for number in range(first, last)]


@pytest.mark.parametrize("apart", [None, BOTH])
@pytest.mark.parametrize("bearings", [20, 12, 3])
def test_added_conditions_are_in_the_split_of_their_bearing(apart: Any, bearings: int) -> None:
    shares = Shares(apart=apart)
    before = divided([units(0, 20, bearings)], shares)
    after = divided([units(0, 20, bearings), units(20, 50, bearings)], shares)
    assert all(after.splits[condition] == split for condition, split in before.splits.items())
    assert before.shared == after.shared == {}
    added = divided([units(0, 20, 50), units(20, 50, 50)], shares)
    assert Counter(list(added.splits.values())[20:]) == {"train": 18, "validation": 6, "test": 6}


def test_an_added_condition_that_joins_two_splits_is_refused_or_named() -> None:
    first = units(0, 20, 20)
    splits_of = divided([first], Shares()).splits
    train, test = (next(unit for unit in first if splits_of[unit.condition] == split) for split in ("train", "test"))
    joined = [Unit("fff", train.bearing_id, test.machine)]
    with pytest.raises(Refusal, match=r"the added conditions share a (bearing|machine) with two splits: give a new folder"):
        divided([first, joined], Shares(apart=BOTH))  # type: ignore[arg-type]
    assert len(divided([first, joined], Shares()).shared) == 1


def test_every_seed_of_a_housing_is_another_machine() -> None:
    tree = {"base": "healthy", "duration": 0.1, "cases": CASES, "vary": {"structure.seed": [1, 2, 3]}}
    machines = [
        {run.truth["machine"] for run in Plan(sweep_of({**tree, "set": {"structure.housing": housing}}, "sweep.yaml")).runs()}
        for housing in ("none", "axle_box")
    ]
    assert [len(found) for found in machines] == [1, 3]


def test_a_value_of_the_base_counts_beside_another_preset() -> None:
    """The preset replaces the base's values of the sensor, and the case gives one of them back."""
    preset, base_range = {"sensor.preset": "mems"}, {"sensor.range": 5000.0}
    tree = {"base": "dry", "duration": 0.1, "settle": 0.01, "branch_at": 0.01}
    cases = {"preset": preset, "range": {**preset, **base_range}, "base": base_range}
    runs = list(Plan(sweep_of({**tree, "branch_at": 0.0, "cases": cases}, "sweep.yaml")).runs())
    assert [run.case for run in runs] == ["preset", "range", "base"]
    varied = {key: [value] for key, value in {**preset, **base_range}.items()}
    (run,) = Plan(sweep_of({**tree, "vary": varied}, "sweep.yaml")).runs()
    assert {**preset, **base_range}.items() <= run.healthy.items()
