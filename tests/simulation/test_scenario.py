"""Scenarios: timelines in simulated time, exact to the step; invalid ones are refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import yaml
from same_process import dcrb

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.contacts.heights import unpacked
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import changed, load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import (
    ScheduledChange,
    first_step,
    read_scenario,
    read_scenario_file,
    scheduled_changes,
    starting_configuration,
)
from dcrb_ros.stream.block import Block, Truth
from dcrb_ros.stream.events import Refused, ScenarioEvent

SCENARIO = """
timeline:
  - at: 0.0301
    set: {operating.speed: 120.0, operating.load: 80000.0}
  - at: 0.05
    set:
      faults:
        outer_1: {width: 0.001, row: 1}
  - at: 0.06
    over: 0.2
    set: {faults.outer_1.width: 0.003}
  - at: 0.1
    set: {faults.broken_bars: row2/bar3, sensor.noise_density: 0.05}
  - at: 0.3
    set: {faults.outer_1.width: 0.0}
"""


def run(block_size: int, tmp_path: Path) -> list[Block]:
    path = tmp_path / "scenario.yaml"
    path.write_text(SCENARIO)
    configuration = Configuration.model_validate({"publishing": {"block_size": block_size}})
    return list(Simulation(configuration, read_scenario(path, configuration)).blocks(0.4))


def samples(blocks: list[Block]) -> npt.NDArray[np.float32]:
    return np.concatenate([np.column_stack([block.acceleration, block.shaft_angle]) for block in blocks])


def truths(blocks: list[Block]) -> list[Truth]:
    return [truth for block in blocks for truth in block.truths]


def test_a_scenario_is_exact_for_any_block_size(tmp_path: Path) -> None:
    one, other = run(1024, tmp_path), run(700, tmp_path)
    assert np.array_equal(samples(one), samples(other))
    assert truths(one) == truths(other)
    reported = {truth.time_ns: truth for truth in truths(one) if isinstance(truth.event, ScenarioEvent)}
    # The first step at or after the time; a step takes 1/102400 s.
    assert list(reported) == [-(-t * 102400 // 10**4) * 10**9 // 102400 for t in (301, 500, 1000, 1100, 2600, 3000)]
    assert reported[50_000_000].faults["outer_1"] == {"width": 0.001, "depth": 0.0003, "row": 1, "azimuth": 0.0, "onset": 0.05}
    assert reported[260_000_000].faults["outer_1"]["width"] == 0.003
    assert reported[260_000_000].faults["outer_1"]["onset"] == 0.05
    assert set(reported[300_000_000].faults) == {"broken_bars.row2/bar3"}
    growing = [truth.faults["outer_1"]["width"] for truth in truths(one) if 0.055e9 < truth.time_ns < 0.3e9 and not truth.event]
    assert growing == sorted(growing)
    assert truths(one)[-1].speed == pytest.approx(120.0)
    assert truths(one)[-1].load[1] == pytest.approx(-80e3)


def test_a_change_takes_effect_at_the_first_step_at_or_after_its_time() -> None:
    assert [first_step(t, 102400) for t in (0.0, 0.1, 1.0, 3600.0, 0.1 + 1e-17)] == [0, 10240, 102400, 368640000, 10240]
    assert first_step(0.100001, 102400) == 10241


@pytest.mark.parametrize(
    ("tree", "sentence"),
    [
        ([], "is not a scenario"),
        ({"timeline": {}}, "is not a scenario"),
        ({"timeline": [{"at": 1.0}]}, "entry 1: it must have 'at'"),
        ({"timeline": [{"at": 1.0, "sett": {}, "set": {"a": 1}}]}, "unknown key 'sett'; did you mean 'set'"),
        ({"timeline": [{"at": -1.0, "set": {"faults.outer_1.width": 0.001}}]}, r"at = -1.0 is not a simulated time within 0"),
        ({"timeline": [{"at": float("nan"), "set": {"faults.outer_1.width": 0.001}}]}, r"at = nan is not a simulated time"),
        ({"timeline": [{"at": "soon", "set": {"faults.outer_1.width": 0.001}}]}, r"at = 'soon' is not a simulated time"),
        ({"timeline": [{"at": 1.0, "set": {}}]}, "'set' must name parameters"),
        ({"timeline": [{"at": 1.0, "set": {"faults.outer_1.width": 1.0}}]}, r"at 1 s\): faults.outer_1.width = 1.0 m is outside"),
        ({"timeline": [{"at": 1.0, "set": {"operating.sped": 1.0}}]}, "did you mean 'operating.speed'"),
        ({"timeline": [{"at": 1.0, "set": {"bearing.rows": 1}}]}, "bearing.rows is fixed while the bench runs"),
        ({"timeline": [{"at": 1.0, "set": {"time_scale": 0.0}}]}, "time_scale cannot be set by a scenario"),
        ({"timeline": [{"at": 1.0, "over": 1.0, "set": {"operating.speed_ramp": 1.0}}]}, "cannot change gradually .* leave out 'over'"),
        (
            {"timeline": [{"at": 1.0, "over": 1e6, "set": {"operating.speed": 126.0}}]},
            "operating.speed_ramp = 3.3.*e-07 rad/s.2 is outside",
        ),
        (
            {"timeline": [{"at": 1.0, "set": {"operating.speed_kmh": "fast"}}]},
            r"operating.speed_kmh = 'fast' km/h is not a number within -1000",
        ),
        ({"timeline": [{"at": 1.0, "set": {"operating.speed_kmh": 9.0, "operating.speed": 1.0}}]}, "give one of them"),
        (
            {"timeline": [{"at": 1.0, "set": {"operating.speed": 9.0}}, {"at": 1.0, "set": {"operating.speed": 8.0}}]},
            "entry 2: it sets operating.speed to 8.0 at 1 s, and .*entry 1 to 9.0 in the same time step: leave out one of them",
        ),
        ({"timeline": [{"at": 1.0, "over": 1.0, "set": {"faults.outer_1.row": 1}}]}, "cannot change gradually .* leave out 'over'"),
        (
            {
                "timeline": [
                    {"at": 1.0, "set": {"faults.outer_1.width": 0.002}},
                    {"at": 1.0, "over": 4.0, "set": {"faults.outer_1.width": 0.01}},
                    {"at": 2.0, "set": {"faults.outer_2.width": 0.002, "faults.outer_2.azimuth": 0.04}},
                ]
            },
            r"at 5 s\): faults.outer_2 overlaps",
        ),
        (
            {
                "timeline": [
                    {"at": 0.0, "over": 10.0, "set": {"operating.speed": 200.0}},
                    {"at": 5.0, "over": 5.0, "set": {"operating.speed_kmh": 104.0}},
                ]
            },
            r"entry 2: it sets operating.speed at 5 s, which another entry changes from 0 s to 10 s; begin this one when",
        ),
        (
            {
                "timeline": [
                    {"at": 1.5, "set": {"faults.outer_1.width": 0.0}},
                    {"at": 1.0, "over": 1.0, "set": {"faults.outer_1.width": 0.002}},
                ]
            },
            r"entry 1: it sets faults.outer_1.width at 1.5 s, which another entry changes from 1 s to 2 s",
        ),
        (
            {
                "timeline": [
                    {"at": 1.0, "over": 1.0, "set": {"operating.load": 50000.0}},
                    {"at": 1.0, "over": 4.0, "set": {"operating.lateral_load": 10000.0}},
                ]
            },
            r"entry 2: it sets operating.load_ramp at 1 s, which another entry changes",
        ),
        (
            {"timeline": [{"at": 2.0, "set": {"faults.broken_bars": ""}}, {"at": 1.0, "set": {"faults.broken_bars": "row1/bar2"}}]},
            "does not heal",
        ),
    ],
)
def test_invalid_scenarios_are_refused(tree: Any, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        scheduled_changes(tree, Configuration(), "scenario.yaml")


@pytest.mark.parametrize("text", ["timeline: [", "\x00", "timeline:\n - at: 1\n   at: 2\n"])
def test_files_that_are_not_yaml_are_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_text(text)
    with pytest.raises(Refusal, match="is not valid YAML"):
        read_scenario(path, Configuration())


def test_a_scenario_change_that_conflicts_with_a_live_change_is_refused() -> None:
    configuration = Configuration()
    events = scheduled_changes(yaml.safe_load("timeline: [{at: 0.03, set: {faults.outer_1.width: 0.002}}]"), configuration, "scenario.yaml")
    simulation = Simulation(configuration, events)
    simulation.change({"faults.outer_2.width": 0.002})
    event = [truth.event for truth in truths(list(simulation.blocks(0.1))) if truth.event][-1]
    assert isinstance(event, Refused)
    assert event.request == ScenarioEvent({"faults.outer_1.width": 0.002})
    assert "faults.outer_2 overlaps faults.outer_1" in event.reason
    assert set(simulation.configuration.faults.described()) == {"outer_2"}


MOVING = """
timeline:
  - {{at: 0.0, set: {{faults.outer_1.width: 0.002, faults.outer_2.width: 0.002, faults.outer_2.azimuth: -0.1}}}}
  - {{at: {at}, over: {over}, set: {{faults.outer_2.azimuth: {to}}}}}
