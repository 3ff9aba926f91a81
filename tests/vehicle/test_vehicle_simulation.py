"""Vehicles as they are run: one box is the bench, threads and blocks change no bit, failures, commands, files and recordings."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from altered_recording import altered
from mcap.records import Metadata
from same_process import dcrb

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.cli.detect_vehicle import vehicle_as_object
from dcrb_ros.messages.plain import decode_text
from dcrb_ros.messages.topics import VIBRATION
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DIAGNOSIS, VEHICLE_TRUTH
from dcrb_ros.recordings.mcap_reader import McapRecords
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.replay import Replay, ReplayParameters
from dcrb_ros.recordings.reproduction import NotReproduced
from dcrb_ros.recordings.splitting import Bag
from dcrb_ros.recordings.vehicle import VehicleRecording, VehicleReproduction
from dcrb_ros.recordings.vehicle_recorder import VehicleCommand, VehicleRecorder, give
from dcrb_ros.recordings.verification import digest_mismatch
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import flatten, load_configuration
from dcrb_ros.settings.shipped import shipped
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.pending import MAX_PENDING
from dcrb_ros.stream.events import ParameterChange
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.vehicle.block import VehicleBlock
from dcrb_ros.vehicle.changes import sorted_changes
from dcrb_ros.vehicle.description import described
from dcrb_ros.vehicle.file import read_parameters, read_vehicle, vehicle_of
from dcrb_ros.vehicle.model import VehicleModel
from dcrb_ros.vehicle.simulation import VehicleSimulation

pytestmark = pytest.mark.slow
DRY = {"vehicle.bench": "dry", "vehicle.speed_kmh": 100.0}
"""The quickest bench."""
SMOOTH = {"track.spectrum": "none", "track.roughness": -40.0}
ROLLING = {"left.wheel.flat": 0.02, "left.wheel.unbalance": 0.05, "left.wheel.polygon": "3 1e-5", "gear.teeth": 87}
FIXED = ("track.roughness", "axle_1.gear.level", "axle_1.creep", "vehicle.seed")
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


def test_a_change_that_a_later_box_refuses_changes_no_box() -> None:
    simulation = bogie(SMOOTH)
    first, last = (simulation.simulations[name] for name in ("axle_1.left", "axle_2.right"))
    for number in range(MAX_PENDING):
        last.change({"faults.outer_1.width": 0.001 + 1e-6 * number})
    changes = {"axle_1.left.faults.outer_1.width": 0.002, "axle_2.slide": 0.1, "axle_2.right.faults.outer_1.width": 0.003}
    with pytest.raises(Refusal, match="commands are already waiting"):
        simulation.change(changes)
    assert not first.has_pending
    next(simulation.blocks())
    assert first.configuration.faults.outer_1.width == 0.0
    simulation.change(changes)
    assert first.has_pending
    assert last.has_pending


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


def test_swapped_sensors_exchange_their_waveforms_and_nothing_else() -> None:
    own = list(bogie(NOTCH, {"axle_2.radius": 0.459}).blocks(DURATION))
    swapped = list(bogie(NOTCH, {"axle_2.radius": 0.459, "axle_1.left.sensor.swapped_with": "axle_2.right"}).blocks(DURATION))
    partner = {"axle_1.left": "axle_2.right", "axle_2.right": "axle_1.left"}
    for block, other in zip(own, swapped, strict=True):
        for name, box in other.boxes.items():
            assert np.array_equal(box.acceleration, block.boxes[partner.get(name, name)].acceleration)
            assert np.array_equal(box.shaft_angle, block.boxes[name].shaft_angle)
            assert [truth.faults for truth in box.truths] == [truth.faults for truth in block.boxes[name].truths]
        assert other.truth == block.truth


def test_a_sensor_that_is_dead_or_loose_from_the_start_changes_no_other() -> None:
    healthy = waveforms(list(bogie().blocks(DURATION)))
    faulty = waveforms(list(bogie({"axle_1.left.sensor.fault": "dead", "axle_2.right.sensor.fault": "loose"}).blocks(DURATION)))
    assert faulty["axle_1.left"].std() < 0.05 * healthy["axle_1.left"].std()
    assert not np.array_equal(faulty["axle_2.right"], healthy["axle_2.right"])
    for name in ("axle_1.right", "axle_2.left"):
        assert np.array_equal(faulty[name], healthy[name])


def test_a_clock_that_is_late_shifts_its_own_samples_alone() -> None:
    exact, late = list(bogie().blocks(DURATION)), list(bogie({"axle_1.left.sensor.clock_offset_ppm": 1000.0}).blocks(DURATION))
    for name in ("axle_1.right", "axle_2.left", "axle_2.right"):
        assert np.array_equal(waveforms(late)[name], waveforms(exact)[name])
    angles = [np.unwrap(np.concatenate([block.boxes["axle_1.left"].shaft_angle for block in blocks])) for blocks in (exact, late)]
    ahead = (angles[1] - angles[0])[-1] / (angles[0][-1] - angles[0][-2])
    assert ahead == pytest.approx(1e-3 * len(angles[0]), rel=0.01)
    for block in late:
        assert len({box.stamp_ns for box in block.boxes.values()}) == 1


def test_slides_and_wheels_change_while_the_vehicle_runs() -> None:
    simulation = bogie(SMOOTH, {"vehicle.speed_kmh": 72.0})
    run = simulation.blocks()
    next(run)
    simulation.change({"axle_2.slide": 0.1, "axle_1.right.wheel.flat": 0.04})
    later = [next(run) for _ in range(20)]
    events = [event for block in later for event in block.truth.events]
    assert [event.box for event in events if event.cause == "slide"] == ["axle_2"]
    assert {event.box for event in events if event.cause == "flat"} == {"axle_1.right"}
    assert later[-1].truth.creep == pytest.approx({"axle_1": 0.0, "axle_2": -0.1})
    for name, turning in (("axle_1.left", 1.0), ("axle_2.left", 0.9), ("axle_2.right", 0.9)):
        steps = np.diff(np.unwrap(later[-1].boxes[name].shaft_angle)).mean() * 51200.0
        assert steps == pytest.approx(20.0 / 0.46 * turning, rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"axle_3.left.faults.outer_1.width": 0.002}, "names no box"),
        ({"axle_1.left.operating.speed": 50.0}, "belongs to the vehicle"),
        ({"axle_1.left.background.flat_level": 5.0}, "belongs to the vehicle"),
        ({"axle_1.left.sensor.swapped_with": "axle_2.left"}, "cannot change during a run"),
        ({"axle_1.left.bench": "dry"}, "'axle_1.left.bench' cannot change during a run: give it in the vehicle's file"),
        ({"axle_1.slide": 0.5}, "outside 0 .. 0.2"),
        ({"axle_1.slide": True}, "axle_1.slide = True is not a number"),
        ({"axle_1.slide": "0.1"}, "axle_1.slide = '0.1' is not a number: give it in shares of the speed"),
        ({"axle_1.left.wheel.flat": 5.0}, "flat"),
        ({"axle_1.left.faults.outer_1.width": 0.001, "axle_2.right.faults.outer_1.width": 0.05}, r"^axle_2\.right: .*width = 0\.05 m"),
        ({"axle_1.left.wheel.polygon": "80 1e-5"}, "whole orders"),
        ({"axle_2.slide": 0.1, "axle_1.left.bearing.rows": 1}, "rows"),
        ({"axle_1.left": {"wheel.flat": 0.02}}, r"^'axle_1\.left' is a box: give one of its parameters, such as axle_1\.left\.faults"),
        ({"axle_1.left.background.track_level": 5.0}, "wheels, track and gear; change the wheel of the box, or give track and gear in the"),
        ({"axle_1.left.time_scale": 2.0}, r"^'axle_1\.left\.time_scale' belongs to the whole vehicle: give time_scale beside the group"),
        ({"vehicle.speed_kmh": 50.0}, r"^'vehicle\.speed_kmh' is a command: give it as speed_kmh to command$"),
        *(({key: 1}, f"'{key}' cannot change during a run: give it in the vehicle's file") for key in FIXED),
        ({"axle_1.gear.levle": 1.0}, "'axle_1.gear.levle' names no box"),
    ],
)
def test_a_change_that_cannot_be_is_refused_and_changes_nothing(changes: dict[str, Any], message: str) -> None:
    simulation = bogie(SMOOTH)
    with pytest.raises(Refusal, match=message):
        simulation.change(changes)
    assert not any(event for block in simulation.blocks(0.05) for event in block.truth.events)


def test_a_box_refuses_what_belongs_to_the_vehicle() -> None:
    box = bogie(SMOOTH).simulations["axle_1.left"]
    with pytest.raises(Refusal, match=r"^speed = 10\.0 rad/s is refused, .* follows from the vehicle: command its speed_kmh$"):
        box.command_speed(10.0)
    with pytest.raises(Refusal, match=r"^force = 0\.0, -50000\.0 N is refused, .* command its curvature, cant, wind or brake$"):
        box.command_load(0.0, -5e4)
    for change in ({"operating.speed": 10.0}, {"time_scale": 2.0}):
        with pytest.raises(Refusal, match="belongs to the"):
            box.change(change)
        with pytest.raises(Refusal, match="belongs to the"):
            box.check_change(change)
    assert not box.has_pending


def test_a_change_beyond_the_full_queue_changes_no_box() -> None:
    simulation = bogie(SMOOTH)
    for _ in range(MAX_PENDING):
        simulation.command(wind=0.0)
    with pytest.raises(Refusal, match="are already waiting"):
        simulation.change({"axle_1.left.faults.outer_1.width": 0.002, "axle_2.slide": 0.1})
    assert not simulation.simulations["axle_1.left"].has_pending
    simulation.change({"axle_1.left.faults.outer_1.width": 0.002})
    assert simulation.simulations["axle_1.left"].has_pending


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


def test_bearings_start_at_the_load_of_the_settled_track() -> None:
    vehicle = read_vehicle("healthy_bogie", {"track.spectrum": "fra_5", "vehicle.speed_kmh": 120.0})
    simulation, model = VehicleSimulation(vehicle), VehicleModel(vehicle)
    at_start = -model.load()[:, 1]
    assert np.abs(at_start - vehicle.static_load).max() > 1e3
    for box, load in zip(simulation.simulations.values(), at_start, strict=True):
        assert box.configuration.operating.load == pytest.approx(load, abs=1e-6)


def test_a_command_that_lifts_a_box_is_refused() -> None:
    simulation = bogie({**SMOOTH, "vehicle.speed_kmh": 200.0})
    sentence = "speed_kmh = 200 km/h with curvature = 0.01 1/m loads axle_1.left with -118.9 kN"
    with pytest.raises(Refusal, match=sentence):
        simulation.command(curvature=0.01)
    with pytest.raises(Refusal, match=sentence):  # the vehicle is faster until its ramp ends
        simulation.command(speed_kmh=20.0, curvature=0.01)
    simulation.command(speed_kmh=300.0)
    with pytest.raises(Refusal, match=r"speed_kmh = 300 km/h with curvature = 0\.002 1/m loads"):
        simulation.command(curvature=0.002)
    simulation.command(curvature=0.001)


def test_a_command_that_lifts_a_box_on_the_way_to_a_low_speed_is_refused() -> None:
    """Cant and wind press a light vehicle to the inner side of a curve, and the speed to the outer one."""
    light = {"body.mass": 8000.0, "body.height": 3.0, "vehicle.curvature": 0.01, "vehicle.cant": 0.18, "vehicle.speed_kmh": 60.0}
    simulation = bogie({**SMOOTH, **light, "vehicle.wind": 8e4})
    with pytest.raises(Refusal, match=r"speed_kmh = 5 km/h with .*wind = 80000 N loads axle_1.right with -"):
        simulation.command(speed_kmh=5.0)


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


def test_a_command_that_is_no_number_is_refused_with_its_range() -> None:
    with pytest.raises(Refusal, match=r"^speed_kmh = nan km/h is not a finite number; the range is 5 \.\. 300 km/h$"):
        bogie(SMOOTH).command(speed_kmh=float("nan"))


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


@pytest.mark.parametrize(
    ("swapped", "partner"),
    [({}, {}), ({"axle_1.right.sensor.swapped_with": "axle_2.left"}, {"axle_1.right": "its sensor is swapped with that of axle_2.left"})],
)
def test_the_others_go_on_where_the_file_asks_for_it(
    swapped: dict[str, str], partner: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    simulation = bogie({"vehicle.on_failure": "continue"}, swapped)
    monkeypatch.setattr(Simulation, "step_to", failing(Simulation.step_to, simulation.simulations["axle_2.left"], 6000))
    blocks = list(simulation.blocks(DURATION))
    assert set(blocks[0].boxes) == {"axle_1.left", "axle_1.right", "axle_2.left", "axle_2.right"}
    assert set(blocks[-1].boxes) == {"axle_1.left", "axle_1.right", "axle_2.right"} - partner.keys()
    assert blocks[-1].truth.silent == {"axle_2.left": "its model failed", **partner}
    assert simulation.silent.keys() == blocks[-1].truth.silent.keys()
    for name, reason in partner.items():
        assert simulation.silent[name] == f"{name}: {reason}"
    with pytest.raises(Refusal, match=r"axle_2\.left: its model failed"):
        simulation.change({"axle_2.left.faults.outer_1.width": 0.002, "axle_2.right.faults.outer_1.width": 0.002})
    simulation.change({"axle_2.right.faults.outer_1.width": 0.002})


def test_simulate_names_the_boxes_that_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    original = Simulation.step_to

    def step_to(self: Simulation, end: int) -> Any:
        if end > 6000 and self.configuration.publishing.frame == "axle_2/left/outer_ring":
            raise ModelFailure("the model failed on purpose")
        return original(self, end)

    monkeypatch.setattr(Simulation, "step_to", step_to)
    changes = ("--set", "vehicle.bench=dry", "--set", "vehicle.on_failure=continue")
    assert dcrb("simulate", "--vehicle", "healthy_bogie", *changes, "-o", str(tmp_path / "run"), "--duration", "0.1", "--quiet") == 0
    assert "dcrb: axle_2.left: the model failed on purpose; this box is silent from then on" in capsys.readouterr().err


def test_a_run_in_which_every_channel_is_silent_ends_with_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = {"axle_1.left.sensor.swapped_with": "axle_1.right", "axle_1.right": {}, "vehicle.on_failure": "continue"}
    simulation = VehicleSimulation(vehicle_of({**DRY, **pair}, "pair"))
    monkeypatch.setattr(Simulation, "step_to", failing(Simulation.step_to, simulation.simulations["axle_1.left"], 600))
    with pytest.raises(ModelFailure, match=r"is swapped with one that has: axle_1\.left: the model failed on purpose"):
        list(simulation.blocks(DURATION))


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"vehicel.speed_kmh": 100.0}, "unknown group 'vehicel'.*'vehicle'"),
        ({"axle_1.radios": 0.46}, "unknown key 'axle_1.radios'"),
        ({"axle_1.radius": 4.6}, "outside 0.3 .. 0.6 m"),
        ({"axle_1.radius": "0.42"}, "mine.yaml: axle_1.radius = '0.42' is not a number: give it in m"),
        ({"axle_2.x": 1.0}, "the wheels of axle_1 at x = 1.28 m and of axle_2 at x = 1 m overlap"),
        ({"axle_2.slide": 0.5}, "axle_2.slide = 0.5 is outside 0 .. 0.2"),
        ({"axle_1.gear": 5}, "axle_1.gear = 5 is not a group"),
        ({"axle_1.motor.poles": 2}, "axle_1.motor: .*poles"),
        ({"axle_1.motor.level": 10}, r"mine\.yaml: axle_1\.motor\.level = 10 needs gear\.teeth: give the teeth of the wheel on the axle"),
        ({"axle_1.left.wheel.unbalance": 75.0}, "75 g m are 0.075"),
        ({"axle_1.left.sensor.swapped_with": "axle_3.left"}, "names no other box"),
        ({"axle_1.left.sensor.swapped_with": "axle_1.left"}, "names no other box"),
        ({"axle_1.left.sensor.swapped_with": 2}, "is not the name of a box"),
        (
            {"axle_1.left.sensor.swapped_with": "axle_1.right", "axle_2.left.sensor.swapped_with": "axle_1.right"},
            "axle_1.right is swapped with those of axle_1.left and axle_2.left",
        ),
        ({"axle_1.left.operating.load": 5e4}, "would count twice"),
        ({"axle_1.left.background.track_level": 5.0}, "would count twice"),
        ({"axle_2.left.bench": "outer_ring_defct"}, r"^mine\.yaml: axle_2\.left\.bench: there is no configuration 'outer_ring_defct'"),
        ({"vehicle.bench": "nothing"}, r"^mine\.yaml: vehicle\.bench: there is no configuration 'nothing'"),
        ({"axle_1.left.sensor.sampling_rate": 25600}, "differ in sensor.sampling_rate"),
        ({"axle_1.left.thermal.acceleration": 100.0}, "differ in thermal.acceleration"),
        ({"vehicle.speed_kmh": 1.0}, "speed_kmh = 1"),
        (
            {"vehicle.speed_kmh": 200.0, "vehicle.curvature": -0.01},
            "mine.yaml, vehicle: speed_kmh = 200 .* loads axle_1.right with -118.9 kN, .*: lower the speed or the curvature$",
        ),
        (
            {"vehicle.brake": 1.5, "body.mass": 1e3, "frame.mass": 500.0},
            "with brake = 1.5 m/s.2 loads axle_2.left with -0.*: lower the brake$",
        ),
        ({"axle_1.left": 5}, "is not a box"),
        ({"axle_1.left": 0}, "axle_1.left = 0 is not a box"),
        ({"axle_1.left": []}, "is not a box"),
        ({"axle_1.left.wheel": 5}, "axle_1.left.wheel = 5 is not a group of parameters: give one of unbalance"),
        ({"axle_1.gear": "spur"}, "axle_1.gear = spur is not a group"),
        ({"axle_1.left.recording.path": "bag"}, "belongs to the whole vehicle"),
        ({"publishing.block_sice": 512}, "block_sice"),
        ({"axle_1": {}}, "axle_1 has no box"),
        ({"track": 5}, "is not a group"),
        ({"track.joint_spacing": 1e-3}, "track: joint_spacing = 0.001 m is outside 1 .. 1000 m: give 0 for welded rails"),
        ({"time_scale": -1.0}, "mine.yaml: settings: time_scale = -1.0 is outside 0 .. 1000"),
        ({"recording.split_duration": -1.0}, "mine.yaml: settings: recording.split_duration = -1.0 s is outside"),
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


def test_empty_boxes_and_wheels_are_those_without_changes() -> None:
    sides = {"left": None, "right": {"wheel": {}}}
    assert vehicle_of(flatten({"axle_1": sides, "axle_2": sides}), "mine.yaml").boxes == vehicle_of({name: {} for name in BOXES}, "").boxes


@pytest.mark.parametrize("section", ["/**", "vehicle_simulator", "/dcrb/vehicle_simulator"])
def test_a_parameter_file_of_ros_describes_a_vehicle(section: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    tree = {section: {"ros__parameters": {"vehicle": {"speed_kmh": 90.0}}}, "/**/vehicle_detector": {"ros__parameters": {"window": 3.0}}}
    file.write_text(yaml.safe_dump(tree), encoding="utf-8")
    assert read_parameters(file, ["axle_1.creep=0.001"]) == {"vehicle.speed_kmh": 90.0, "axle_1.creep": 0.001}


def test_what_no_node_reads_in_a_file_of_a_vehicle_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("/**: {ros__parameters: {vehicle: {speed_kmh: 90.0}}}\ntrack: {joints: 20.0}", encoding="utf-8")
    with pytest.raises(Refusal, match=r"mine\.yaml: 'track' is beside the section '/\*\*', so no node would read it"):
        read_parameters(file)


def test_a_slide_may_be_a_number_of_numpy() -> None:
    simulation = bogie(SMOOTH, {"axle_1.slide": np.float32(0.1)})
    assert simulation.vehicle.axles[0].slide == pytest.approx(0.1)
    simulation.change({"axle_2.slide": np.float32(0.125)})
    ((key, value),) = next(simulation.blocks(0.001)).truth.commands
    assert (key, value, type(value)) == ("axle_2.slide", 0.125, float)


@pytest.mark.parametrize("threads", [0, -1])
def test_threads_below_one_are_refused(threads: int) -> None:
    with pytest.raises(Refusal, match=f"threads = {threads} is below 1: give the number"):
        bogie(SMOOTH, threads=threads)


def test_a_duration_that_cannot_be_is_refused_before_the_first_block() -> None:
    with pytest.raises(Refusal, match="duration = -1 s is negative"):
        bogie(SMOOTH).blocks(-1.0)


def test_another_type_than_a_vehicle_is_refused() -> None:
    with pytest.raises(Refusal, match="vehicle is a int: give a value of the type Vehicle"):
        VehicleSimulation(3)  # type: ignore[arg-type]


@pytest.mark.parametrize("rolling", [{}, *(SMOOTH | {f"axle_1.{key}": value} for key, value in ROLLING.items())])
def test_a_wheelset_on_a_track_or_with_a_defective_wheel_or_a_gear_has_two_boxes(rolling: dict[str, Any]) -> None:
    with pytest.raises(Refusal, match=r"^mine\.yaml: axle_1 has one box, but it rolls on two wheels: give both"):
        vehicle_of({"axle_1.left": {}, "axle_2.left": {}, "axle_2.right": {}, **rolling}, "mine.yaml")


def test_the_wheel_of_a_wheelset_with_one_box_gets_no_defect() -> None:
    vehicle = vehicle_of({**DRY, **SMOOTH, "axle_1.left": {}}, "mine.yaml")
    present = {"axle_1.left": vehicle.boxes[0].wheel}
    assert sorted_changes(vehicle, present, {"axle_1.left.wheel.flat": 0.0}).wheels == present
    with pytest.raises(Refusal, match=r"^axle_1\.left\.wheel: axle_1 has one box, but it rolls on two wheels"):
        sorted_changes(vehicle, present, {"axle_1.left.wheel.flat": 0.02})


def test_boxes_have_individuals_of_their_own() -> None:
    boxes = read_vehicle("healthy_bogie").boxes
    assert len({box.configuration.surfaces.seed for box in boxes}) == len({box.configuration.simulation.seed for box in boxes}) == 4
    assert {box.configuration.operating.speed_fluctuation for box in boxes} == {0.0}


@pytest.mark.parametrize("name", sorted(shipped("vehicle")))
def test_shipped_vehicles_run(name: str) -> None:
    blocks = list(VehicleSimulation(read_vehicle(name)).blocks(0.05))
    assert all(np.isfinite(values).all() and values.std() > 0.0 for values in waveforms(blocks).values())


BOXES = ("axle_1.left", "axle_1.right", "axle_2.left", "axle_2.right")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of 0.2 s, with a command to the vehicle and a change of a box."""
    bag, parameters = tmp_path_factory.mktemp("vehicle") / "bogie", read_parameters("healthy_bogie", {**DRY, **NOTCH})
    simulation = VehicleSimulation(vehicle_of(parameters, "test"), threads=2)
    with VehicleRecorder(bag, parameters, simulation) as recorder:
        for number, block in enumerate(simulation.blocks(0.2)):
            recorder.write(block)
            if number == 3:
                simulation.command(speed_kmh=90.0, curvature=0.001)
                simulation.change({"axle_2.right.faults.inner_1.width": 0.002})
    return bag


