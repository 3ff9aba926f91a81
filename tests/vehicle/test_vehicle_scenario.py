"""Scenarios of a vehicle: the same at any block size, exact in time, and refused as a whole before the start."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from same_process import dcrb

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.simulation.scenario import read_scenario_file
from dcrb_ros.vehicle.description import Vehicle
from dcrb_ros.vehicle.file import read_parameters, vehicle_of
from dcrb_ros.vehicle.frame import FRAME
from dcrb_ros.vehicle.scenario import starting_parameters, vehicle_scenario
from dcrb_ros.vehicle.simulation import VehicleSimulation

DRY = {"vehicle.bench": "dry", "track.spectrum": "none", "track.roughness": -40.0}
GROWING = ("vehicle.cant", "axle_1.slide", *(f"axle_{axle}.{side}.wheel.flat" for axle in (1, 2) for side in ("left", "right")))
RIDE = """
start: {vehicle.speed_kmh: 72.0, axle_2.radius: 0.459}
timeline:
  - {at: 0.02, over: 0.1, set: {vehicle.speed_kmh: 73.0}}
  - {at: 0.03, set: {axle_2.slide: 0.05, axle_1.right.wheel.unbalance: 0.05}}
  - {at: 0.0411, set: {axle_1.left.faults.outer_1.width: 0.003}}
  - {at: 0.05, over: 0.04, set: {vehicle.curvature: 0.002}}