"""


@pytest.mark.parametrize(("over", "seconds"), [(2.0, r"1\.85"), (2000.0, r"8[12]\d\S*")])
def test_a_gradual_change_with_an_impossible_value_on_its_way_is_refused(over: float, seconds: str) -> None:
    tree = yaml.safe_load(MOVING.format(at=1.0, over=over, to=0.1))
    with pytest.raises(Refusal, match=rf"entry 2 \(at {seconds} s\): faults.outer_2 overlaps faults.outer_1"):
        scheduled_changes(tree, Configuration(), "scenario.yaml")
    assert scheduled_changes(yaml.safe_load(MOVING.format(at=1.0, over=over, to=-0.3)), Configuration(), "scenario.yaml")


def test_another_entry_may_make_the_way_impossible() -> None:
    tree = yaml.safe_load(MOVING.format(at=1.0, over=4.0, to=0.1))
    narrow = {"at": 0.5, "set": {"faults.outer_1.width": 0.0}}
    scheduled_changes({"timeline": [*tree["timeline"], narrow]}, Configuration(), "scenario.yaml")
    back = {"at": 3.0, "set": {"faults.outer_1.width": 0.002}}
    with pytest.raises(Refusal, match=r"entry 4 \(at 3 s\): faults.outer_2 overlaps faults.outer_1"):
        scheduled_changes({"timeline": [*tree["timeline"], narrow, back]}, Configuration(), "scenario.yaml")


def test_every_step_of_a_gradual_change_that_a_live_change_makes_impossible_is_reported() -> None:
    configuration = Configuration.model_validate({"cage": {"joint": "revolute"}})
    tree = yaml.safe_load("timeline: [{at: 0.02, over: 0.2, set: {faults.outer_1.width: 0.002}}]")
    simulation = Simulation(configuration, scheduled_changes(tree, configuration, "scenario.yaml"))
    simulation.change({"faults.outer_2.width": 0.002})
    refused = [truth.event for truth in truths(list(simulation.blocks(0.24))) if isinstance(truth.event, Refused)]
    assert [event.request.changes["faults.outer_1.width"] for event in refused if isinstance(event.request, ScenarioEvent)] == [
        pytest.approx(width) for width in (0.002, 0.001, 0.0015, 0.002)
    ]


def test_a_shipped_scenario_is_found_by_name() -> None:
    events = read_scenario(Path("growing_spall"), load_configuration("healthy"))
    assert events[-1].event == ScenarioEvent({"faults.broken_bars": "row2/bar3"})
    with pytest.raises(Refusal, match=r"there is no scenario 'growing_spal': .* did you mean 'growing_spall'\?"):
        read_scenario(Path("growing_spal"), Configuration())


def test_simulate_applies_a_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    from dcrb_ros.messages.statuses import decode_truth
    from dcrb_ros.messages.topics import GROUND_TRUTH
    from dcrb_ros.recordings.reader import Recording

    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(SCENARIO)
    assert dcrb("simulate", "dry", "--scenario", str(scenario), "--duration", "0.2", "-o", str(tmp_path / "bag")) == 0
    last = [decode_truth(message.data) for message in Recording(tmp_path / "bag").messages((GROUND_TRUTH,))][-1]
    assert set(last.faults) == {"outer_1", "broken_bars.row2/bar3"}
    scenario.write_text("timeline: [{at: 1.0, set: {bearing.rows: 1}}]")
    assert dcrb("simulate", "dry", "--scenario", str(scenario), "-o", str(tmp_path / "none")) == 2
    assert "bearing.rows is fixed while the bench runs" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()


BENCHES = [f"{name} {bench}" for name in ("simulate", "bench") for bench in ("healthy", "--vehicle healthy_bogie")]


@pytest.mark.parametrize("command", BENCHES)
def test_a_scenario_that_changes_nothing_in_the_run_is_refused(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario, record = tmp_path / "late.yaml", "-o" if command.startswith("simulate") else "--record"
    scenario.write_text(f"timeline: [{{at: 0.2, set: {{{'vehicle.brake: 1.0' if 'vehicle' in command else 'operating.load: 9e4'}}}}}]")
    assert dcrb(*command.split(), "--scenario", str(scenario), "--duration", "0.2", record, str(tmp_path / "bag")) == 2
    assert "late.yaml changes nothing in a run of 0.2 s, its first entry is at 0.2 s: increase --duration" in capsys.readouterr().err
    scenario.write_text("timeline: []")
    assert dcrb(*command.split(), "--scenario", str(scenario), "--duration", "0.2", record, str(tmp_path / "bag")) == 2
    assert "late.yaml changes nothing: it has no 'start', and its timeline has no entry; give one, or" in capsys.readouterr().err
    assert not (tmp_path / "bag").exists()


@pytest.mark.parametrize("command", BENCHES)
@pytest.mark.parametrize("content", ["", "{}"])
def test_a_scenario_without_entries_is_refused(content: str, command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario = tmp_path / "empty.yaml"
    scenario.write_text(content)
    assert dcrb(*command.split(), "--scenario", str(scenario), "--duration", "0.2") == 2
    sentence = "empty.yaml is not a scenario: give" if content == "{}" else "empty.yaml changes nothing: it has no 'start'"
    assert sentence in capsys.readouterr().err


SHIPPED = sorted((Path(__file__).parents[2] / "config" / "scenarios").glob("*.yaml"))
PROFILES = [path for path in SHIPPED if not path.stem.startswith("bogie")]
"""Those of a bench; tests/vehicle has the others."""


@pytest.mark.parametrize("profile", PROFILES, ids=lambda path: path.stem)
def test_shipped_scenarios_are_valid_for_the_default_bench(profile: Path) -> None:
    assert read_scenario(Path(profile.stem), load_configuration("healthy"))


def truths_of(text: str, seconds: float, **operating: float) -> list[Truth]:
    configuration = Configuration.model_validate(
        {"cage": {"joint": "revolute"}, "operating": operating, "publishing": {"truth_rate": 100, "block_size": 512}}
    )
    events = scheduled_changes(yaml.safe_load(text), configuration, "scenario.yaml")
    return truths(list(Simulation(configuration, events).blocks(seconds)))


def test_a_gradual_change_takes_its_duration_and_restores_the_previous_ramp() -> None:
    text = """
