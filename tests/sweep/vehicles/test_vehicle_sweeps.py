"""Sweeps over vehicles: every box is a run with its own label, and a vehicle is in one split."""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from data_sets import made
from hypothesis import given, settings
from hypothesis import strategies as st

import dcrb_ros
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.card import card
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.estimate import estimate
from dcrb_ros.sweep.kinds import plan_of
from dcrb_ros.sweep.loader import read_sweep, sweep_of
from dcrb_ros.sweep.store import Store
from dcrb_ros.sweep.table import Tally
from dcrb_ros.sweep.vehicles.ride import ride
from dcrb_ros.vehicle.file import read_parameters, vehicle_of
from dcrb_ros.vehicle.simulation import VehicleSimulation

BOXES = ("axle_1.left", "axle_1.right", "axle_2.left", "axle_2.right")
TREE: dict[str, Any] = {
    "vehicle": "healthy_bogie",
    "set": {"vehicle.bench": "dry"},
    "design": "random",
    "points": 3,
    "vary": {"vehicle.seed": {"low": 1, "high": 2000}, "vehicle.speed_kmh": [80.0, 160.0]},
    "cases": {"healthy": {}, "outer": {"box": [*BOXES], "box.faults.outer_1.width": {"low": 0.001, "high": 0.003}}},
    "duration": 0.05,
    "settle": 0.01,
}


def tree(**changes: Any) -> dict[str, Any]:
    return {key: value for key, value in {**TREE, **changes}.items() if value is not None}


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 1000))
def test_a_vehicle_is_in_one_split_on_all_its_rides(seed: int) -> None:
    rides = {"vehicle.seed": [1, 2, 3, 4], "vehicle.speed_kmh": {"low": 80.0, "high": 160.0}}
    runs = list(plan_of(sweep_of(tree(points=40, seed=seed, vary=rides), "sweep.yaml")).runs())
    splits: dict[str, set[str]] = {}
    for run in runs:
        splits.setdefault(str(run.truth["machine"]), set()).add(run.split)
    assert 3 <= len(splits) <= 4
    assert all(len(names) == 1 for names in splits.values())
    assert {run.split for run in runs} == {"train", "validation", "test"}


@pytest.mark.parametrize(
    ("seeds", "case", "shared"),
    [
        ({}, {}, {"track.seed": 1, "paths.seed": 1}),
        ({"track.seed": {"low": 1, "high": 2000}, "paths.seed": {"low": 1, "high": 2000}}, {}, {}),
        ({"track.seed": [4, 5], "paths.seed": {"low": 1, "high": 2000}}, {}, {"track.seed": 2}),
        ({"track.seed": {"low": 1, "high": 2000}}, {"paths.seed": {"low": 1, "high": 2000}}, {}),
        ({"paths.seed": {"low": 1, "high": 2000}}, {"track.seed": [4]}, {"track.seed": 1}),
    ],
)
def test_rails_wheels_and_cross_talk_in_two_splits_warn(seeds: dict[str, Any], case: dict[str, Any], shared: dict[str, int]) -> None:
    plan = plan_of(sweep_of(tree(points=20, vary={**TREE["vary"], **seeds}, cases={"base": case}), "sweep.yaml"))
    assert plan.shared == shared
    warned = [line for line in plan.split_text.splitlines() if line.startswith("* ")]
    assert all(f"in more than one split ({name}), so that" in line for name, line in zip(shared, warned, strict=True))


def test_runs_have_names_of_their_own_and_the_boxes_of_a_vehicle_one_task() -> None:
    plan = plan_of(sweep_of(tree(), "sweep.yaml"))
    groups = list(plan.groups())
    assert [[run.truth["box"] for run in group] for group in groups] == [[*BOXES]] * 6
    runs = [run for group in groups for run in group]
    assert len({run.name for run in runs}) == len(runs) == plan.sweep.count
    assert len({run.truth["bearing_id"] for run in runs}) == 3 * len(BOXES)
    assert len({run.twin for run in runs}) == len(runs) / 2  # healthy and damaged