def test_one_recording_holds_every_box_with_equal_stamps(run: Path) -> None:
    recordings = {name: Recording(run / name) for name in BOXES}
    assert {recording.namespace for recording in recordings.values()} == {f"/dcrb/{name.replace('.', '/')}" for name in BOXES}
    for recording in recordings.values():
        assert recording.acceleration.shape == (10240, 2)
        assert recording.complete
        assert recording.orders == characteristic_orders(recording.configuration.bearing)
        assert not digest_mismatch(recording)
    stamps = {name: [message.time_ns for message in recording.messages((VIBRATION,))] for name, recording in recordings.items()}
    assert len(stamps["axle_1.left"]) == 10
    assert all(times == stamps["axle_1.left"] for times in stamps.values())


def test_a_recording_is_opened_by_a_string_and_refuses_what_is_no_path(run: Path) -> None:
    assert VehicleRecording(str(run)).parameters == VehicleRecording(run).parameters
    with pytest.raises(Refusal, match=r"^7 is not the path of a recording: give a folder"):
        VehicleRecording(7)  # type: ignore[arg-type]


def test_a_recording_holds_the_vehicle_and_its_commands(run: Path) -> None:
    recording = VehicleRecording(run)
    assert [(command.time_ns, command.name, command.value) for command in recording.commands()] == [
        (80_000_000, "speed_kmh", 90.0),
        (80_000_000, "curvature", 0.001),
    ]
    assert [message.time_ns for message in recording.messages((VEHICLE_TRUTH,))] == [20_000_000 * k for k in range(10)]
    (description,) = (VehicleDescription.from_json(decode_text(m.data)) for m in recording.messages((VEHICLE_DESCRIPTION,)))
    assert description == described(vehicle_of(recording.parameters, "test"))
    assert [command.command for command in recording.boxes["axle_2.right"].commands()] == [ParameterChange({"faults.inner_1.width": 0.002})]