timeline:
  - {at: 0.05, over: 0.1, set: {operating.speed_kmh: 180.0}}
  - {at: 0.15, over: 0.1, set: {operating.load: 80000.0, operating.lateral_load: 10000.0}}
  - {at: 0.25, set: {operating.speed: 110.0}}
"""
    found = truths_of(text, 0.3, speed=100.0)
    reached = 180.0 / 3.6 / 0.46
    by_time = {truth.time_ns: truth for truth in found}
    assert by_time[100_000_000].speed == pytest.approx(100.0 + 0.5 * (reached - 100.0), abs=0.01)
    assert by_time[150_000_000].speed == pytest.approx(reached, abs=0.01)
    assert by_time[200_000_000].load == pytest.approx((10000.0, -90000.0), rel=1e-3)
    assert by_time[230_000_000].load == pytest.approx((10000.0, -84000.0), rel=1e-3)
    assert by_time[270_000_000].speed == pytest.approx(reached + 50.0 * 0.02, abs=0.01)
    assert [truth.event for truth in found if truth.event][1] == ScenarioEvent({"operating.speed": reached}, over=0.1)


def test_a_whole_number_changes_gradually_as_the_same_decimal_number() -> None:
    def changes(speed: float, level: float) -> list[ScheduledChange]:
        values = {"operating.speed": speed, "background.joint_level": level}
        tree = {"timeline": [{"at": 1, "over": 1, "set": values}]}
        return scheduled_changes(tree, Configuration(), "scenario")

    assert changes(50, 2) == changes(50.0, 2.0)
    assert all(type(value) is float for change in changes(50, 2) for value in change.changes.values())


def test_adjacent_entries_follow_each_other() -> None:
    text = """
