"""Sweeps: experimental designs, plans without leakage between splits, runs on Dask, and invalid input."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import data_sets
import numpy as np
import pytest
from folder_contents import contents

pytest.importorskip("distributed")

import pandas as pd
from distributed import Client
from hypothesis import example, given
from hypothesis import strategies as st

from dcrb_ros import DataSet
from dcrb_ros.cli.app import app
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.reproduction import Reproduction
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, load_configuration
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.run import waveform_of
from dcrb_ros.sweep import execution
from dcrb_ros.sweep.cluster import TASKS_PER_WORKER, ClusterWorkers, cluster_workers
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.design import GRID, LATIN_HYPERCUBE, RANDOM, Choice, Span, points, size
from dcrb_ros.sweep.division import splits
from dcrb_ros.sweep.estimate import estimate
from dcrb_ros.sweep.execution import CommonSettings, common_settings, run_task
from dcrb_ros.sweep.loader import read_sweep, sweep_of
from dcrb_ros.sweep.plan import Plan, PlannedRun
from dcrb_ros.sweep.store import Store, StoreFailed
from dcrb_ros.sweep.sweep_file import Shares, Windows
from dcrb_ros.sweep.verification import read_label
from dcrb_ros.sweep.windows import cut_windows, window_starts

pytestmark = pytest.mark.slow

QUICK = {"base": "dry", "set": {"cage.joint": "revolute"}, "duration": 0.02}
CASES = {"healthy": {}, "outer": {"faults.outer_1.width": {"low": 0.001, "high": 0.003}}}
VARIED = {
    **QUICK,
    "design": "latin_hypercube",
    "points": 5,
    "vary": {"operating.speed": {"low": 90.0, "high": 160.0}, "operating.load": {"low": 4e4, "high": 1.2e5, "scale": "log"}},
    "cases": CASES,
    "seeds": 2,
}
EXAMPLES = Path(__file__).parents[2] / "examples"


def plan_of(tree: dict[str, Any]) -> Plan:
    return Plan(sweep_of(tree, "sweep.yaml"))


def made(tree: dict[str, Any], folder: Path, client: Client) -> pd.DataFrame:
    with open_data_set(plan_of(tree), Store(str(folder))) as data_set:
        data_set.make(ClusterWorkers(client), lambda _: None)
    return pd.read_parquet(folder / "labels.parquet")


def run_alone(tree: dict[str, Any], folder: Path) -> list[tuple[PlannedRun, dict[str, Any]]]:
    """Run a plan in this process and return its runs with their labels."""
    plan = plan_of(tree)
    data_sets.made(plan, folder)
    return [(run, json.loads((folder / "labels" / f"{run.name}.json").read_text())) for run in plan.runs()]


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    """Two workers in this process, which start quickly and share memory://."""
    with Client(processes=False, n_workers=2, threads_per_worker=1, dashboard_address=None) as here:
        yield here


# Designs


def test_a_grid_has_every_combination_and_both_ends() -> None:
    axes = {"a": Span(1.0, 100.0, log=True, count=3), "b": Choice(("x", "y")), "c": Span(1, 16, whole=True, count=2)}
    found = list(points(GRID, axes, 0, 1))
    assert len(found) == size(GRID, axes, 0) == 12
    assert sorted({float(point["a"]) for point in found}) == pytest.approx([1.0, 10.0, 100.0])
    assert {point["c"] for point in found} == {1, 16}


def test_a_latin_hypercube_has_one_point_in_every_stratum() -> None:
    found = list(points(LATIN_HYPERCUBE, {"a": Span(0.0, 10.0), "b": Span(1.0, 1e10, log=True)}, 10, 3))
    assert sorted(int(float(point["a"])) for point in found) == list(range(10))
    assert sorted(int(np.log10(float(point["b"]))) for point in found) == list(range(10))


@given(st.integers(0, 2**31 - 1), st.sampled_from([RANDOM, LATIN_HYPERCUBE]))
def test_points_lie_within_their_ranges_and_are_reproducible(seed: int, design: str) -> None:
    axes = {"a": Span(2e4, 1e5, log=True), "b": Span(1, 4, whole=True), "c": Choice((True, False))}
    found = list(points(design, axes, 4, seed))
    assert found == list(points(design, axes, 4, seed))
    assert all(2e4 <= float(point["a"]) <= 1e5 and point["b"] in (1, 2, 3, 4) and type(point["b"]) is int for point in found)


# Plans


def test_no_condition_and_no_twins_are_in_two_splits() -> None:
    runs = list(plan_of({**VARIED, "points": 20, "twins": True}).runs())
    assert len(runs) == 80
    assert len({run.name for run in runs}) == 80
    for of in (lambda run: run.condition, lambda run: run.twin):
        where: dict[str, set[str]] = {}
        for run in runs:
            where.setdefault(of(run), set()).add(run.split)
        assert {len(found) for found in where.values()} == {1}
    assert Counter(run.split for run in runs) == {"train": 48, "validation": 16, "test": 16}
    by_twin = Counter((run.twin, run.case) for run in runs)
    assert set(by_twin.values()) == {1}
    assert len({run.seed for run in runs}) == 40


def test_sensors_and_faults_do_not_define_conditions() -> None:
    vary = {"sensor.noise_density": [0.001, 0.004], "operating.speed": [100.0, 120.0, 140.0]}
    runs = list(plan_of({**QUICK, "vary": vary, "cases": {**CASES, "outer": {"faults.outer_1.width": [0.001, 0.002]}}}).runs())
    assert len(runs) == 18
    assert len({run.condition for run in runs}) == 3