def test_a_recording_is_simulated_again_with_its_commands(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("simulate", "--from", str(run), "--quiet") == 0
    assert "the same samples in 4 boxes" in capsys.readouterr().out
    assert dcrb("simulate", "--from", str(run), "--quiet", "--json") == 0
    about = json.loads(capsys.readouterr().out)
    assert (about["recording"], about["simulated"]) == (None, 0.2)
    assert {box["samples"] for box in about["boxes"].values()} == {10240}
    assert about["boxes"].keys() == set(BOXES)
    assert dcrb("simulate", "--from", str(run / "axle_1.left"), "--quiet") == 2
    assert "is a box of the vehicle in" in capsys.readouterr().err


def test_a_recording_is_simulated_again_without_the_file_of_its_bench(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (bench,) = [path for path in shipped("configuration").values() if path.stem == "dry"]
    Path("my.yaml").write_text(bench.read_text())
    benches = ("--set", "vehicle.bench=my.yaml", "--set", "axle_1.left.faults.outer_1.width=0.003")
    assert dcrb("simulate", "--vehicle", "healthy_bogie", *benches, "-o", "run", "--duration", "0.04", "--quiet") == 0
    recording = VehicleRecording("run")
    again = VehicleReproduction(recording).simulation().vehicle
    assert again == vehicle_of(recording.parameters, "test")
    Path("my.yaml").unlink()
    capsys.readouterr()
    assert dcrb("simulate", "--from", "run", "--quiet") == 0
    assert "the same samples in 4 boxes" in capsys.readouterr().out


def test_commands_of_one_time_are_given_again_together_and_in_their_order() -> None:
    commands = [(1, "speed_kmh", 90.0), (2, "curvature", 0.009), (2, "wind", 1e5), (2, "axle_2.slide", 0.01), (2, "brake", 0.1)]
    given = list[dict[str, Any]]()
    simulation: Any = SimpleNamespace(command=lambda **values: given.append(values), change=given.append)
    give([VehicleCommand(*command) for command in commands], simulation)
    assert given == [{"speed_kmh": 90.0}, {"curvature": 0.009, "wind": 1e5}, {"axle_2.slide": 0.01}, {"brake": 0.1}]


def test_commands_that_are_possible_together_only_are_simulated_again(tmp_path: Path) -> None:
    """In a narrow curve the wind presses the vehicle to the inner side."""
    parameters = read_parameters("healthy_bogie", {**DRY, **NOTCH, "vehicle.speed_kmh": 120.0})
    simulation = VehicleSimulation(vehicle_of(parameters, "test"), threads=2)
    with VehicleRecorder(tmp_path / "bogie", parameters, simulation) as recorder:
        for number, block in enumerate(simulation.blocks(0.1)):
            recorder.write(block)
            if number == 1:
                with pytest.raises(Refusal, match="curvature"):
                    simulation.command(curvature=0.009)
                simulation.command(curvature=0.009, wind=1e5)
    assert dcrb("simulate", "--from", str(tmp_path / "bogie"), "--quiet") == 0


def test_commands_in_a_last_file_without_its_end_are_found(tmp_path: Path) -> None:
    parameters = read_parameters("healthy_bogie", {**DRY, **NOTCH, "recording.split_duration": 0.1})
    simulation = VehicleSimulation(vehicle_of(parameters, "test"), threads=2)
    with VehicleRecorder(tmp_path / "bogie", parameters, simulation) as recorder:
        for number, block in enumerate(simulation.blocks(0.2)):
            recorder.write(block)
            if number == 8:
                simulation.command(speed_kmh=90.0)
    last = VehicleRecording(tmp_path / "bogie").stored[-1].path
    assert last.name != "bogie_0.mcap"
    last.write_bytes(last.read_bytes().replace(b"dcrb_ros_vehicle_outcome", b"dcrb_ros_vehicle_out____"))
    assert [command.name for command in VehicleRecording(tmp_path / "bogie").commands()] == ["speed_kmh"]


def test_a_box_of_another_run_is_found_out(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reproduction = VehicleReproduction(VehicleRecording(run))
    monkeypatch.setattr(VehicleRecording, "commands", lambda self: [])
    for _ in reproduction.blocks(VehicleSimulation(vehicle_of(VehicleRecording(run).parameters, "test"))):
        pass
    with pytest.raises(NotReproduced, match=r"the samples of axle_1\.left, .* differ .*a command is missing"):
        reproduction.check()
    monkeypatch.setattr("dcrb_ros.recordings.vehicle.vehicle_fingerprint", lambda: "another")
    with pytest.raises(NotReproduced, match=r"the model of the vehicle was [0-9a-f]{16} and is another"):
        reproduction.check()


def test_changed_samples_of_a_box_are_compared_with_the_simulation(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flipped = altered(run / "axle_1.left", tmp_path / "flipped")
    assert dcrb("simulate", "--from", str(flipped), "--quiet") == 1
    said = capsys.readouterr().err
    assert f"{flipped / 'axle_1.left'}: the recording's samples do not match its own digest" in said
    assert "the simulation agrees with the stated digest" in said


def test_boxes_without_digests_and_with_altered_samples_are_named(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old = shutil.copytree(run, tmp_path / "old")
    (file,) = old.glob("*.mcap")
    file.write_bytes(file.read_bytes().replace(b"record_sha256", b"record_sha25_"))
    flipped = altered(run / "axle_1.left", tmp_path / "flipped")
    judged = SimpleNamespace(last=SimpleNamespace(time=0.0, indicators={}, boxes={}), damaged=(), statuses={}, history=())
    for bag, mismatch, unverified in ((run, False, False), (old, False, True), (flipped, True, False)):
        about = vehicle_as_object(VehicleRecording(bag), judged)  # type: ignore[arg-type]
        assert list(about["mismatch"] or ()) == list(BOXES) * mismatch
        assert list(about["unverified"] or ()) == list(BOXES) * unverified
        assert dcrb("info", str(bag), "--json") == 0
        boxes = json.loads(capsys.readouterr().out)["boxes"]
        assert [bool(box["unverified"]) for box in boxes.values()] == [unverified] * len(BOXES)
        assert dcrb("info", str(bag)) == 0
        assert ("axle_1.left: unverified: no digest in manifest and outcome record" in capsys.readouterr().out) is unverified


@pytest.mark.parametrize("command", ["plot", "export"])
def test_commands_for_a_bearing_name_a_box(run: Path, tmp_path: Path, command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb(command, str(run), "-o", str(tmp_path / ("a.png" if command == "plot" else "a.npz"))) == 2
    assert f"give one of its boxes, such as {run / 'axle_1.left'}" in capsys.readouterr().err


def test_a_box_that_is_not_there_is_refused(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("info", str(run / "axle_3.left")) == 2
    assert "there is no box axle_3.left" in capsys.readouterr().err
    assert dcrb("recover", str(run / "axle_1.left"), "-o", str(run.parent / "box")) == 2
    assert "is recovered as a whole" in capsys.readouterr().err


def test_the_contents_for_programs_have_the_sampling_rate_and_the_boxes(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("info", str(run), "--json") == 0
    about = json.loads(capsys.readouterr().out)
    assert about["sampling_rate"] == VehicleRecording(run).sampling_rate
    assert list(about["boxes"]) == list(VehicleRecording(run).boxes)


def test_changed_parameters_are_found_out(run: Path, tmp_path: Path) -> None:
    changed = tmp_path / "changed"
    shutil.copytree(run, changed)
    (file,) = changed.glob("*.mcap")
    data = file.read_bytes()
    assert data.count(b'"vehicle.speed_kmh": 100.0') == 1
    file.write_bytes(data.replace(b'"vehicle.speed_kmh": 100.0', b'"vehicle.speed_kmh": 101.0'))
    with pytest.raises(Refusal, match="their digest does not match"):
        VehicleRecording(changed)


def test_a_box_whose_record_is_lost_is_missed(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    damaged = tmp_path / "damaged"
    shutil.copytree(run, damaged)
    (file,) = damaged.glob("*.mcap")
    file.write_bytes(file.read_bytes().replace(b"dcrb_ros/axle_2.right", b"dcrb_r0s/axle_2.right"))
    for command in (("simulate", "--from"), ("detect",), ("info",)):
        assert dcrb(*command, str(damaged)) == 2
        assert "is damaged: it does not describe the box axle_2.right of its vehicle" in capsys.readouterr().err


def test_a_changed_record_of_a_box_is_named(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changed = tmp_path / "changed"
    shutil.copytree(run, changed)
    (file,) = changed.glob("*.mcap")
    whole = file.read_bytes()
    assert b'"frame": "axle_2/right/outer_ring"' in whole
    file.write_bytes(whole.replace(b'"frame": "axle_2/right/outer_ring"', b'"frame": "axle_2/right/outer_rung"'))
    for command in (("simulate", "--from", str(changed)), ("detect", str(changed)), ("info", str(changed / "axle_2.right"))):
        assert dcrb(*command) == 2
        assert f"{changed / 'axle_2.right'} cannot be read: {file.name}: the record dcrb_ros/axle_2.right" in capsys.readouterr().err


def test_a_box_that_is_a_path_out_of_the_recording_is_refused(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changed = tmp_path / "changed"
    shutil.copytree(run, changed)
    (file,) = changed.glob("*.mcap")
    file.write_bytes(file.read_bytes().replace(b"dcrb_ros/axle_2.right", b"dcrb_ros/../../../bag"))
    with pytest.raises(Refusal, match=r"\.\./\.\./\.\./bag is not the name of a box"):
        VehicleRecording(changed)
    for command in (("simulate", "--from"), ("detect",), ("info",), ("view", "--save", str(tmp_path / "view.rrd"))):
        assert dcrb(*command, str(changed)) == 2
        assert "../../../bag is not the name of a box" in capsys.readouterr().err


def test_a_box_that_the_vehicle_does_not_have_is_refused(run: Path, tmp_path: Path) -> None:
    (file,) = run.glob("*.mcap")
    records = {record.name: dict(record.metadata) for record in McapRecords(file, chunks=False) if isinstance(record, Metadata)}
    records["dcrb_ros/axle_3.left"] = records["dcrb_ros/axle_1.left"]
    Bag(tmp_path / "more", opening=records, closing=dict).close()
    with pytest.raises(Refusal, match=r"was changed: it describes the box axle_3\.left, which its vehicle does not have"):
        VehicleRecording(tmp_path / "more")


@pytest.mark.parametrize("name", ["a_0.mcap", "z_0.mcap"])
@pytest.mark.parametrize("vehicle", [True, False])
def test_a_file_of_another_recording_is_refused(
    run: Path, tmp_path: Path, name: str, vehicle: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    mixed, other = tmp_path / "mixed", tmp_path / "other"
    shutil.copytree(run, mixed)
    if vehicle:
        parameters = read_parameters("healthy_bogie", DRY)
        VehicleRecorder(other, parameters, VehicleSimulation(vehicle_of(parameters, "test"))).close()
    else:
        configuration = load_configuration("dry")
        Recorder(other, configuration, Simulation(configuration).bodies).close()
    (file,) = other.glob("*.mcap")
    shutil.copy(file, mixed / name)
    assert dcrb("simulate", "--from", str(mixed), "--quiet") == 2
    assert "has files of more than one recording" in capsys.readouterr().err


def test_the_files_of_a_split_recording_belong_together(tmp_path: Path) -> None:
    parameters = read_parameters("healthy_bogie", {**DRY, "recording.split_duration": 0.1})
    simulation = VehicleSimulation(vehicle_of(parameters, "test"), threads=2)
    with VehicleRecorder(tmp_path / "split", parameters, simulation) as recorder:
        for block in simulation.blocks(0.14):
            recorder.write(block)
    assert len(list((tmp_path / "split").glob("*.mcap"))) > 1
    assert VehicleRecording(tmp_path / "split").duration == pytest.approx(0.14, abs=1e-4)


def test_a_recording_that_was_cut_off_is_recovered_with_all_boxes(run: Path, tmp_path: Path) -> None:
    cut, whole = tmp_path / "cut", tmp_path / "whole"
    shutil.copytree(run, cut)
    (file,) = cut.glob("*.mcap")
    data = file.read_bytes()
    file.write_bytes(data[: int(0.7 * len(data))])
    assert dcrb("recover", str(cut), "-o", str(whole)) == 0
    assert VehicleRecording(cut).damage
    recording = VehicleRecording(whole)
    counts = {name: len(box.acceleration) for name, box in recording.boxes.items()}
    assert min(counts.values()) >= 1024
    for name, box in recording.boxes.items():
        count = counts[name]
        assert box.outcome is not None
        assert box.outcome["samples"] == count
        assert np.array_equal(box.acceleration, Recording(run / name).acceleration[:count])


def test_a_box_whose_manifest_is_damaged_is_recovered_without_an_outcome(run: Path, tmp_path: Path) -> None:
    broken, whole = shutil.copytree(run, tmp_path / "broken"), tmp_path / "whole"
    (file,) = broken.glob("*.mcap")
    data = file.read_bytes()
    place = data.index(b'"format": 2', data.index(b"dcrb_ros/axle_1.left"))
    file.write_bytes(data[:place] + b'"format": 3' + data[place + 11 :])
    assert dcrb("recover", str(broken), "-o", str(whole)) == 0
    records = {record.name for record in McapRecords(next(whole.glob("*.mcap")), chunks=False) if isinstance(record, Metadata)}
    assert [f"dcrb_ros_outcome/{name}" in records for name in BOXES] == [False, True, True, True]


def test_boxes_that_were_cut_off_between_two_blocks_are_simulated_again(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file ends after the fifth block of the first box, before those of the others."""
    cut = tmp_path / "cut"
    shutil.copytree(run, cut)
    (file,) = cut.glob("*.mcap")
    whole = file.read_bytes()
    for share in np.linspace(0.9, 0.1, 81):
        file.write_bytes(whole[: int(share * len(whole))])
        counts = [len(box.acceleration) for box in VehicleRecording(cut).boxes.values()]
        if min(counts) < max(counts):
            break
    assert 0 < min(counts) < max(counts)
    assert dcrb("simulate", "--from", str(cut), "--quiet") == 0
    assert "the same samples in 4 boxes" in capsys.readouterr().out


def test_a_replay_sends_the_blocks_of_all_boxes_together(run: Path) -> None:
    replay = Replay(ReplayParameters(bag=str(run)))
    assert {message.topic.name for message in replay.start()} == {
        *(f"{name.replace('.', '/')}/outer_ring/sensor" for name in BOXES),
        "/tf_static",
        "vehicle/description",
    }
    blocks = [[m.time_ns for m in bundle.messages if m.topic in replay.waveforms] for bundle in replay.bundles()]
    assert [times for times in blocks if times] == [[20_000_000 * k] * 4 for k in range(10)]


@pytest.mark.parametrize(("topics", "detected"), [("outer_ring/vibration", False), ("outer_ring/vibration, diagnosis", True)])
def test_recorded_verdicts_on_a_vehicle_are_replayed_with_those_on_its_boxes(run: Path, topics: str, detected: bool) -> None:
    """A comparing detector that listens to a replay without them publishes its own."""
    assert (VEHICLE_DIAGNOSIS in Replay(ReplayParameters(bag=str(run), topics=topics)).topics) is detected


def test_simulate_refuses_what_it_cannot_record(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("simulate", "dry", "--vehicle", "bogie") == 2
    assert dcrb("simulate", "--vehicle", "no_such_vehicle") == 2
    assert "there is no vehicle 'no_such_vehicle'" in capsys.readouterr().err
    (tmp_path / "there").mkdir()
    assert dcrb("simulate", "--vehicle", "healthy_bogie", "-o", str(tmp_path / "there"), "--duration", "0.2", "--quiet") == 2


@pytest.mark.parametrize(
    ("entry", "flaw"), [(b'"ended": "1', "is damaged: it does not have the form and the digest"), (b'#ended": "2', "is not valid JSON")]
)
def test_a_changed_outcome_is_reported_and_not_used(entry: bytes, flaw: str, run: Path, tmp_path: Path) -> None:
    changed = tmp_path / "changed"
    shutil.copytree(run, changed)
    (file,) = changed.glob("*.mcap")
    data = file.read_bytes()
    at = data.index(b'"ended": "2', data.index(b"dcrb_ros_vehicle_outcome"))
    file.write_bytes(data[:at] + entry + data[at + len(entry) :])
    assert VehicleRecording(run).damage == []
    recording = VehicleRecording(changed)
    assert any(f"vehicle_outcome {flaw}" in sentence for sentence in recording.damage)
    assert recording.commands() == VehicleRecording(run).commands()


@pytest.mark.parametrize("key", ["body.mass", "vehicle.speed_kmh", "axle_1.radius", "axle_1.left.bearing.pitch_radius"])
def test_a_whole_number_beyond_all_floats_is_refused(key: str) -> None:
    with pytest.raises(Refusal, match=r"= (9{400}|an integer of more than 300 digits) "):
        vehicle_of(read_parameters("healthy_bogie", {key: 10**400 - 1}), "mine.yaml")