timeline:
  - {at: 0.1, over: 0.2, set: {faults.outer_1.width: 0.002, operating.speed: 120.0}}
  - {at: 0.1, set: {faults.outer_1.width: 0.001}}
  - {at: 0.3, over: 0.3, set: {faults.outer_1.width: 0.004, operating.speed: 100.0}}
  - {at: 0.6, set: {faults.outer_1.width: 0.0}}
"""
    events = scheduled_changes(yaml.safe_load(text), Configuration.model_validate({"operating": {"speed": 110.0}}), "scenario.yaml")
    widths = [event.changes["faults.outer_1.width"] for event in events if "faults.outer_1.width" in event.changes]
    # 0.1 + 0.2 is a little above 0.3; they are one step.
    assert widths == pytest.approx([0.001, 0.00125, 0.0015, 0.00175, 0.002, *np.arange(0.0024, 0.0041, 0.0004), 0.0], abs=1e-9)
    slopes = [event.changes["operating.speed_ramp"] for event in events if "operating.speed" in event.changes]
    assert slopes == pytest.approx([50.0, 20.0 / 0.3])


def test_a_reversal_passes_through_standstill() -> None:
    found = truths_of("timeline: [{at: 0.02, over: 0.2, set: {operating.speed: -4.0}}]", 0.25, speed=4.0)
    speeds = [truth.speed for truth in found]
    assert (speeds[0], speeds[-1]) == (4.0, -4.0)
    assert min(np.abs(speeds)) < 0.2


def test_a_shipped_profile_runs() -> None:
    own, profile = Configuration.model_validate({"cage": {"joint": "revolute"}}), Path("run_up")
    configuration = starting_configuration(read_scenario_file(profile), own, "run_up")
    found = truths(list(Simulation(configuration, read_scenario(profile, own)).blocks(2.3)))
    slope = (160.0 - 20.0) / 3.6 / 0.46 / 40.0
    last = found[-1]
    assert last.speed == pytest.approx(20.0 / 3.6 / 0.46 + slope * (last.time_ns * 1e-9 - 2.0), abs=0.01)


def test_sensor_and_background_follow_a_scenario_and_only_the_sensor_fault_is_a_fault() -> None:
    text = """