"""


def vehicle(**changes: Any) -> Vehicle:
    parameters = read_parameters("healthy_bogie", {**DRY, **{key.replace("__", "."): value for key, value in changes.items()}})
    return vehicle_of(starting_parameters(yaml.safe_load(RIDE), parameters, "ride.yaml"), "healthy_bogie")


@pytest.mark.slow
def test_a_scenario_is_exact_for_any_block_size() -> None:
    runs = []
    for size in (1024, 256):
        start = vehicle(**{f"axle_{axle}__{side}__publishing__block_size": size for axle in (1, 2) for side in ("left", "right")})
        simulation = VehicleSimulation(start, vehicle_scenario(yaml.safe_load(RIDE), start, "ride.yaml"))
        runs.append(list(simulation.blocks(0.16)))
    large, small = runs
    for name in large[0].boxes:
        one, two = (np.concatenate([block.boxes[name].acceleration for block in blocks]) for blocks in runs)
        assert np.array_equal(one, two)
    end = large[-1].truth
    assert end.speed == pytest.approx(73.0 / 3.6, rel=1e-9)
    curve = 5331.0 * end.speed**2 * 0.002  # 5.3 kN at 1 m/s^2 (spec T10)
    assert end.load["axle_1.right"] - end.load["axle_1.left"] == pytest.approx(2.0 * curve, rel=2e-3)
    assert end.creep["axle_2"] == pytest.approx(-0.05)
    onsets = [truth.faults["outer_1"]["onset"] for block in large for truth in block.boxes["axle_1.left"].truths if truth.faults]
    assert onsets[0] == pytest.approx(0.0411, abs=1e-5)
    assert not any(truth.faults for block in large for truth in block.boxes["axle_1.right"].truths)
    events = [event for block in small for event in block.truth.events]
    assert [(event.cause, event.box) for event in events] == [("slide", "axle_2")]
    assert events[0].time == pytest.approx(0.035, abs=1e-9)


def test_settings_are_at_whole_frames_and_the_speed_has_the_slope_of_its_duration() -> None:
    start = vehicle()
    scenario = vehicle_scenario(yaml.safe_load(RIDE), start, "ride.yaml")
    frame = FRAME / start.boxes[0].configuration.step_rate
    ramps = [(setting.frame * frame, setting.value) for setting in scenario.settings if setting.key == "vehicle.ramp"]
    assert np.array(ramps) == pytest.approx(np.array([(0.02, 1.0 / 3.6 / 0.1), (0.12, start.journey.ramp)]))
    curve = [setting for setting in scenario.settings if setting.key == "vehicle.curvature"]
    assert [setting.value for setting in curve] == pytest.approx(np.linspace(0.00025, 0.002, 8))
    assert [setting.frame for setting in scenario.settings] == sorted(setting.frame for setting in scenario.settings)
    assert list(scenario.boxes) == ["axle_1.left"]


def test_a_gradual_change_begins_at_the_speed_that_the_vehicle_has() -> None:
    """From 72 km/h on the way to 36 km/h at 0.5 m/s^2, 7.2 km/h are lost in 4 s; then 64.8 km/h are to be 36 km/h after 4 s."""
    start = vehicle(vehicle__ramp=0.5)
    entries = [{"at": 1.0, "set": {"vehicle.speed_kmh": 36.0}}, {"at": 5.0, "over": 4.0, "set": {"vehicle.speed_kmh": 36.0}}]
    scenario = vehicle_scenario({"timeline": entries}, start, "ride.yaml")
    ramps = [setting.value for setting in scenario.settings if setting.key == "vehicle.ramp"]
    assert ramps == pytest.approx([28.8 / 3.6 / 4.0, 0.5], rel=2e-3)


def test_a_gradual_change_ends_at_the_given_value() -> None:
    """0.7 + (0.1 - 0.7) is below 0.1, the least share of a worn flat."""
    worn = vehicle(axle_1__left__wheel__flat_worn=0.7)
    entries = [{"at": 0.01, "over": 0.02, "set": {"axle_1.left.wheel.flat_worn": 0.1}}]
    scenario = vehicle_scenario({"timeline": entries}, worn, "ride.yaml")
    assert [setting.value for setting in scenario.settings] == [*(pytest.approx(value) for value in (0.55, 0.4, 0.25)), 0.1]


@pytest.mark.parametrize("over", [0.002, 10.0])
def test_an_entry_that_keeps_the_speed_leaves_the_ramp_to_commands(over: float) -> None:
    entries = [{"at": 1.001, "over": over, "set": {"vehicle.speed_kmh": 72.0, "axle_2.slide": 0.1}}]
    settings = vehicle_scenario({"timeline": entries}, vehicle(), "ride.yaml").settings
    assert {setting.key for setting in settings} == {"vehicle.speed_kmh", "axle_2.slide"}
    assert settings[-1].value == 0.1


def test_a_level_of_a_healthy_box_keeps_the_speed_without_start() -> None:
    parameters = read_parameters("healthy_bogie", {"axle_1.left.structure.healthy_level": 1.0, "axle_1.creep": 0.001})
    tree = {"start": {"vehicle.speed_kmh": 18.0, "axle_1.creep": 0.0}}
    start = starting_parameters(tree, parameters, "ride.yaml")
    assert start["axle_1.left.structure.healthy_speed"] == pytest.approx(1.001 * 120.0 / 3.6 / 0.46)
    assert not any(key.endswith("right.structure.healthy_speed") for key in start)
    assert vehicle_of(start, "healthy_bogie").boxes[0].configuration.operating.speed == pytest.approx(18.0 / 3.6 / 0.46)
    assert starting_parameters(tree, start, "ride.yaml") == start
    stated = {"axle_1.left.structure.healthy_speed": 50.0}
    assert starting_parameters(tree, {**parameters, **stated}, "ride.yaml")["axle_1.left.structure.healthy_speed"] == 50.0


def test_the_truth_has_the_commands_at_the_start_of_its_block() -> None:
    start = vehicle()
    scenario = vehicle_scenario({"timeline": [{"at": 0.035, "set": {"vehicle.wind": 1e4}}]}, start, "ride.yaml")
    truths = [block.truth for block in VehicleSimulation(start, scenario).blocks(0.06)]
    assert [(truth.time_ns, truth.commanded["wind"]) for truth in truths] == [(0, 0.0), (20_000_000, 0.0), (40_000_000, 1e4)]


def test_a_curve_within_a_block_turns_the_vehicle_at_its_end() -> None:
    tree = {"timeline": [{"at": 0.03, "set": {"vehicle.curvature": 0.003}}]}
    simulation = VehicleSimulation(vehicle(), vehicle_scenario(tree, vehicle(), "ride.yaml"))
    assert [block.truth.curvature for block in simulation.blocks(0.06)] == [0.0, 0.003, 0.003]


def test_a_box_without_a_value_has_a_level_of_its_bench(tmp_path: Path) -> None:
    bench = tmp_path / "mine.yaml"
    bench.write_text("structure: {healthy_level: 1.0, housing: axle_box}\n", encoding="utf-8")
    parameters = {"vehicle.bench": str(bench), "axle_1.left": None, "axle_1.right": None}
    start = starting_parameters({"start": {"vehicle.speed_kmh": 18.0}}, parameters, "ride.yaml")
    levels = [box.configuration.model_dump()["structure"]["healthy_speed"] for box in vehicle_of(start, "own").boxes]
    assert levels == pytest.approx([vehicle_of(parameters, "own").boxes[0].configuration.operating.speed] * 2)


def test_the_start_replaces_parameters_of_the_vehicle() -> None:
    start = vehicle()
    assert start.journey.speed_kmh == 72.0
    assert start.axles[1].radius == 0.459


def test_a_command_that_lifts_a_box_in_a_later_curve_of_the_scenario_is_refused() -> None:
    start = vehicle(vehicle__ramp=3.0, body__mass=20000.0)
    curve = [{"at": 10.0, "set": {"vehicle.curvature": -0.01}}, {"at": 20.0, "set": {"vehicle.curvature": 0.0}}]
    simulation = VehicleSimulation(start, vehicle_scenario({"timeline": curve}, start, "ride.yaml"))
    sentence = r"^the scenario \(at 10 s\): speed_kmh = 72 km/h with curvature = -0\.01 1/m, wind = 100000 N loads axle_1\.right with -1\."
    with pytest.raises(Refusal, match=f"{sentence}.*; the previous commands remain in effect$"):
        simulation.command(wind=1e5)
    simulation.command(wind=1e4)
    simulation.command(speed_kmh=20.0)
    simulation.command(wind=1e5)  # the vehicle is slow when it reaches the curve


@pytest.mark.parametrize("start", [{"operating.speed_kmh": 20.0}, {"faults": {"outer_1": {"width": 0.002}}}])
def test_the_scenario_of_a_bearing_is_refused_by_its_name(start: dict[str, Any]) -> None:
    with pytest.raises(Refusal, match=r"ride.yaml is a scenario of a bearing, not of a vehicle: give one"):
        starting_parameters({"start": start, "timeline": []}, {}, "ride.yaml")


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ([{"at": 1.0, "set": {"speed_kmh": 80.0}}], "ride.yaml, entry 1: 'speed_kmh' names nothing: did you mean 'vehicle.speed_kmh'"),
        ([{"at": 1.0, "set": {"vehicle.speed": 80.0}}], "entry 1: there is no command 'speed'"),
        ([{"at": 1.0, "set": {"vehicle.speed_kmh": 800.0}}], "entry 1: speed_kmh = 800 km/h is outside 5 .. 300"),
        ([{"at": 1.0, "set": {"vehicle.brake": "full"}}], "entry 1: brake = 'full' is not a number"),
        ([{"at": 1.0, "over": 1.0, "set": {"vehicle.speed_kmh": 150.0}}], "would change by .* above 3 m/s"),
        ([{"at": 1.001, "over": 0.002, "set": {"vehicle.speed_kmh": 300.0}}], "would change by .* above 3 m/s"),
        ([{"at": 1.001, "over": 0.002, "set": {"axle_1.left.wheel.polygon": "3 1e-5"}}], "cannot change gradually"),
        (
            [{"at": 1.0, "set": {"axle_1.left.time_scale": 2.0}}],
            "entry 1: 'axle_1.left.time_scale' belongs to the whole vehicle: give time_s",
        ),
        ([{"at": 1.0, "set": {"track.roughness": 2.0}}], "entry 1: 'track.roughness' cannot change during a run: give it in the vehicle's"),
        ([{"at": 1.0, "set": {"axle_1.left.operating.speed": 80.0}}], "entry 1: .* belongs to the vehicle"),
        ([{"at": 1.0, "set": {"axle_3.slide": 0.1}}], "entry 1: .* names no box"),
        ([{"at": 1.0, "set": {"axle_2.slide": 0.9}}], "entry 1: axle_2.slide = 0.9 is outside"),
        (
            [{"at": 1.0, "set": {"axle_2.slide": "locked"}}],
            "entry 1: axle_2.slide = 'locked' is not a number: give it in shares of the speed",
        ),
        ([{"at": 1.0, "set": {"axle_1.left.sensor.swapped_with": "axle_2.left"}}], "cannot change during a run"),
        ([{"at": 1.0, "set": {"axle_1.left.faults.outer_1.widht": 0.1}}], r"entry 1, axle_1.left \(at 1 s\): .*widht"),
        ([{"at": 1.0, "set": {"axle_1.left.wheel.flat": 0.9}}], "entry 1: axle_1.left.wheel.*flat"),
        ([{"at": 1.0, "set": {"axle_1.left.wheel": 0.02}}], "entry 1: 'axle_1.left.wheel' is a group of parameters"),
        ([{"at": 1.0, "over": 1.0, "set": {"axle_1.left.wheel.polygon": "3 1e-5"}}], "cannot change gradually"),
        ([{"at": 1.0, "over": 2.0, "set": {"vehicle.cant": 0.1}}, {"at": 2.0, "set": {"vehicle.cant": 0.0}}], "another entry changes"),
        (
            [{"at": 1.0, "set": {"vehicle.speed_kmh": 150.0}}, {"at": 90.0, "set": {"vehicle.speed_kmh": 20.0, "vehicle.curvature": 0.01}}],
            r"entry 2 \(at 90 s\): speed_kmh = 150 km/h with curvature = 0.01 1/m loads axle_1.left with -",
        ),
        (
            [{"at": 0.0, "set": {"vehicle.curvature": 0.005}}, {"at": 1.0, "set": {"vehicle.speed_kmh": 200.0}}],
            r"entry 2 \(at 72\..* s\): speed_kmh = 200 km/h with curvature = 0.005",
        ),
        (
            [
                {"at": 0.0, "set": {"vehicle.curvature": 0.01}},
                {"at": 1.0, "over": 1000.0, "set": {"vehicle.curvature": 0.0}},
                {"at": 2.0, "set": {"vehicle.speed_kmh": 150.0}},
            ],
            r"entry 2 \(at .* s\): speed_kmh = 1.* km/h with curvature = 0.00.* loads axle_1.left with -",
        ),
        ([{"at": 1.0, "set": {}}], "entry 1: 'set' must name parameters"),
        ([{"at": 0.0, "over": 9e5, "set": dict.fromkeys(GROWING, 1e-3)}], "take 120000 steps, above 100000"),
        ([], "is not a scenario"),
    ],
)
def test_invalid_scenarios_are_refused_in_a_sentence(entries: list[Any], message: str) -> None:
    tree = {"timeline": entries} if entries else {}
    with pytest.raises(Refusal, match=message) as caught:
        vehicle_scenario(tree, vehicle(), "ride.yaml")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "entries",
    [
        [{"at": 1.0, "over": 100.0, "set": {"vehicle.speed_kmh": 150.0}}, {"at": 10.0, "set": {"vehicle.curvature": 0.003}}],
        [
            {"at": 1.0, "over": 100.0, "set": {"vehicle.speed_kmh": 200.0}},
            {"at": 200.0, "over": 100.0, "set": {"vehicle.speed_kmh": 40.0, "vehicle.curvature": 0.005}},
        ],
    ],
)
def test_a_curve_may_begin_while_the_speed_changes(entries: list[Any]) -> None:
    assert vehicle_scenario({"timeline": entries}, vehicle(), "ride.yaml").settings


def test_the_shipped_scenario_fits_its_vehicle() -> None:
    tree = read_scenario_file(Path("bogie_ride"))
    start = vehicle_of(starting_parameters(tree, read_parameters("healthy_bogie"), "bogie_ride"), "healthy_bogie")
    scenario = vehicle_scenario(tree, start, "bogie_ride")
    keys = {setting.key for setting in scenario.settings}
    assert keys >= {"vehicle.speed_kmh", "vehicle.brake", "axle_2.slide", "axle_2.left.wheel.flat"}
    assert list(scenario.boxes) == ["axle_1.left"]


@pytest.mark.slow
def test_a_recording_of_a_scenario_is_simulated_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, bag = tmp_path / "ride.yaml", tmp_path / "ride"
    file.write_text(RIDE)
    settings = [part for key, value in DRY.items() for part in ("--set", f"{key}={value}")]
    arguments = ["simulate", "--vehicle", "healthy_bogie", "--scenario", str(file), *settings]
    assert dcrb(*arguments, "-o", str(bag), "--duration", "0.1", "--quiet") == 0
    assert dcrb("simulate", "--from", str(bag), "--quiet") == 0
    assert "the same samples in 4 boxes" in capsys.readouterr().out
    file.write_text("timeline: [{at: 0.05, set: {axle_2.slid: 0.1}}]")
    assert dcrb(*arguments, "-o", str(tmp_path / "other"), "--duration", "0.1", "--quiet") == 2
    assert "'axle_2.slid' names no box; did you mean 'axle_2.slide'?" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()