def test_a_parameter_at_its_default_does_not_change_splits_and_seeds() -> None:
    sweep = sweep_of({**VARIED, "points": 8}, "sweep.yaml")
    at_default = {key: value for key, value in sweep.base.items() if value == flatten(Configuration().model_dump())[key]}
    assert at_default
    earlier = replace(sweep, base={key: value for key, value in sweep.base.items() if key not in at_default})
    for run, before in zip(Plan(sweep).runs(), Plan(earlier).runs(), strict=True):
        assert (run.condition, run.split, run.seed) == (before.condition, before.split, before.seed)
    other = replace(sweep, base={**sweep.base, "bearing.rows": 1})
    assert not {run.condition for run in Plan(sweep).runs()} & {run.condition for run in Plan(other).runs()}


@given(st.integers(1, 40), st.floats(0.01, 0.8), st.floats(0.01, 0.99))
@example(3, 0.1, 0.5 / 0.9)
def test_every_split_has_its_share(count: int, train: float, validation: float) -> None:
    conditions = {f"{number:x}" for number in range(count)}
    shares = Shares(train=train, validation=(1.0 - train) * validation, test=(1.0 - train) * (1.0 - validation))
    found = splits(conditions, shares)
    assert set(found) == conditions
    assert found == splits(conditions, shares)
    if len(conditions) >= 3:
        assert set(found.values()) == {"train", "validation", "test"}


def test_no_conditions_have_no_splits() -> None:
    assert splits(set(), Shares(train=1.0, validation=0.0, test=0.0)) == {}


def test_splits_do_not_depend_on_the_iteration_order_of_a_set() -> None:
    conditions = {f"{number:02x}" for number in range(20)}
    found = splits(conditions, Shares(train=0.6, validation=0.2, test=0.2))
    assert [found[condition] for condition in sorted(conditions)] == ["train"] * 12 + ["validation"] * 4 + ["test"] * 4


def test_equal_runs_are_planned_once() -> None:
    runs = list(plan_of({**QUICK, "vary": {"operating.speed": [100.0, 100.0]}, "cases": {"a": {}, "b": {}}}).runs())
    assert [run.case for run in runs] == ["a"]


def test_the_first_task_of_a_long_plan_is_available_within_seconds() -> None:
    begin = time.perf_counter()
    plan = plan_of({**VARIED, "points": 10_000})
    first = next(plan.tasks(set(), 1.0))
    assert time.perf_counter() - begin < 10.0
    assert plan.sweep.count == 40_000
    assert len(first) == 50


# Runs


def test_samples_equal_those_of_a_single_simulation(tmp_path: Path) -> None:
    (run, label), *_ = run_alone({**QUICK, "cases": {"outer": {"faults.outer_1.width": 0.002}}, "seeds": [7]}, tmp_path)
    parameters = {"cage": {"joint": "revolute"}, "faults": {"outer_1": {"width": 0.002}}, "simulation": {"seed": 7}}
    configuration = Configuration.model_validate(parameters)
    alone = waveform_of(list(Simulation(configuration, waveform_only=True).blocks(0.02)), configuration)
    held = np.load(tmp_path / label["file"])
    assert np.array_equal(held["ax"], alone.acceleration[:, 0])
    assert np.array_equal(held["ay"], alone.acceleration[:, 1])
    assert np.array_equal(held["shaft_angle"], alone.shaft_angle)
    assert (label["fault"], label["width"], label["onset"], label["samples"], label["seed"]) == ("outer_ring", 0.002, 0.0, 1024, 7)
    assert label["configuration"]["faults.outer_1.width"] == 0.002
    assert run.name == label["run"]


def test_a_branch_equals_a_run_with_a_parameter_change_at_that_time(tmp_path: Path) -> None:
    tree = {**QUICK, "twins": True, "cases": {"outer": {"faults.outer_1.width": 0.002}}, "seeds": [1], "settle": 0.01, "branch_at": 0.03}
    (_, healthy), (_, outer) = run_alone(tree, tmp_path)
    assert (healthy["fault"], outer["fault"]) == ("healthy", "outer_ring")
    assert 0.03 <= outer["onset"] < 0.032
    assert outer["first_index"] == round(0.04 * 51200)
    simulation = Simulation(Configuration.model_validate({"cage": {"joint": "revolute"}}))
    parts = [block.acceleration for block in simulation.blocks(0.03)]
    straight = Simulation(Configuration.model_validate({"cage": {"joint": "revolute"}}))
    whole = np.concatenate([block.acceleration for block in straight.blocks(0.06)])
    assert np.array_equal(np.load(tmp_path / healthy["file"])["ay"], whole[-1024:, 1])
    simulation.change({"faults.outer_1.width": 0.002})
    parts += [block.acceleration for block in simulation.blocks(0.03)]
    assert np.array_equal(np.load(tmp_path / outer["file"])["ay"], np.concatenate(parts)[-1024:, 1])