timeline:
  - {at: 0.02, set: {background.hum_level: 2.0, background.unbalance: 0.0001}}
  - {at: 0.04, set: {sensor.fault: stuck, sensor.fault_axis: x}}
  - {at: 0.06, set: {sensor.fault: none, background.hum_level: 0.0}}
"""
    found = {truth.time_ns: truth for truth in truths_of(text, 0.08)}
    assert found[30_000_000].background == {"unbalance": 0.0001, "hum_level": 2.0}
    assert found[30_000_000].faults == {}
    assert found[50_000_000].faults == {"sensor.stuck": {"severity": 1.0, "axis": 1, "onset": 0.04}}
    assert (found[70_000_000].faults, found[70_000_000].background) == ({}, {"unbalance": 0.0001})


@pytest.mark.parametrize(
    ("start", "sentence"),
    [
        ([1], "'start' must name parameters"),
        ({"simulation.seed": 3}, "simulation.seed cannot be set by a scenario; give keys of operating"),
        ({"vehicle.speed_kmh": 80.0}, "scenario.yaml is a scenario of a vehicle: it needs --vehicle"),
        ({"operating.sped": 3.0}, "unknown parameter 'operating.sped'; did you mean 'operating.speed'"),
        ({"operating": {"speed_kmh": 5000.0}}, r"operating.speed_kmh = 5000.0 km/h is outside -1000"),
        ({"operating.load": 5e6}, "operating.load = .* presses the rings .* towards each other"),
    ],
)
def test_invalid_starts_are_refused(start: Any, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        starting_configuration({"start": start, "timeline": []}, Configuration(), "scenario.yaml")


def test_a_scenario_may_start_with_a_preset() -> None:
    start = {"sensor": {"preset": "mems", "adc_bits": 12}}
    sensor = starting_configuration({"start": start, "timeline": []}, Configuration(), "scenario.yaml").sensor
    assert (sensor.preset, sensor.white_noise_ug, sensor.adc_bits) == ("mems", 30.0, 12)


def test_a_start_may_change_the_wheels_and_give_the_speed_on_them() -> None:
    start = {"operating": {"wheel_diameter": 1.0, "speed_kmh": 72.0}}
    assert starting_configuration({"start": start}, Configuration(), "scenario.yaml").operating.speed == 40.0  # 20 m/s over 0.5 m
    standing = {"operating": {"speed_kmh": 0.0}}
    assert starting_configuration({"start": standing}, Configuration(), "scenario.yaml").operating.speed == 0.0


@pytest.mark.parametrize("excess", [0, 1])
def test_the_number_of_entries_is_limited(excess: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dcrb_ros.simulation.scenario.MAX_ENTRIES", 3)
    tree = {"timeline": [{"at": 0.1 * k, "set": {"operating.speed": 100.0}} for k in range(3 + excess)]}
    if excess:
        with pytest.raises(Refusal, match=r"scenario\.yaml has 4 entries; a scenario has at most 3"):
            scheduled_changes(tree, Configuration(), "scenario.yaml")
    else:
        assert len(scheduled_changes(tree, Configuration(), "scenario.yaml")) == 3


@pytest.mark.parametrize("excess", [0, 1])
def test_the_steps_of_all_gradual_changes_are_limited(excess: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dcrb_ros.simulation.scenario.MAX_CHANGES", 30)
    growths = [
        {"at": 0.0, "over": 1.0 + 0.05 * excess, "set": {"faults.outer_1.width": 0.002}},
        {"at": 0.0, "over": 0.5, "set": {"faults.inner_1.width": 0.002}},
        {"at": 0.0, "over": 100.0, "set": {"operating.speed": 130.0}},  # a ramp takes no steps
    ]
    if excess:
        with pytest.raises(Refusal, match=r"take 31 steps of 0\.05 s or longer; a scenario has at most 30: shorten them"):
            scheduled_changes({"timeline": growths}, Configuration(), "scenario.yaml")
    else:
        assert len(scheduled_changes({"timeline": growths}, Configuration(), "scenario.yaml")) == 30 + 2


def test_a_later_entry_replaces_a_live_command_or_change() -> None:
    """As stated on the page of scenario files."""
    tree = yaml.safe_load("""