@pytest.mark.slow
def test_the_samples_are_those_of_the_vehicle(tmp_path: Path) -> None:
    plan = plan_of(sweep_of(tree(), "sweep.yaml"))
    made(plan, tmp_path)
    labels = pd.read_parquet(tmp_path / "labels.parquet")
    assert set(labels["status"]) == {"done"}
    for split, row in labels.groupby("split"):
        assert f"| {split} | {row['machine'].nunique()} |" in (tmp_path / "README.md").read_text()
    damaged = labels[labels["case"] == "outer"]
    faulty = damaged[damaged["fault"] == "outer_ring"]
    assert len(faulty) == 3  # one box of each vehicle
    assert (faulty["damaged"] == faulty["box"] + " outer_ring").all()
    assert all(row[f"{row['box']}.faults.outer_1.width"] == row["width"] for _, row in faulty.iterrows())
    assert set(labels[labels["case"] == "healthy"]["fault"]) == {"healthy"}
    row = faulty.iloc[0]
    run = next(run for run in plan.runs() if run.name == row["run"])
    simulation = VehicleSimulation(vehicle_of(read_parameters("healthy_bogie", {"vehicle.bench": "dry", **run.changes}), "test"))
    blocks = [block.boxes[row["box"]] for block in simulation.blocks(0.06)]
    expected = np.concatenate([block.acceleration for block in blocks])[round(0.01 * row["sampling_rate"]) :]
    np.testing.assert_array_equal(dcrb_ros.DataSet(tmp_path).waveform(row["run"]).acceleration, expected)