def test_a_fork_is_independent_of_its_origin() -> None:
    simulation = Simulation(Configuration())
    list(simulation.blocks(0.01))
    fork, other = simulation.fork(), simulation.fork()
    other.change({"faults.inner_1.width": 0.002})
    with pytest.raises(ValueError, match="1 commands wait"):
        other.fork()
    list(other.blocks(0.01))
    mine, its = (np.concatenate([block.acceleration for block in one.blocks(0.01)]) for one in (simulation, fork))
    assert np.array_equal(mine, its)


def test_a_bag_of_a_branch_can_be_reproduced(tmp_path: Path) -> None:
    tree = {**QUICK, "twins": True, "cases": {"outer": {"faults.outer_1.width": 0.002}}, "output": "bag", "settle": 0.01, "branch_at": 0.02}
    _, (_, label) = run_alone(tree, tmp_path)
    recording = Recording(tmp_path / label["file"])
    assert recording.complete
    assert recording.outcome is not None
    assert recording.outcome["sha256"] == label["sha256"]
    reproduction = Reproduction(recording)
    list(reproduction.blocks(Simulation(reproduction.configuration)))
    reproduction.check()


def test_a_scenario_labels_its_windows(tmp_path: Path) -> None:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text("timeline: [{at: 0.02, set: {faults.outer_1.width: 0.002}}]", encoding="utf-8")
    windows = {"length": 512, "overlap": 0.5, "kind": "parquet"}
    tree = {**QUICK, "duration": 0.04, "windows": windows, "cases": {"grows": {"scenario": str(scenario)}}}
    ((run, label),) = run_alone(tree, tmp_path / "set")
    assert (label["fault"], label["onset"], label["windows"]) == ("outer_ring", 0.02, 7)
    table = pd.read_parquet(tmp_path / "set" / "windows" / run.split / f"{run.name}.parquet")
    assert list(table["fault"]) == ["healthy"] * 4 + ["outer_ring"] * 3
    assert list(table["mixed"]) == [False, False, False, True, False, False, False]
    assert pd.read_parquet(tmp_path / "set" / "windows")["start"].equals(table["start"])
    held = np.load(tmp_path / "set" / label["file"])
    assert np.array_equal(table["ay"][2], held["ay"][512:1024])
    assert list(table["start"]) == [256 * k for k in range(7)]


def test_windows_within_a_gradual_change_are_mixed(tmp_path: Path) -> None:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text("timeline: [{at: 0.0, over: 0.2, set: {faults.outer_1.width: 0.003}}]", encoding="utf-8")  # in steps of 0.05 s
    case = {"faults.outer_1.width": 0.001, "scenario": str(scenario)}
    tree = {**QUICK, "settle": 0.025, "duration": 0.25, "windows": {"length": 2560, "kind": "parquet"}, "cases": {"grows": case}}
    ((run, _),) = run_alone(tree, tmp_path / "set")
    table = pd.read_parquet(tmp_path / "set" / "windows" / run.split / f"{run.name}.parquet")
    assert list(table["mixed"]) == [True, True, True, True, False]


def test_a_scenario_sets_its_initial_speed(tmp_path: Path) -> None:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text("start: {operating.speed: 40.0}\ntimeline: [{at: 1.0, set: {operating.speed: 50.0}}]", encoding="utf-8")
    ((_, label),) = run_alone({**QUICK, "cases": {"slow": {"scenario": str(scenario)}}}, tmp_path / "set")
    assert label["speed"] == pytest.approx(40.0)


def test_a_speed_in_kmh_has_its_column(tmp_path: Path, client: Client) -> None:
    labels = made({**QUICK, "vary": {"operating.speed_kmh": [80.0, 160.0]}}, tmp_path, client)
    assert labels["operating.speed_kmh"].tolist() == [80.0, 160.0]
    assert labels["speed"].to_numpy() == pytest.approx(labels["operating.speed_kmh"].to_numpy() / 3.6 / 0.46)


def test_a_label_contains_the_sensor_parameters_of_its_preset(tmp_path: Path) -> None:
    tree = {**QUICK, "vary": {"sensor.preset": ["mems", "ideal"]}}
    labels = [label for _, label in run_alone(tree, tmp_path / "set")]
    found = {label["configuration"]["sensor.preset"]: label["configuration"]["sensor.white_noise_ug"] for label in labels}
    assert found == {"mems": 30.0, "ideal": 0.0}


def test_lost_blocks_are_not_counted_as_samples(tmp_path: Path) -> None:
    tree = {**QUICK, "duration": 0.1, "output": "bag", "set": {"publishing.loss_probability": 0.5, "publishing.block_size": 512}}
    ((_, label),) = run_alone(tree, tmp_path / "set")
    recording = Recording(tmp_path / "set" / label["file"])
    kept = sum(len(vibration.acceleration) for vibration in recording.vibrations())
    assert label["samples"] == kept < 0.1 * recording.sampling_rate