timeline:
  - {at: 0.05, set: {operating.speed: 110.0}}
  - {at: 0.03, over: 0.12, set: {faults.outer_1.width: 0.003}}
""")
    configuration = Configuration.model_validate({"publishing": {"truth_rate": 100}, "operating": {"speed_ramp": 1000.0}})
    simulation = Simulation(configuration, scheduled_changes(tree, configuration, "scenario.yaml"))
    truth = {}
    for block in simulation.blocks(0.2):
        truth |= {round(truth.time_ns * 1e-7): (truth.speed, truth.faults.get("outer_1", {}).get("width", 0.0)) for truth in block.truths}
        if block.index == 0:
            simulation.command_speed(130.0)
        elif block.index == 4 * 1024:
            simulation.change({"faults.outer_1.width": 0.0005})
    speed, width = ({hundredths: values[k] for hundredths, values in truth.items()} for k in range(2))
    assert (speed[4], speed[8], speed[19]) == pytest.approx((130.0, 110.0, 110.0))
    assert (width[9], width[12], width[16]) == pytest.approx((0.0015, 0.0005, 0.003))


def test_a_change_that_takes_most_of_an_hour_is_planned() -> None:
    entries = [{"at": 0.0, "over": 3000.0, "set": {"operating.speed": 126.0, "operating.load": 100500.0}}]
    first, *_ = scheduled_changes({"timeline": entries}, load_configuration("healthy"), "slow")
    assert first.changes["operating.speed_ramp"] == pytest.approx(0.336 / 3000.0)
    assert first.changes["operating.load_ramp"] == pytest.approx(500.0 / 3000.0)


@pytest.mark.parametrize("command", [{"operating.load": 100.0}, {"operating.speed": 60.0}])
def test_a_defect_after_another_load_or_speed_leaves_the_preload_of_the_assembly(command: dict[str, float]) -> None:
    """The onset of a defect of 10 um that no ball touches has no impact; the rings jumped by the change of the interference."""
    bench = load_configuration("ball_bearing_6205", {"impacts.axial_share": 0.3})
    timeline = [{"at": 0.01, "set": command}, {"at": 0.05, "set": {"faults.outer_1.width": 1e-5, "faults.outer_1.azimuth": 1.57}}]
    simulation = Simulation(bench, scheduled_changes({"timeline": timeline}, bench, "assembly"), waveform_only=True)
    list(simulation.blocks(0.04))
    before = simulation._payload
    list(simulation.blocks(0.02))
    assert simulation._payload is not before
    after, assembled = (np.median(unpacked(payload.surfaces.raceways)[0][1]) for payload in (simulation._payload, build_payload(bench)))
    assert after == assembled


def test_a_defect_at_a_higher_speed_than_the_start_has_errors_of_times_of_that_speed() -> None:
    errors = {"impacts.time_spread": 1e-4, "operating.speed_ramp": 1e5}
    timeline = [{"at": 0.01, "set": {"operating.speed": 600.0}}, {"at": 0.03, "set": {"faults.outer_1.width": 0.001}}]
    slow, fast = (load_configuration("ball_bearing_6205", {**errors, "operating.speed": speed}) for speed in (100.0, 600.0))
    simulation = Simulation(slow, scheduled_changes({"timeline": timeline}, slow, "errors"), waveform_only=True)
    list(simulation.blocks(0.04))
    damaged = build_payload(changed(fast, {"faults.outer_1.width": 0.001}, "fast"))
    assert simulation._payload.surfaces.reach.tolist() == damaged.surfaces.reach.tolist()