def test_the_samples_before_the_recorded_time_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    megabyte = 1 << 20

    def blocks(duration: float) -> Iterator[SimpleNamespace]:
        for number in range(round(duration)):
            yield SimpleNamespace(boxes={"axle_1.left": SimpleNamespace(acceleration=bytes(megabyte), truths=(number,))})

    simulation = SimpleNamespace(simulations={"axle_1.left": SimpleNamespace(configuration=None)}, blocks=blocks, silent={})
    monkeypatch.setattr("dcrb_ros.sweep.vehicles.ride.VehicleSimulation", lambda vehicle, threads: simulation)
    tracemalloc.start()
    ridden = ride(read_parameters("healthy_bogie"), 32.0, 2.0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert ridden.before["axle_1.left"] == list(range(32))
    assert len(ridden.blocks["axle_1.left"]) == 2
    assert peak < 8 * megabyte


def test_the_type_of_a_value_is_that_of_its_parameter_however_it_is_written() -> None:
    cases = {
        "healthy": {"axle_1.left.wheel.flat": 0},
        "flat": {"box": ["axle_1.left", "axle_2.left"], "box.wheel.flat": [0, 0.035]},
        "bench": {"box": ["axle_2.right"], "box.bench": "outer_ring_defect"},
    }
    vary = {"vehicle.brake": {"low": 0, "high": 1}, "vehicle.seed": {"low": 1, "high": 2000}, "axle_1.slide": [0]}
    sweep = sweep_of(tree(vary=vary, cases=cases), "sweep.yaml")
    flats = {f"{box}.wheel.flat": float for box in ("axle_1.left", "axle_2.left")}
    benches = {"axle_2.right.bench": str}
    assert sweep.varied == {"vehicle.brake": float, "vehicle.seed": int, "axle_1.slide": float, **flats, **benches}
    runs = list(plan_of(sweep).runs())
    brakes = {run.changes["vehicle.brake"] for run in runs}
    assert len(brakes) == 3
    assert not brakes & {0.0, 1.0}
    assert {type(value) for run in runs for key, value in run.changes.items() if key.endswith(("flat", "slide"))} == {float}


@pytest.mark.slow
def test_the_boxes_of_another_vehicle_are_not_taken(tmp_path: Path) -> None:
    """The files of two vehicles with other seeds are swapped, with their labels and without."""
    plan = plan_of(sweep_of(tree(points=2, cases={"healthy": {}}, split={"train": 0.5, "validation": 0.0, "test": 0.5}), "sweep.yaml"))
    made(plan, tmp_path)
    first, second = ([run.name for run in group] for group in plan.groups())
    for folder, ending, sentence in (("runs", "npz", "has been changed"), ("labels", "json", "is the label of the run")):
        for mine, other in zip(first, second, strict=True):
            a, b, spare = (tmp_path / folder / f"{name}.{ending}" for name in (mine, other, "spare"))
            a.rename(spare)
            b.rename(a)
            spare.rename(b)
        with open_data_set(plan, Store(str(tmp_path))) as data_set:
            assert set(data_set.flaws) == {*first, *second}
            assert all(sentence in reason for reason in data_set.flaws.values())
        made(plan, tmp_path)
    with open_data_set(plan, Store(str(tmp_path))) as data_set:
        assert data_set.flaws == {}


@pytest.mark.parametrize("where", [{"set": {"vehicle.bench": "mine.yaml"}}, {"cases": {"a": {"box": [*BOXES], "box.bench": "mine.yaml"}}}])
def test_a_bench_that_was_changed_makes_another_data_set(where: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    bench, store = tmp_path / "mine.yaml", Store(str(tmp_path / "set"))
    bench.write_text("cage: {joint: revolute}")
    with open_data_set(plan_of(sweep_of(tree(**where), "sweep.yaml")), store):
        pass
    with open_data_set(plan_of(sweep_of(tree(**where), "sweep.yaml")), store):
        pass
    bench.write_text("faults: {outer_1: {width: 0.003}}")
    with (
        pytest.raises(Refusal, match=r"was made with another sweep \(benches differs\)"),
        open_data_set(plan_of(sweep_of(tree(**where), "sweep.yaml")), store),
    ):
        pass


@pytest.mark.slow
def test_shipped_vehicles_and_their_cost() -> None:
    plan = plan_of(read_sweep("twelve_vehicles"))
    runs = list(plan.runs())
    assert len(runs) == 12 * 6 * 4
    assert len({run.truth["machine"] for run in runs}) == 12
    assert plan.shared == {}
    cost = estimate(plan_of(sweep_of(tree(points=3, cases={"healthy": {}}), "sweep.yaml")))
    assert (cost.runs, cost.refused) == (12, 0)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"vehicle": "bogy"}, "bogy"),
        ({"vehicle": 3}, "vehicle = 3 is not the name of a vehicle"),
        ({"base": "healthy"}, "has no 'base': the vehicle is the base"),
        ({"seeds": 2}, "has no 'seeds': its noise follows from vehicle.seed"),
        ({"twins": True}, "has no 'twins'"),
        ({"output": "bag"}, "output = bag is for single bearings"),
        ({"split": {"apart": ["machine"]}}, "split.apart is for single bearings"),
        ({"duration": 200.0}, "makes 800 s of all boxes"),
        ({"vary": {"vehicle.sed": [1, 2, 3]}}, "unknown"),
        ({"vary": {"vehicle.speed_kmh": [80.0, 1000.0]}}, "vary"),
        ({"vary": {"vehicle.speed_kmh": {"low": 80.0}}}, "a range needs low and high"),
        ({"vary": {"track.spectrum": {}}}, "a range needs low and high"),
        ({"vary": {"vehicle.speed_kmh": {"a": {"b": 1}}}}, "vehicle.speed_kmh.a.b is below speed_kmh, which has the value"),
        ({"set": {"vehicle.bench": "dry", "vehicle.seed": 5}}, "vehicle.seed = 5 under 'set' would have no effect"),
        ({"vary": {"vehicle.seed": [1, "two"]}}, "vehicle.seed = 'two' is not a whole number within 0 .. 2147483647"),
        ({"vary": {"axle_1.sed": [1, "two"]}}, "axle_1.sed = 'two'"),
        ({"vary": {"axle_1.sed": [None]}}, "axle_1.sed = None"),
        ({"vary": {"axle_1.gear.teeth": [80.5]}}, "axle_1.gear.teeth = 80.5"),
        ({"set": {"axle_1.left.sensor.swapped_with": "axle_2.left"}}, "gives the box the waveform of another one"),
        (
            {"cases": {"swap": {"box": ["axle_1.left"], "box.sensor.swapped_with": "axle_2.left"}}},
            "cases.swap: axle_1.left.sensor.swapped_with = 'axle_2.left' gives the box the waveform of another one, which its label",
        ),
        ({"set": {"axle_1.left": {"surfaces": {"seed": 5}}}}, "set: axle_1.left.surfaces.seed is drawn by vehicle.seed"),
        ({"vary": {"axle_2.right.structure.seed": [1, 2]}}, "vary: axle_2.right.structure.seed is drawn by vehicle.seed"),
        (
            {"cases": {"a": {"box": [*BOXES], "box.simulation.seed": 3}}},
            "cases.a: box.simulation.seed is drawn by vehicle.seed",
        ),
        ({"vary": {"box": [*BOXES]}}, "'box' is for cases"),
        ({"cases": {"outer": {"box": ["axle_3.left"], "box.bench": "outer_ring_defect"}}}, "there is no box 'axle_3.left'"),
        ({"cases": {"outer": {"box.bench": "outer_ring_defect"}}}, "needs both the boxes and a parameter"),
        ({"cases": {"outer": {"box": [*BOXES]}}}, "needs both the boxes and a parameter"),
        ({"cases": {"outer": {"axle_1.left.bench": "outer_ring"}}}, "cases.outer"),
        ({"cases": {"other": {"vehicle.seed": 3}}}, "cases.other: another vehicle.seed is another vehicle"),
        (
            {"vary": {"axle_1.left.wheel.flat": [0.02, 0.03]}, "cases": {"flat": {"box": [*BOXES], "box.wheel.flat": 0.04}}},
            "cases.flat: axle_1.left.wheel.flat is under 'vary' too, which would have no effect in this case",
        ),
        ({"set": {"operating.speed": 90.0}}, "unknown group 'operating'"),
        ({"windows": {"length": 100000}}, "is longer than a run"),
        ({"lives": 3}, "unknown key 'lives'"),
        ({"set": {"publishing.loss_probability": 0.1}}, "sweep.yaml: set: publishing.loss_probability = 0.1 causes gaps"),
        ({"vary": {"publishing.loss_probability": [0.0, 0.1]}}, "sweep.yaml: vary: publishing.loss_probability = 0.1 causes gaps"),
        ({"cases": {"bursts": {"publishing.burst_period": 1.0, "publishing.burst_length": 0.2}}}, "cases.bursts: publishing.burst_period"),
    ],
)
def test_what_a_sweep_over_vehicles_refuses(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(Refusal, match=r"sweep\.yaml|bogy") as refusal:
        sweep_of(tree(**changes), "sweep.yaml")
    assert sentence in str(refusal.value)


def test_too_few_vehicles_for_the_splits_are_refused() -> None:
    one = tree(vary={"vehicle.speed_kmh": [80.0, 120.0, 160.0]}, design="grid", points=None, cases=None)
    with pytest.raises(Refusal, match=r"too few vehicles \(1\) for the split 'validation': vary vehicle.seed"):
        plan_of(sweep_of(one, "sweep.yaml"))
    together = {**one, "split": {"train": 1.0, "validation": 0.0, "test": 0.0}}
    assert {run.split for run in plan_of(sweep_of(together, "sweep.yaml")).runs()} == {"train"}


def test_other_paths_do_not_make_another_vehicle_of_the_same_bearings() -> None:
    paths = tree(vary={"paths.seed": [1, 2, 3, 4], "vehicle.speed_kmh": [80.0, 120.0]}, design="grid", points=None, cases=None)
    with pytest.raises(Refusal, match=r"too few vehicles \(1\)"):
        plan_of(sweep_of(paths, "sweep.yaml"))


LOUD = {f"paths.{kind}": ", ".join([level] * 5) for kind, level in (("same_wheelset", "-6"), ("same_side", "-9.5"), ("diagonal", "-10"))}


@pytest.mark.parametrize(
    ("where", "changes"),
    [
        ("vary", {"set": {**TREE["set"], **LOUD}}),
        ("vary", {"vary": {**TREE["vary"], "paths.same_wheelset": ["-30, -30, -30, -30, -30", LOUD["paths.same_wheelset"]]}}),
        ("cases.loud", {"cases": {"healthy": {}, "loud": LOUD}}),
    ],
)
def test_paths_that_carry_too_much_are_refused_before_the_first_run(where: str, changes: dict[str, Any]) -> None:
    with pytest.raises(
        Refusal, match=rf"^sweep.yaml: {where}: paths: .* of a bearing's energy reaches|{where}: paths: in the third octave"
    ):
        sweep_of(tree(**changes), "sweep.yaml")


def test_paths_that_are_drawn_from_a_range_are_refused_with_their_runs() -> None:
    ranged = {**TREE["vary"], "paths.seed": {"low": 0, "high": 3}}
    assert sweep_of(tree(set={**TREE["set"], **LOUD}, vary=ranged), "sweep.yaml").count == 3 * 2 * len(BOXES)


def test_the_data_card_has_the_units_of_the_parameters_of_a_vehicle() -> None:
    cases = {"outer": {"box": ["axle_1.left"], "box.faults.outer_1.width": [0.001]}, "flat": {"axle_1.left.wheel.flat": [0.03]}}
    found = card(plan_of(sweep_of(tree(cases=cases), "sweep.yaml")), Tally())
    assert "* `vehicle.speed_kmh` [km/h]: 80.0, 160.0\n" in found
    assert "* case `outer`: `box`: `axle_1.left`; `box.faults.outer_1.width` [m]: 0.001\n" in found
    assert "* case `flat`: `axle_1.left.wheel.flat` [m]: 0.03\n" in found