@given(st.integers(16, 300), st.floats(0.0, 0.99), st.integers(0, 2000))
def test_windows_lie_within_the_run(length: int, overlap: float, samples: int) -> None:
    windows = Windows(length=length, overlap=overlap)
    begin = window_starts(samples, windows)
    assert all(k >= 0 and k + length <= samples for k in begin)
    assert len(begin) == max(0, (samples - length) // windows.hop + 1)
    signal_ = np.arange(2 * samples, dtype=np.float32).reshape(-1, 2)
    found = cut_windows(signal_, windows)
    assert found.shape == (len(begin), 2, length)
    for k, window in zip(begin, found, strict=True):
        assert np.array_equal(window.T, signal_[k : k + length])


def test_a_preset_sets_the_sensor_parameters() -> None:
    made = sweep_of({"duration": 0.1, "set": {"sensor.preset": "mems"}, "vary": {"operating.speed": [100.0]}}, "test")
    assert made.base["sensor.range"] == load_configuration("dry", ["sensor.preset=mems"]).sensor.range


@pytest.mark.parametrize(
    "settings",
    [
        {"cage.joint": "pocket"},
        {"cage.joint": "revolute"},
        # Here the heights of pinned rollers decide a contact.
        {"cage.joint": "revolute", "operating.speed": 116.9678358728506, "simulation.seed": 584720293},
    ],
)
def test_waveform_only_has_the_same_samples_and_truths(settings: dict[str, Any]) -> None:
    configuration = load_configuration("healthy", settings)
    whole, lean = (list(Simulation(configuration, waveform_only=only).blocks(0.06)) for only in (False, True))
    assert [block.acceleration.tobytes() for block in whole] == [block.acceleration.tobytes() for block in lean]
    assert [block.truths for block in whole] == [block.truths for block in lean]
    assert all(len(block.states) > 0 for block in whole)
    assert all(len(block.states) == len(block.preview) == 0 for block in lean)


# Data sets


def test_a_second_call_simulates_the_missing_runs_only(tmp_path: Path, client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    tree = {**VARIED, "twins": True, "windows": {"length": 256}}
    table = made(tree, tmp_path / "set", client)
    assert list(table["status"]) == ["done"] * 20
    assert list(table["place"]) == list(range(20))
    assert set(table["split"]) == {"train", "validation", "test"}
    assert table["operating.speed"].between(90.0, 160.0).all()
    before = contents(tmp_path / "set")
    for name in table["run"][:7]:
        (tmp_path / "set" / "labels" / f"{name}.json").unlink()
    (tmp_path / "set" / "labels.parquet").unlink()
    (tmp_path / "set" / "runs" / ".part-cut-off").write_bytes(b"half")
    counted: list[str] = []
    real = execution._label
    monkeypatch.setattr(execution, "_label", lambda *of: counted.append(of[1].name) or real(*of))  # type: ignore[func-returns-value]
    again = made(tree, tmp_path / "set", client)
    assert sorted(counted) == sorted(table["run"][:7])
    assert again.equals(table)
    assert contents(tmp_path / "set") == before
    base = load_configuration(tmp_path / "set" / "base.yaml")
    assert flatten(base.model_dump()) == plan_of(tree).sweep.base
    card = (tmp_path / "set" / "README.md").read_text()
    for words in ("m/s^2", "51200 Hz", "CC-BY-4.0", "dcrb sweep sweep.yaml", "| train | 3 | 6 | 6 | 12 |"):
        assert words in card


def test_an_fsspec_address_can_be_used(client: Client) -> None:
    import fsspec

    store = Store("memory://sweep/set")
    with open_data_set(plan_of({**VARIED, "points": 2, "seeds": 1}), store) as data_set:
        tally = data_set.make(ClusterWorkers(client), lambda _: None)
    assert tally.statuses == {"done": 4}
    with fsspec.open("memory://sweep/set/labels.parquet") as stream:
        table = pd.read_parquet(stream)
    assert len(table) == 4
    with open_data_set(plan_of({**VARIED, "points": 2, "seeds": 1}), store) as data_set:
        assert data_set.done == set(table["run"])


def test_a_store_tells_local_from_remote_addresses(tmp_path: Path) -> None:
    assert Store(f"file://{tmp_path}").folder == tmp_path
    remote = Store("memory://remote")
    assert remote.folder is None
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "metadata.yaml").write_text("whole")
    remote.put(tmp_path / "bag", "runs/bag")
    assert remote.read("runs/bag/metadata.yaml") == b"whole"
    assert remote.read("runs/none") is None
    assert list(remote.names("nothing")) == []
    assert not (tmp_path / "bag").exists()


def test_failed_runs_are_labelled_and_do_not_stop_the_others(tmp_path: Path, client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(configuration: Configuration, *of: Any, **more: Any) -> Simulation:
        if configuration.operating.speed == 110.0:
            raise ModelFailure("the model failed at 0.001 s")
        if configuration.operating.speed == 120.0:
            raise ZeroDivisionError("a bug")
        return Simulation(configuration, *of, **more)

    monkeypatch.setattr(execution, "Simulation", failing)
    # Rollers of 40 mm do not fit between these raceways.
    tree = {**QUICK, "vary": {"operating.speed": [100.0, 110.0, 120.0], "bearing.roller_radius": [0.015, 0.04]}}
    table = made(tree, tmp_path / "set", client)
    assert Counter(table["status"]) == {"done": 1, "refused": 3, "failed": 1, "error": 1}
    reasons = dict(zip(table["status"], table["reason"], strict=True))
    assert "check the three radii" in reasons["refused"]
    assert reasons["failed"] == "the model failed at 0.001 s"
    assert reasons["error"] == "ZeroDivisionError: a bug"
    assert "3 refused" in (tmp_path / "set" / "README.md").read_text()
    monkeypatch.undo()
    again = made(tree, tmp_path / "set", client)
    assert Counter(again["status"]) == {"done": 2, "refused": 3, "failed": 1}
    assert not list((tmp_path / "set" / "errors").iterdir())


def test_a_sweep_stopped_by_a_full_disk_can_be_continued(tmp_path: Path, client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(path: Path, data: bytes) -> int:
        if path.parent.name == "runs":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(path, data)

    real = Path.write_bytes
    space = "No space left on device; free some space and run the same command again to continue"
    with open_data_set(plan_of(VARIED), Store(str(tmp_path / "set"))) as data_set:
        monkeypatch.setattr(Path, "write_bytes", full)
        with pytest.raises(StoreFailed, match=space):
            data_set.make(ClusterWorkers(client), lambda _: None)
    monkeypatch.undo()
    assert list(made(VARIED, tmp_path / "set", client)["status"]) == ["done"] * 20


def test_the_number_of_generated_tasks_is_bounded(tmp_path: Path, client: Client) -> None:
    plan, asked = plan_of({**VARIED, "points": 10, "seeds": 1}), []

    def counted() -> Iterator[tuple[PlannedRun, ...]]:
        for task in plan.tasks(set(), 0.0):
            asked.append(task)
            yield task

    common = common_settings(plan.sweep, Store(str(tmp_path)))
    for done, _ in enumerate(ClusterWorkers(client).dispatched(common, counted()), 1):
        assert len(asked) <= 2 * TASKS_PER_WORKER + done
    assert done == len(asked) == 10


def test_two_sweeps_of_equal_runs_share_no_task(tmp_path: Path, client: Client) -> None:
    plan, stores = plan_of(VARIED), [Store(str(tmp_path / name)) for name in ("first", "second")]
    both = [ClusterWorkers(client).dispatched(common_settings(plan.sweep, store), plan.tasks(set(), 0.0)) for store in stores]
    tasks = [next(both[0]), *both[1], *both[0]]
    assert [outcome for _, outcome in tasks if isinstance(outcome, Exception)] == []
    assert all(read_label(store, run.name) for store in stores for run in plan.runs())


# The command


def dcrb(*arguments: str) -> int:
    return exit_status("dcrb", lambda: app([*arguments], standalone_mode=False))


SMALL = """
set: {cage.joint: revolute}
design: latin_hypercube
points: 12
vary: {operating.speed: {low: 100.0, high: 150.0}}
cases:
  healthy: {}
  outer: {faults.outer_1.width: {low: 0.002, high: 0.003}}
duration: 0.25
"""


def test_a_killed_sweep_continues_to_the_same_data_set(
    tmp_path: Path, client: Client, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file, cut_off, whole = tmp_path / "small.yaml", tmp_path / "cut_off", tmp_path / "whole"
    file.write_text(SMALL, encoding="utf-8")
    command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", "sweep", str(file), "-o", str(cut_off), "--workers", "1"]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, start_new_session=True) as process:
        deadline = time.monotonic() + 600.0
        while not list(cut_off.glob("labels/*.json")) and time.monotonic() < deadline:
            assert process.poll() is None
            threading.Event().wait(0.02)
        os.killpg(process.pid, signal.SIGKILL)
    done = len(list(cut_off.glob("labels/*.json")))
    assert 0 < done < 24
    assert dcrb("sweep", str(file), "-o", str(cut_off), "--scheduler", client.scheduler.address) == 0
    assert "24 done; 16 train, 4 validation, 4 test" in capsys.readouterr().out
    with open_data_set(Plan(read_sweep(file)), Store(str(whole))) as data_set:
        data_set.make(ClusterWorkers(client), lambda _: None)
    assert contents(cut_off) == contents(whole)

    environment = {**os.environ, "PYTHONPATH": str(EXAMPLES.parent)}
    for name, words in (("load_dataset.py", "train: 80 windows"), ("baseline.py", "balanced accuracy on test")):
        run = [sys.executable, str(EXAMPLES / name), str(cut_off)]
        example = subprocess.run(run, env=environment, capture_output=True, text=True, timeout=400, check=False)
        assert words in example.stdout, example.stderr
    # Each condition in turn is the test, since one split of twelve conditions says little.
    import baseline
    from sklearn.ensemble import RandomForestClassifier

    table = pd.read_parquet(whole / "labels.parquet")
    with pytest.warns(UserWarning, match="in more than one split"):
        data_set = DataSet(whole)
    features = np.array([baseline.features(data_set, row) for _, row in table.iterrows()])
    right = []
    for condition in table["condition"].unique():
        test = table["condition"] == condition
        forest = RandomForestClassifier(100, random_state=1).fit(features[~test], table["fault"][~test])
        right += list(forest.predict(features[test]) == table["fault"][test])
    assert np.mean(right) > 0.9


def test_a_cluster_can_be_used(tmp_path: Path, client: Client, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "small.yaml").write_text("duration: 0.02", encoding="utf-8")
    address, arguments = client.scheduler.address, ["sweep", str(tmp_path / "small.yaml"), "-o", str(tmp_path / "set"), "--scheduler"]
    assert dcrb(*arguments, address) == 0
    printed = capsys.readouterr()
    assert "1 done; 1 train" in printed.out
    assert "too few conditions (1) for a validation or test split" in printed.err
    with Client(processes=False, n_workers=0, dashboard_address=None) as lonely:
        monkeypatch.setattr("dcrb_ros.sweep.cluster.PATIENCE", 1.0)
        assert dcrb(*arguments, lonely.scheduler.address) == 2
    assert "has no workers: start some with 'dask worker" in capsys.readouterr().err


def test_workers_of_another_version_are_refused(
    tmp_path: Path, client: Client, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def software_versions() -> tuple[str, str]:  # the workers are threads
        return ("0.1.0" if threading.current_thread() is threading.main_thread() else "9.9.9"), "0123456789abcdef"

    monkeypatch.setattr("dcrb_ros.sweep.cluster.software_versions", software_versions)
    (tmp_path / "small.yaml").write_text("duration: 0.02", encoding="utf-8")
    assert dcrb("sweep", str(tmp_path / "small.yaml"), "-o", str(tmp_path / "set"), "--scheduler", client.scheduler.address) == 2
    output = capsys.readouterr().err
    assert "run dcrb_ros 9.9.9 with model 0123456789abcdef, but this is 0.1.0 with" in output
    assert "install the same version on all machines" in output
    assert not list(tmp_path.rglob("*.npz"))


def test_a_worker_of_another_version_that_joins_later_ends_the_sweep(tmp_path: Path, client: Client) -> None:
    plan = plan_of(QUICK)
    common = replace(common_settings(plan.sweep, Store(str(tmp_path))), software=("9.9.9", "0123456789abcdef"))
    with pytest.raises(StoreFailed, match=r"a worker runs dcrb_ros .* but the sweep runs 9\.9\.9 with model 0123456789abcdef: install"):
        list(ClusterWorkers(client).dispatched(common, plan.groups()))
    assert not list(tmp_path.rglob("*.json"))


def test_a_dry_run_writes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "small.yaml").write_text(SMALL, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert dcrb("sweep", "small.yaml", "--dry-run", "--workers", "2") == 0
    output = capsys.readouterr().out
    assert "24 runs of 0.25 s in 12 conditions" in output
    assert "| train | healthy | 8 |" in output
    assert "on 2 workers" in output
    assert list(tmp_path.iterdir()) == [tmp_path / "small.yaml"]


def test_other_programs_do_not_change_the_estimated_time(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = {"process": 0.0, "delays": 0.0}

    def simulated(common: CommonSettings, task: list[PlannedRun]) -> list[tuple[int, str]]:
        """Take 0.5 s per run and 0.1 s per recorded second, and longer delays by other programs in shorter runs."""
        duration = common.file.duration
        clock["process"] += len(task) * (0.5 + 0.1 * duration)
        clock["delays"] += len(task) * (10.0 - duration)
        return [(0, "done") for _ in task]

    times = SimpleNamespace(process_time=lambda: clock["process"], perf_counter=lambda: clock["process"] + clock["delays"])
    monkeypatch.setattr("dcrb_ros.sweep.estimate.run_task", simulated)
    monkeypatch.setattr("dcrb_ros.sweep.estimate.time", times)
    monkeypatch.setattr("dcrb_ros.sweep.estimate.cores", lambda: 2)
    monkeypatch.setattr("dcrb_ros.sweep.estimate._worker_start", lambda: 1.5)
    cost = estimate(plan_of({**QUICK, "duration": 2.0, "seeds": 3}))
    assert (cost.start, cost.factor) == (pytest.approx(0.5), pytest.approx(10.0))
    assert cost.seconds(2) == pytest.approx((2 * 1.5 + 3 * 0.7) / 2)
    # There is no task for a fourth worker.
    assert cost.seconds(3) == cost.seconds(100) == pytest.approx((3 * 1.5 + 3 * 0.7) / 2)
    process, wall = 2 * 0.5 + 0.1 * 0.4, 2 * 10.5 - 0.9 * 0.4  # a run of 0.05 s and one of 0.35 s
    assert cost.delay == pytest.approx(wall / process)


def test_the_cost_is_that_of_runs_from_the_whole_plan_and_of_few_in_a_large_group(monkeypatch: pytest.MonkeyPatch) -> None:
    done, clock = list[PlannedRun](), {"process": 0.0}

    def simulated(common: CommonSettings, task: list[PlannedRun]) -> list[tuple[int, str]]:
        """Take twice the time at the higher loads."""
        done.extend(task)
        clock["process"] += sum(0.2 if run.changes["operating.load"] > 5e4 else 0.1 for run in task) * common.file.duration
        return [(0, "done") for _ in task]

    times = SimpleNamespace(process_time=lambda: clock["process"], perf_counter=lambda: clock["process"])
    monkeypatch.setattr("dcrb_ros.sweep.estimate.run_task", simulated)
    monkeypatch.setattr("dcrb_ros.sweep.estimate.time", times)
    widths = {"faults.outer_1.width": {"low": 0.001, "high": 0.003, "count": 500}}
    loads = {"operating.load": {"low": 1e4, "high": 9e4, "count": 100}}
    cost = estimate(plan_of({**QUICK, "vary": loads, "cases": {"outer": widths}}))
    assert cost.runs == 50_000
    assert len(done) <= 7 * 16
    assert cost.factor == pytest.approx(1 / 0.15, rel=0.15)


def test_the_disk_space_is_estimated(tmp_path: Path) -> None:
    plan = plan_of({**QUICK, "duration": 10.0})
    assert estimate(plan).size == pytest.approx(10.0 * 51200 * 12, rel=0.05)


@pytest.mark.parametrize(
    ("tree", "sentence"),
    [
        ({"durations": 1.0}, "unknown key 'durations'; did you mean 'duration'?"),
        ({"duration": None}, "duration = None"),
        ({"duration": -1.0}, "duration = -1.0: it should be greater than 0"),
        ({"base": "heathy"}, "did you mean 'healthy'?"),
        ({"set": {"operating.sped": 1.0}}, "did you mean 'operating.speed'?"),
        ({"vary": {"operating.speed": []}}, "operating.speed has an empty list, so there would be no run"),
        ({"vary": {"operating.speed": [100.0, "fast"]}}, "operating.speed = 'fast' rad/s is not a number within -1000"),
        ({"vary": {"bearing.roller_radius": [15.0]}}, "is outside 0.0005 .. 0.2 m: lengths are in metres"),
        ({"vary": {"cage.joint": ["pockets"]}}, "did you mean 'pocket'?"),
        ({"vary": {"operating.load": {"low": 1.0, "high": 2.0}}}, "a grid needs the number of values of a range: give count"),
        ({"vary": {"operating.load": {"low": 2.0, "high": 1.0, "count": 2}}}, "low = 2.0 is not below high = 1.0"),
        ({"vary": {"operating.load": {"low": 0.0, "high": 1.0, "count": 2, "scale": "log"}}}, "is not above 0"),
        ({"vary": {"operating.load": {"low": 1.0, "hihg": 2.0}}}, "did you mean 'high'?"),
        ({"vary": {"operating.load": {}}}, "operating.load: a range needs low and high"),
        ({"vary": {"operating.sped": {}}}, "did you mean 'operating.speed'?"),
        ({"vary": {"operating": {"sped": {}}}}, "did you mean 'operating.speed'?"),
        ({"cases": {"outer": {"faults.outer_1.kind": {}}}}, "cases.outer: faults.outer_1.kind: a range needs low and high"),
        ({"vary": {"simulation.seed": [1]}}, "simulation.seed cannot be set here: use 'seeds'"),
        ({"vary": {"scenario": ["growing_spal"]}}, "did you mean 'growing_spall'?"),
        ({"vary": {"scenario": ["growing_spall"]}, "twins": True}, "contains faults"),
        (
            {"cases": {"grows": {"scenario": "growing_spall"}}, "settle": 1.5, "duration": 0.5},
            "the scenario 'growing_spall' changes nothing in a run of 2 s, its first entry is at 2 s: increase duration",
        ),
        ({"design": "latin_hypercube"}, "needs 'points'"),
        ({"design": "sobol"}, "design = 'sobol'"),
        ({"points": 10}, "the values of a grid determine its points"),
        ({"seed": 1}, "seed = 1 is that of the designs random and latin_hypercube: remove it, or give 'seeds'"),
        (
            {"design": "random", "points": 3, "vary": {"operating.load": {"low": 1e4, "high": 1e5, "count": 3}}},
            "operating.load: count = 3 applies to a grid only",
        ),
        ({"seeds": 0}, "seeds = 0"),
        ({"seeds": []}, "seeds = []"),
        ({"seeds": [2**31]}, "a list of seeds within 0 .. 2147483647"),
        ({"duration": 1e-6}, "duration = 1e-06 s has no sample at 51200 Hz: give at least 1.95e-05 s"),
        (
            {"duration": 4e-5, "vary": {"sensor.sampling_rate": [51200, 10240]}},
            "duration = 4e-05 s has no sample at 10240 Hz: give at least 9.77e-05 s",
        ),
        (
            {"duration": 4e-5, "cases": {"slow": {"sensor.sampling_rate": {"low": 10240, "high": 51200, "count": 3}}}},
            "duration = 4e-05 s has no sample at 10240 Hz: give at least 9.77e-05 s",
        ),
        ({"seeds": [3, 4, 3]}, "seeds has 3 twice"),
        ({"vary": {"operating.load": [5e4], "operating": {"load": [6e4]}}}, "operating.load occurs twice, in its group and with a dotted"),
        (
            {"cases": {"outer": {"faults": {"outer_1": {"width": 0.001}}, "faults.outer_1.width": 0.002}}},
            "faults.outer_1.width occurs twice",
        ),
        ({"cases": {"fast": {"operating.speed": 200.0}}}, "move it to 'vary'"),
        ({"cases": {"healthy": {"faults.outer_1.width": 0.001}}, "twins": True}, "must be empty"),
        ({"split": {"train": 0.9}}, "add up to 1.3, but must add up to 1"),
        ({"split": {"tests": 0.9}}, "did you mean 'test'?"),
        ({"windows": {"length": 100_000}}, "is longer than a run of 0.02 s"),
        (
            {"windows": {"length": 400}, "vary": {"sensor.sampling_rate": [51200, 10240]}},
            "windows.length = 400 samples is longer than a run of 0.02 s, 205 samples at 10240 Hz: shorten",
        ),
        ({"windows": {"length": 8}}, "windows.length = 8"),
        ({"duration": 1e4}, "too long for memory"),
        ({"branch_at": 0.1}, "settle = 0 s is below 0.005 s"),
        ({"branch_at": 0.1, "settle": 0.1, "cases": {"slow": {"sensor.sampling_rate": 25600}}}, "cannot change while the bearing runs"),
        ({"branch_at": 0.1, "settle": 0.1, "cases": {"grows": {"scenario": "growing_spall"}}}, "cannot be combined with a scenario"),
        (
            {"set": {"operating.speed": 80.0}, "vary": {"operating.speed": [100.0]}},
            "operating.speed = 80.0 under 'set' would have no effect",
        ),
        ({"set": {"operating.speed_kmh": 80.0}, "vary": {"operating.speed": [100.0]}}, "two forms of one parameter: give one of them"),
        ({"set": {"operating.speed": 80.0}, "vary": {"operating.speed_kmh": [100.0]}}, "two forms of one parameter: give one of them"),
        ({"set": {"operating": {"speed": 80.0, "speed_kmh": 10.0}}}, "two forms of one parameter: give one of them"),
        ({"vary": {"operating.speed_kmh": [80.0, 0]}}, "operating.speed_kmh = 0.0 km/h stands for no speed in km/h: vary operating.speed"),
        ({"output": "wav"}, "output = 'wav'"),
        ({"vary": {"publishing.loss_probability": [0.0, 0.1]}}, "publishing.loss_probability causes gaps"),
    ],
)
def test_an_invalid_sweep_is_refused_in_one_sentence(tree: dict[str, Any], sentence: str) -> None:
    with pytest.raises(Refusal) as refused:
        sweep_of({**QUICK, **tree}, "sweep.yaml")
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)


def test_invalid_usage_exits_with_status_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, begun = tmp_path / "sweep.yaml", tmp_path / "begun"
    file.write_text("duration: 0.02", encoding="utf-8")
    (tmp_path / "list.yaml").write_text("- 1", encoding="utf-8")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.txt").touch()
    with open_data_set(plan_of({"duration": 0.03}), Store(str(begun))):
        pass
    damaged = tmp_path / "damaged"
    damaged.mkdir()
    (damaged / "sweep.json").write_text('{"name": "3f', encoding="utf-8")
    folder, free = str(tmp_path / "set"), str(file)
    for arguments, sentence in (
        (["sweep"], "Missing argument"),
        (["sweep", free], "Missing option '-o'"),
        (["sweep", "nothing", "-o", folder], "there is no sweep 'nothing'"),
        (["sweep", str(tmp_path / "list.yaml"), "-o", folder], "is not a sweep"),
        (["sweep", free, "-o", str(tmp_path / "other")], "contains files that are not a data set"),
        (["sweep", free, "-o", str(begun)], "was made with another sweep (duration differs)"),
        (["sweep", free, "-o", "/proc/set"], "/proc/set cannot be written"),
        (["sweep", free, "-o", str(tmp_path / "list.yaml")], "list.yaml cannot be read: Not a directory; give an empty or a new folder"),
        (["sweep", free, "-o", str(damaged)], "sweep.json is damaged, so the data set cannot be continued"),
        (["sweep", free, "-o", "memory://set"], "is deleted when this command ends"),
        (["sweep", free, "-o", "nowhere://set"], "cannot be used for a data set"),
        (["sweep", free, "-o", folder, "--workers", "0"], "--workers"),
        (["sweep", free, "-o", folder, "--memory", "much"], "--memory much is not a size"),
        (["sweep", free, "-o", folder, "--scheduler", "tcp://127.0.0.1:9", "--workers", "2"], "leave out --workers"),
    ):
        assert dcrb(*arguments) == 2, arguments
        output = capsys.readouterr().err.strip().splitlines()
        assert sentence in output[-1]
        assert len([line for line in output if "too few conditions" not in line]) == 1


def test_a_missing_dask_is_reported(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(Refusal, match="--scheduler needs Dask: pip install dask distributed"), cluster_workers("tcp://127.0.0.1:9"):
        pass
    monkeypatch.setitem(sys.modules, "fsspec", None)
    assert dcrb("sweep", "two_hundred", "-o", str(tmp_path)) == 2
    assert "dcrb sweep needs fsspec: pip install fsspec" in capsys.readouterr().err


def test_a_sweep_without_a_successful_run_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = plan_of({**QUICK, "set": {"bearing.roller_radius": 0.04}})
    store = Store(str(tmp_path))
    for task in plan.groups():
        run_task(common_settings(plan.sweep, store), task)
    from dcrb_ros.cli.sweep import _print_summary
    from dcrb_ros.sweep.table import write_table

    with pytest.raises(RuntimeError, match=r"no run of .* succeeded \(1 refused\)"):
        _print_summary(write_table(plan, store), store, 1)
    assert "check the three radii" in capsys.readouterr().err


def test_the_printed_python_line_loads_a_folder_of_any_name_and_a_split_with_runs(capsys: pytest.CaptureFixture[str]) -> None:
    from dcrb_ros.cli.sweep import _print_summary
    from dcrb_ros.sweep.table import Tally

    tally = Tally(classes=Counter({("test", "healthy"): 1}), statuses=Counter(done=1))
    for address in ("/tmp/bob's set", "file:///tmp/bob's set"):
        _print_summary(tally, Store(address), 1)
        assert """dcrb_ros.DataSet("/tmp/bob's set").windows('test')""" in capsys.readouterr().out
    _print_summary(tally, Store("memory://set"), 3)  # a DataSet is a folder
    out, err = capsys.readouterr()
    assert "load it with" not in out
    assert "1 different run of 3 in the design: equal ones are made once" in err


def test_the_shipped_sweep_has_200_runs_in_five_classes() -> None:
    plan = Plan(read_sweep("two_hundred"))
    assert plan.sweep.count == 200
    assert Counter(run.case for run in plan.runs()) == dict.fromkeys(("healthy", "outer", "inner", "roller", "cage"), 40)
