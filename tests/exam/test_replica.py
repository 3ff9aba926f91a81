"""Replicas of measured recordings: made from the table alone, deterministic, and of the same shape."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from same_process import dcrb

from dcrb_ros.bearing.frequencies import Orders, characteristic_orders
from dcrb_ros.exam.exam_file import LARGEST_EXAM, MOST_CASES, exam_of, read_exam
from dcrb_ros.exam.kinds import read_any_exam
from dcrb_ros.exam.replica import ReplicaPlan, replica_tree
from dcrb_ros.exam.replica_geometry import bearing_settings, geometry_of, longest_step
from dcrb_ros.exam.replica_priors import PRIORS, described, drawn, generator_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings import step_limits
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.measured_rate import rates
from dcrb_ros.text.files import LARGEST_TEXT
from dcrb_ros.text.yaml import yaml_text

ORDERS = {"FTF": "0.39828", "BPFO": "3.5848", "BPFI": "5.4152", "BSF": "2.35695"}
"""Of the 6205 of Case Western Reserve, as in its publication."""
ROWS = (("calm_1", "healthy", 1800), ("calm_2", "healthy", 1200), ("outer_1", "outer_ring", 1800), ("outer_2", "outer_ring", 1200))
PLAN = ReplicaPlan(machines=4, counterparts=2, longest=2.0, without=("background",))
"""Without a background no level is simulated."""


def table(folder: Path, rows: Any = ROWS, **changes: str) -> Path:
    """Write a table without any recording."""
    written = [
        {"name": name, "rig": "bench12", "truth": truth, "sampling_rate": "12000", "unit": "g", "speed_rpm_documented": f"{rpm}"}
        | {"speed_rpm_from_lines": f"{rpm}", "seconds": "10", **ORDERS}
        | changes
        for name, truth, rpm in rows
    ]
    with (folder / "recordings.csv").open("w", newline="") as stream:
        writer = csv.DictWriter(stream, list(written[0]))
        writer.writeheader()
        writer.writerows(written)
    return folder / "recordings.csv"


def test_a_replica_needs_no_recording_and_has_the_shape_of_the_table(tmp_path: Path) -> None:
    tree = replica_tree(table(tmp_path), PLAN)
    assert not (tmp_path / "recordings").exists()
    by_recording: dict[str, list[dict[str, Any]]] = {}
    for scenario in tree["scenarios"]:
        by_recording.setdefault(scenario["tags"]["recording"], []).append(scenario)
    assert {name: len(found) for name, found in by_recording.items()} == {"calm_1": 4, "calm_2": 4, "outer_1": 2, "outer_2": 2}
    for name, truth, rpm in ROWS:
        for scenario in by_recording[name]:
            assert (scenario["verdict"], scenario["duration"]) == (truth, 2.0)
            assert scenario["set"]["operating.speed"] == pytest.approx(rpm * math.pi / 30.0)
            assert scenario["set"]["sensor.sampling_rate"] == 12000
            assert any(key.startswith("faults.outer_1") for key in scenario["set"]) == (truth == "outer_ring")
    faulty = [scenario["tags"]["machine"] for scenario in tree["scenarios"] if scenario["verdict"] == "outer_ring"]
    assert sorted(faulty) == [f"bench#{k}" for k in range(1, 5)]


def test_the_recordings_of_a_machine_have_one_rate(tmp_path: Path) -> None:
    given_table = table(tmp_path, ROWS, machine="m")
    text = given_table.read_text().replace("calm_1,bench12,healthy,12000", "calm_1,bench48,healthy,48000")
    given_table.write_text(text)
    scenarios = replica_tree(given_table, PLAN)["scenarios"]
    assert {scenario["set"]["sensor.sampling_rate"] for scenario in scenarios} == {12000}


def test_a_replica_is_an_exam_and_the_same_for_the_same_seed(tmp_path: Path) -> None:
    given_table = table(tmp_path)
    first, second = replica_tree(given_table, PLAN), replica_tree(given_table, PLAN)
    assert yaml.safe_dump(first) == yaml.safe_dump(second)
    assert len(exam_of(first, "replica").cases) == 12
    other = replica_tree(given_table, ReplicaPlan(seed=2, machines=4, counterparts=2, longest=2.0, without=("background",)))
    assert all(a["set"] != b["set"] for a, b in zip(first["scenarios"], other["scenarios"], strict=True))


def test_a_replica_is_called_after_the_folder_of_its_table_wherever_the_command_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rigs").mkdir()
    table(tmp_path / "rigs")
    monkeypatch.chdir(tmp_path / "rigs")
    assert replica_tree(Path("recordings.csv"), PLAN)["exam"] == "replica of rigs"


def test_what_belongs_to_a_machine_and_a_bearing_is_drawn_once(tmp_path: Path) -> None:
    rows = [(f"outer_{k}", "outer_ring", 1200 + 300 * k) for k in range(3)]
    tree = replica_tree(table(tmp_path, rows), ReplicaPlan(machines=3, counterparts=3, without=("background",)))
    for machine in ("bench#1", "bench#2", "bench#3"):
        sets = [scenario["set"] for scenario in tree["scenarios"] if scenario["tags"]["machine"] == machine]
        for key in ("faults.outer_1.width", "surfaces.seed", "structure.seed", "structure.mounting", "operating.load"):
            assert len({one[key] for one in sets}) == 1
        assert len({one["operating.speed"] for one in sets}) == 3
    assert len({scenario["set"]["faults.outer_1.width"] for scenario in tree["scenarios"]}) == 3


def test_every_bearing_of_a_machine_is_mounted_anew(tmp_path: Path) -> None:
    rows = [("outer_1", "outer_ring", 1200), ("inner_1", "inner_ring", 1200), ("calm_1", "healthy", 1200), ("calm_2", "healthy", 1500)]
    tree = replica_tree(table(tmp_path, rows), ReplicaPlan(machines=1, counterparts=1, without=("background",)))
    sets = {scenario["name"]: scenario["set"] for scenario in tree["scenarios"]}
    assert len({one["structure.seed"] for one in sets.values()}) == 1
    assert len({one["structure.mounting"] for one in sets.values()}) == 3
    assert sets["calm_1/1"]["structure.mounting"] == sets["calm_2/1"]["structure.mounting"]


def test_leaving_a_part_out_changes_nothing_else(tmp_path: Path) -> None:
    given_table = table(tmp_path)
    with_path = replica_tree(given_table, PLAN)["scenarios"]
    for part in ("path", "impacts"):
        without = replica_tree(given_table, ReplicaPlan(machines=4, counterparts=2, longest=2.0, without=("background", part)))["scenarios"]
        gone = {key for a, b in zip(with_path, without, strict=True) for key in set(a["set"]) - set(b["set"])}
        assert gone
        of_path = ("structure.housing", "structure.seed", "structure.mounting")
        assert all(key.startswith(of_path if part == "path" else "impacts.") for key in gone)
        assert all(a["set"].items() >= b["set"].items() for a, b in zip(with_path, without, strict=True))


def test_columns_of_the_table_replace_what_is_drawn(tmp_path: Path) -> None:
    tree = replica_tree(table(tmp_path, gain="known", load="333", pitch_diameter_mm="50", seconds="1.5"), PLAN)
    sets = [scenario["set"] for scenario in tree["scenarios"]]
    assert {(one["structure.gain_y"], one["operating.load"], one["bearing.pitch_radius"]) for one in sets} == {(1.0, 333.0, 0.025)}
    # A measured healthy recording of 1.5 s leaves half of its length after the healthy signal.
    assert {scenario["duration"] for scenario in tree["scenarios"]} == {0.75}
    unknown = replica_tree(table(tmp_path, gain="unknown"), PLAN)
    gains = {(one["tags"]["machine"], one["tags"]["recording"][:-2]): one["set"]["structure.gain_y"] for one in unknown["scenarios"]}
    assert len(set(gains.values())) == len(gains) == 8
    # An amplifier is set when a bearing is mounted, so all recordings of a bearing on a machine have its gain.
    for scenario in unknown["scenarios"]:
        assert scenario["set"]["structure.gain_y"] == gains[scenario["tags"]["machine"], scenario["tags"]["recording"][:-2]]


def test_the_orders_of_known_bearings_give_their_geometry() -> None:
    ball, roller = geometry_of(Orders(0.39828, 3.5848, 5.4152, 2.35695)), geometry_of(Orders(0.443, 7.09, 8.91, 4.20))
    assert (ball.elements, ball.contact_angle) == (9, 0.0)
    assert ball.ratio == pytest.approx(7.94 / 39.04, rel=2e-3)
    # Rexnord ZA-2115: 16 rollers of 8.407 mm on 71.501 mm at 15.17 degrees.
    assert roller.elements == 16
    assert roller.ratio == pytest.approx(8.407 / 71.501, rel=5e-3)
    assert math.degrees(roller.contact_angle) == pytest.approx(15.17, abs=1.0)


@settings(deadline=None)
@given(st.integers(6, 30), st.floats(0.08, 0.35), st.floats(0.1, 0.7))
def test_the_geometry_is_that_which_makes_the_orders(elements: int, ratio: float, angle: float) -> None:
    assume(ratio * elements < 3.0)
    gamma = ratio * math.cos(angle)
    orders = Orders(0.5 * (1 - gamma), 0.5 * elements * (1 - gamma), 0.5 * elements * (1 + gamma), (1 - gamma**2) / (2 * ratio))
    found = geometry_of(orders)
    assert found.elements == elements
    assert found.ratio == pytest.approx(ratio)
    assert found.contact_angle == pytest.approx(angle, abs=1e-6)


@settings(deadline=None)
@given(
    elements=st.integers(6, 40),
    filling=st.floats(0.5, 0.9),
    angle=st.sampled_from([0.0, 0.1, 0.26, 0.7]),
    pitch=st.none() | st.floats(0.02, 0.3),
    rate=st.sampled_from([8192, 12000, 20000, 48828, 51200, 97656]),
)
def test_every_usual_bearing_is_a_valid_bench_with_the_orders_of_the_table(
    elements: int, filling: float, angle: float, pitch: float | None, rate: int
) -> None:
    ratio = min(0.4, filling * math.sin(math.pi / elements))
    gamma = ratio * math.cos(angle)
    orders = Orders(0.5 * (1 - gamma), 0.5 * elements * (1 - gamma), 0.5 * elements * (1 + gamma), (1 - gamma**2) / (2 * ratio))
    bench = load_configuration("ball_bearing_6205")
    bearing = bearing_settings(geometry_of(orders), bench, pitch)
    scaled = load_configuration("ball_bearing_6205", {**bearing, **rates(rate, longest_step(bearing, bench))})
    assert characteristic_orders(scaled.bearing).as_dict() == pytest.approx(orders.as_dict(), rel=1e-6)
    assert scaled.bearing.pitch_radius == pytest.approx(pitch) if pitch else scaled.bearing.pitch_radius >= bench.bearing.pitch_radius


def test_loads_and_widths_of_defects_grow_with_a_bearing_of_stated_size(tmp_path: Path) -> None:
    trees = [replica_tree(table(tmp_path, pitch_diameter_mm=pitch), PLAN) for pitch in ("39.04", "195.2")]
    for small, large in zip(*(tree["scenarios"] for tree in trees), strict=True):
        assert large["set"]["operating.load"] == pytest.approx(25.0 * small["set"]["operating.load"])
        if small["verdict"] == "outer_ring":
            assert large["set"]["faults.outer_1.width"] == pytest.approx(5.0 * small["set"]["faults.outer_1.width"])


@pytest.mark.parametrize("load", ["500", "5000", "12000", "26690"])
def test_a_heavier_load_makes_the_step_shorter_where_it_must(load: str, tmp_path: Path) -> None:
    """Of the accelerated life tests of XJTU-SY and IMS, with 12 and 27 kN on bearings of some 70 mm."""
    scenarios = replica_tree(table(tmp_path, load=load, sampling_rate="25600"), PLAN)["scenarios"]
    step = scenarios[0]["set"]["simulation.step"]
    bench = load_configuration("ball_bearing_6205")
    assert {scenario["set"]["operating.load"] for scenario in scenarios} == {float(load)}
    assert step == bench.simulation.step if load == "500" else step < bench.simulation.step
    loaded = load_configuration(bench, {key: value for key, value in scenarios[0]["set"].items() if key != "structure.healthy_level"})
    assert step <= step_limits.longest_step(loaded) < 1.3 * step or load == "500"


def test_too_many_counterparts_are_refused_before_a_machine_is_simulated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dcrb_ros.exam.replica.healthy_level", lambda *_, **__: pytest.fail("a machine was simulated"))
    rows = [(f"calm_{k}", "healthy", 1800) for k in range(400)]
    with pytest.raises(Refusal, match=r"400 recordings would have 2400 counterparts, but an exam has at most 2000: give fewer --machines"):
        replica_tree(table(tmp_path, rows), ReplicaPlan())


def test_a_replica_of_many_recordings_can_be_read(tmp_path: Path) -> None:
    """A scenario takes some 2 kB: the 2000 of the largest exam are more than the largest file of settings."""
    path, text = tmp_path / "replica.yaml", yaml_text(replica_tree(table(tmp_path), PLAN))
    path.write_text(text + "# a line of a comment\n" * (LARGEST_TEXT // 20))
    assert path.stat().st_size > LARGEST_TEXT
    assert len(text) / 12 * MOST_CASES < LARGEST_EXAM
    assert len(read_any_exam(path).cases) == len(read_exam(path).cases) == 12


def test_a_bearing_of_the_bench_is_that_of_the_bench() -> None:
    bench = load_configuration("ball_bearing_6205")
    scaled = bearing_settings(geometry_of(Orders(0.39828, 3.5848, 5.4152, 2.35695)), bench)
    for key, value in scaled.items():
        assert value == pytest.approx(getattr(bench.bearing, key.removeprefix("bearing.")), rel=1e-3), key


def test_impacts_have_shares_of_one_variance() -> None:
    for k in range(300):
        values = drawn("bearing", "outer_ring", "balls", generator_of(k))
        assert values["impacts.element_share"] + values["impacts.shaft_share"] <= 1.0
        assert 0.0 < values["impacts.spread"] <= 1.3
    assert "impacts.spread" not in drawn("bearing", "healthy", "balls", generator_of(1))


def test_every_prior_is_described_and_draws_values_within_its_words() -> None:
    for prior in PRIORS:
        values = [prior.distribution.drawn(np.random.default_rng(k)) for k in range(50)]
        assert len(set(values)) > 40
        assert described(prior.distribution)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"BPFO": "3.2"}, "is not a whole number of rolling elements"),
        ({"FTF": "0.6"}, "FTF = 0.6 contradicts BPFO"),
        ({"FTF": "0.35", "BPFO": "1.75", "BPFI": "3.25", "BSF": "1.5167"}, "calm_1: its bearing: bearing.rollers_per_row = 5 is outside"),
        ({"BSF": "0.4"}, "BSF = 0.4 gives rolling elements"),
        ({"sampling_rate": "12007"}, "has no divisor from 10 to 1000 Hz"),
        ({"sampling_rate": "400000"}, "calm_1: sampling_rate = 400000 Hz is outside 1000 .. 204800 Hz of the bench: resample"),
        ({"sampling_rate": "500"}, "calm_1: sampling_rate = 500 Hz is outside 1000 .. 204800 Hz of the bench: resample"),
        ({"sampling_rate": "97656.25"}, "line 2: sampling_rate = 97656.25 is not a whole number: resample"),
        ({"BPFO": "nan"}, "line 2: BPFO = nan is not a finite number: give one, or leave calm_1 out"),
        ({"load": "1e7"}, "calm_1: its bearing: operating.load = 1e+07 N"),
        ({"truth": "cage"}, "calm_1 is cage, which has no replica"),
        ({"seconds": "-1"}, "seconds = -1 is not a number above 0"),
        ({"seconds": "0.4"}, "line 2: seconds = 0.4, but a verdict needs 0.5 s: leave calm_1 out"),
        ({"seconds": "0.6"}, "calm_1: 0.3 s are compared, since half of a healthy recording precedes the other"),
        ({"gain": "loud"}, "gain = loud is invalid"),
        ({"speed_rpm_from_lines": "10000"}, "calm_1: a speed of 10000 rpm is outside 0 .. 9549 rpm of the bench: check the"),
        (
            {"speed_rpm_from_lines": "1e-6"},
            "calm_1: at 1e-06 rpm the shaft makes 4.2e-08 revolutions in the 2.5 s that are compared",
        ),
        ({"speed_rpm_from_lines": "x"}, "line 2"),
    ],
)
def test_invalid_input_is_one_sentence_and_writes_nothing(
    changes: dict[str, str], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "replica.yaml"
    options = ("--without", "background", "-o", str(output))
    assert dcrb("exam", "replica", str(table(tmp_path, **changes)), *options) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1
    assert not output.exists()


@pytest.mark.parametrize(
    ("plan", "sentence"),
    [
        (ReplicaPlan(without=("noise",)), "the part 'noise' is unknown"),
        (ReplicaPlan(machines=2, counterparts=3), "3 counterparts on 2 machines"),
        (ReplicaPlan(longest=0.1), "longest = 0.1 s is outside 1 .. 60 s"),
        (ReplicaPlan(seed=-1), "seed = -1 is outside"),
        (ReplicaPlan(bench="ball_bearing"), "there is no configuration 'ball_bearing'"),
    ],
)
def test_an_invalid_plan_is_refused(plan: ReplicaPlan, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=sentence):
        replica_tree(table(tmp_path), plan)


def test_a_machine_has_one_kind_of_gain(tmp_path: Path) -> None:
    file = table(tmp_path, gain="known")
    lines = file.read_text().splitlines()
    file.write_text("\n".join([*lines[:-1], lines[-1].replace("known", "unknown")]) + "\n")
    with pytest.raises(Refusal, match="gain is known for outer_1 and unknown for outer_2, both of the machine bench: give known for all"):
        replica_tree(file, PLAN)


def test_a_missing_column_is_refused(tmp_path: Path) -> None:
    file = table(tmp_path)
    file.write_text(file.read_text().replace("BPFI", "bpfi"))
    with pytest.raises(Refusal, match="lacks the columns BPFI"):
        replica_tree(file, PLAN)


def sidebands(share: float) -> float:
    """Return the depth of an inner ring's sidebands at the shaft frequency, if the energy of an impact follows the square of the load."""
    root = share ** (2.0 / 3.0)
    cosine = np.cos(np.arange(3600) * np.pi / 1800.0)
    energy = np.maximum(root / (1.0 - root) + cosine, 0.0) ** 3
    return float((energy * cosine).mean() / energy.mean())


def test_drawn_axial_preloads_give_the_sidebands_of_three_rigs() -> None:
    # Medians of CWRU, HIT and MFPT in docs/results/signals.md; without preload the depth is 3 pi/8 / (4/3).
    assert sidebands(0.0) == pytest.approx(9.0 * np.pi / 32.0, rel=1e-3)
    random = np.random.default_rng(1)
    depths = [sidebands(drawn("machine", "inner_ring", "balls", random)["impacts.axial_share"]) for _ in range(300)]
    for measured in (0.40, 0.38, 0.73):
        assert min(depths) < measured < max(depths)
