"""Vehicles as they are run: one box is the bench, threads and blocks change no bit, failures, commands, files and recordings."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from same_process import dcrb

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.shipped import shipped
from dcrb_ros.simulation.loop import ModelFailure, Simulation
from dcrb_ros.vehicle.file import read_vehicle, vehicle_of
from dcrb_ros.vehicle.simulation import VehicleBlock, VehicleSimulation

pytestmark = pytest.mark.slow
DRY = {"vehicle.bench": "dry", "vehicle.speed_kmh": 100.0}
"""The quickest bench."""
SMOOTH = {"track.spectrum": "none", "track.roughness": -40.0}
NOTCH = {"axle_1.left.faults.outer_1.width": 0.003}
DURATION = 0.12


def bogie(*changes: dict[str, Any], source: str = "healthy_bogie", threads: int = 2) -> VehicleSimulation:
    parameters = {key: value for change in (DRY, *changes) for key, value in change.items()}
    return VehicleSimulation(read_vehicle(source, parameters), threads=threads)


def waveforms(blocks: list[VehicleBlock]) -> dict[str, np.ndarray]:
    return {name: np.concatenate([block.boxes[name].acceleration for block in blocks]) for name in blocks[-1].boxes}


def test_a_vehicle_of_one_box_without_a_track_is_the_bench() -> None:
    parameters = {**DRY, **SMOOTH, **NOTCH}
    vehicle = vehicle_of(parameters, "one box")
    (box,) = vehicle.boxes
    whole = waveforms(list(VehicleSimulation(vehicle).blocks(DURATION)))[box.name]
    alone = np.concatenate([block.acceleration for block in Simulation(box.configuration).blocks(DURATION)])
    assert np.array_equal(whole, alone)


def test_threads_and_blocks_change_no_bit() -> None:
    small = {f"axle_{axle}.{side}.publishing.block_size": 256 for axle in (1, 2) for side in ("left", "right")}
    one, two, four = (
        waveforms(list(bogie(NOTCH, *more, threads=threads).blocks(DURATION))) for threads, more in ((1, ()), (2, (small,)), (4, ()))
    )
    for name, expected in one.items():
        assert expected.std() > 0.1
        assert np.array_equal(expected, two[name])
        assert np.array_equal(expected, four[name])


def test_both_boxes_of_a_wheelset_have_one_angle_and_all_boxes_one_clock() -> None:
    blocks = list(bogie({"axle_2.radius": 0.459}).blocks(DURATION))
    angles = {name: np.concatenate([block.boxes[name].shaft_angle for block in blocks]) for name in blocks[0].boxes}
    assert np.array_equal(angles["axle_1.left"], angles["axle_1.right"])
    assert np.array_equal(angles["axle_2.left"], angles["axle_2.right"])
    assert not np.array_equal(angles["axle_1.left"], angles["axle_2.left"])
    for block in blocks:
        assert len({(box.index, len(box.shaft_angle)) for box in block.boxes.values()}) == 1


def test_the_other_box_of_the_axle_hears_a_defect_and_the_truth_says_how_loud() -> None:
    loud, calm = list(bogie(SMOOTH, NOTCH).blocks(0.3)), list(bogie(SMOOTH).blocks(0.3))
    spectra = {}
    for name, blocks in (("loud", loud), ("calm", calm)):
        right = waveforms(blocks)["axle_1.right"][:, 1].astype(float)
        spectra[name] = right[2048:].std()
    assert spectra["loud"] > spectra["calm"]
    parts = loud[-1].truth.parts
    assert parts["axle_1.left"][0] > 3.0 * parts["axle_1.right"][0]
    assert parts["axle_1.right"][1] > 3.0 * parts["axle_2.right"][1] > 0.0
    assert parts["axle_1.right"][2] == 0.0


def test_loads_follow_a_commanded_curve() -> None:
    simulation = bogie(SMOOTH)
    run = simulation.blocks()
    before = next(run).truth.load
    simulation.command(curvature=1.0 / (100.0 / 3.6) ** 2)
    for _ in range(6):
        after = next(run).truth.load
    assert after["axle_1.right"] - before["axle_1.right"] == pytest.approx(5331.0, abs=2.0)
    assert after["axle_1.left"] - before["axle_1.left"] == pytest.approx(-5331.0, abs=2.0)
    assert sum(after.values()) == pytest.approx(sum(before.values()), abs=1.0)


def test_a_live_fault_is_in_the_truth_of_its_box() -> None:
    simulation = bogie(SMOOTH)
    run = simulation.blocks()
    next(run)
    simulation.change({"axle_2.right.faults.inner_1.width": 0.002})
    faulty = {name for _ in range(6) for name, box in next(run).boxes.items() if any("inner_1" in truth.faults for truth in box.truths)}
    assert faulty == {"axle_2.right"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"axle_3.left.faults.outer_1.width": 0.002}, "names no box"),
        ({"axle_1.left.operating.speed": 50.0}, "belongs to the vehicle"),
        ({"axle_1.left.faults.outer_1.widht": 0.002}, "unknown parameter"),
    ],
)
def test_changes_of_no_box_are_refused(change: dict[str, float], message: str) -> None:
    with pytest.raises(Refusal, match=message):
        bogie(SMOOTH).change(change)


@pytest.mark.parametrize("command", [{"speed_kmh": 500.0}, {"speed_kmh": float("nan")}, {"curvature": 1.0}, {"speed": 10.0}])
def test_commands_out_of_range_are_refused(command: dict[str, float]) -> None:
    with pytest.raises(Refusal, match=next(iter(command))):
        bogie(SMOOTH).command(**command)


def failing(original: Callable[..., Any], box: Simulation, after: int) -> Callable[..., Any]:
    def step_to(self: Simulation, end: int) -> Any:
        if self is box and end > after:
            raise ModelFailure("the model failed on purpose")
        return original(self, end)

    return step_to


def test_a_box_that_fails_ends_the_run_after_its_earlier_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = list(bogie().blocks(DURATION))
    simulation = bogie()
    monkeypatch.setattr(Simulation, "step_to", failing(Simulation.step_to, simulation.simulations["axle_2.left"], 6000))
    blocks: list[VehicleBlock] = []
    with pytest.raises(ModelFailure, match=r"axle_2\.left: the model failed on purpose"):
        blocks.extend(simulation.blocks(DURATION))
    assert 0 < len(blocks) < len(expected)
    for block, other in zip(blocks, expected, strict=False):
        for name in block.boxes:
            assert np.array_equal(block.boxes[name].acceleration, other.boxes[name].acceleration)


def test_the_others_go_on_where_the_file_asks_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = bogie({"vehicle.on_failure": "continue"})
    monkeypatch.setattr(Simulation, "step_to", failing(Simulation.step_to, simulation.simulations["axle_2.left"], 6000))
    blocks = list(simulation.blocks(DURATION))
    assert set(blocks[0].boxes) == {"axle_1.left", "axle_1.right", "axle_2.left", "axle_2.right"}
    assert set(blocks[-1].boxes) == {"axle_1.left", "axle_1.right", "axle_2.right"}
    assert blocks[-1].truth.silent == ("axle_2.left",)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"vehicel.speed_kmh": 100.0}, "unknown group 'vehicel'.*'vehicle'"),
        ({"axle_1.radios": 0.46}, "unknown key 'axle_1.radios'"),
        ({"axle_1.radius": 4.6}, "outside 0.3 .. 0.6 m"),
        ({"axle_2.x": 1.28}, "both wheelsets are at x = 1.28 m"),
        ({"axle_1.left.operating.load": 5e4}, "would count twice"),
        ({"axle_1.left.background.track_level": 5.0}, "would count twice"),
        ({"axle_1.left.bench": "nothing"}, "there is no configuration 'nothing'"),
        ({"axle_1.left.sensor.sampling_rate": 25600}, "differ in sensor.sampling_rate"),
        ({"vehicle.speed_kmh": 1.0}, "speed_kmh = 1"),
        ({"axle_1.left": 5}, "is not a box"),
        ({"axle_1.gear": "spur"}, "axle_1.gear = spur is not a gear"),
        ({"axle_1": {}}, "axle_1 has no box"),
        ({"track": 5}, "is not a group"),
        ({"axle_1.left.faults.outer_1.widht": 0.002}, "axle_1.left: .*widht"),
    ],
)
def test_a_vehicle_that_cannot_be_is_refused_in_a_sentence(parameters: dict[str, Any], message: str) -> None:
    whole = {"axle_1.left": {}, "axle_1.right": {}, "axle_2.left": {}, "axle_2.right": {}, **parameters}
    for key in parameters:
        for box in [name for name in whole if key.startswith(f"{name}.") or name.startswith(f"{key}.")]:
            del whole[box]
    with pytest.raises(Refusal, match=message) as caught:
        vehicle_of(whole, "mine.yaml")
    assert "\n" not in str(caught.value)


def test_a_wheelset_on_a_track_has_two_boxes() -> None:
    with pytest.raises(Refusal, match="axle_1 has one box, but it rolls on two wheels"):
        vehicle_of({"axle_1.left": {}, "axle_2.left": {}, "axle_2.right": {}}, "mine.yaml")


def test_boxes_have_individuals_of_their_own() -> None:
    boxes = read_vehicle("healthy_bogie").boxes
    assert len({box.configuration.surfaces.seed for box in boxes}) == len({box.configuration.simulation.seed for box in boxes}) == 4
    assert {box.configuration.operating.speed_fluctuation for box in boxes} == {0.0}


@pytest.mark.parametrize("name", sorted(shipped("vehicle")))
def test_shipped_vehicles_run(name: str) -> None:
    blocks = list(VehicleSimulation(read_vehicle(name)).blocks(0.05))
    assert all(np.isfinite(values).all() and values.std() > 0.0 for values in waveforms(blocks).values())


def test_a_recording_holds_every_box_and_is_simulated_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = tmp_path / "bogie"
    settings = [f"{key}={value}" for key, value in {**DRY, **NOTCH}.items()]
    options = [part for setting in settings for part in ("--set", setting)]
    assert dcrb("simulate", "--vehicle", "healthy_bogie", "-o", str(bag), "--duration", "0.2", "--quiet", *options) == 0
    recordings = {name: Recording(bag / name) for name in ("axle_1.left", "axle_1.right", "axle_2.left", "axle_2.right")}
    assert {recording.namespace for recording in recordings.values()} == {f"/dcrb/{name.replace('.', '/')}" for name in recordings}
    for recording in recordings.values():
        assert recording.acceleration.shape == (10240, 2)
        assert recording.complete
        assert recording.orders == characteristic_orders(recording.configuration.bearing)
    lines = [json.loads(line) for line in (bag / "ground_truth.jsonl").read_text().splitlines()]
    assert [line["time_ns"] for line in lines] == sorted(line["time_ns"] for line in lines)
    assert dcrb("simulate", "--from", str(bag), "--quiet") == 0
    assert "the same samples in 4 boxes" in capsys.readouterr().out
    assert dcrb("simulate", "--from", str(bag / "axle_1.left"), "--quiet") == 2
    assert "is a box of the vehicle in" in capsys.readouterr().err
    assert dcrb("detect", str(bag)) == 2
    assert "is the recording of a vehicle" in capsys.readouterr().err
    assert dcrb("simulate", "--vehicle", "healthy_bogie", "-o", str(bag), "--duration", "0.2", "--quiet", *options) == 2
    about = (bag / "vehicle.json").read_text()
    (bag / "vehicle.json").write_text(about.replace("100.0", "101.0"))
    assert dcrb("simulate", "--from", str(bag), "--quiet") == 2
    assert "its digest does not match" in capsys.readouterr().err
    (bag / "vehicle.json").write_text(about)
    (bag / "axle_1.left").rename(tmp_path / "aside")
    (bag / "axle_2.left").rename(bag / "axle_1.left")
    (tmp_path / "aside").rename(bag / "axle_2.left")
    assert dcrb("simulate", "--from", str(bag), "--quiet") == 2
    assert "is not the recording that vehicle.json names" in capsys.readouterr().err
    assert dcrb("simulate", "dry", "--vehicle", "bogie") == 2
    assert dcrb("simulate", "--vehicle", "no_such_vehicle") == 2
    assert "there is no vehicle 'no_such_vehicle'" in capsys.readouterr().err
