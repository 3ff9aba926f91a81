"""A run in one call."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest
from dry_benches import dry_bench

import dcrb_ros
from dcrb_ros import Configuration, Refusal, Simulation, SimulationResult, Waveform, load_configuration, simulate


@pytest.fixture(scope="module")
def run() -> SimulationResult:
    return simulate(dry_bench("outer_ring_defect"), 0.3)


def test_samples_are_those_of_the_blocks(run: SimulationResult) -> None:
    blocks = list(Simulation(dry_bench("outer_ring_defect")).blocks(0.3))
    assert np.array_equal(run.acceleration, np.concatenate([block.acceleration for block in blocks]))
    assert np.array_equal(run.shaft_angle, np.concatenate([block.shaft_angle for block in blocks]))
    assert np.array_equal(run.clean, np.concatenate([block.clean for block in blocks]))
    assert [state.time_ns for block in blocks for state in block.states] == [round(time * 1e9) for time in run.states.time]
    assert np.array_equal(run.states.azimuth, [state.azimuth for block in blocks for state in block.states])
    assert run.truth.truths == tuple(truth for block in blocks for truth in block.truths)


def test_shapes_and_units(run: SimulationResult) -> None:
    samples = round(0.3 * 51200)
    assert run.acceleration.shape == run.clean.shape == (samples, 2)
    assert run.shaft_angle.shape == run.time.shape == (samples,)
    assert run.time[51200 // 10] == pytest.approx(0.1)
    assert (run.duration, run.sampling_rate, len(run)) == (pytest.approx(0.3), 51200, samples)
    assert run.shaft_frequency == pytest.approx(125.664 / (2.0 * np.pi), rel=1e-4)
    assert run.turns[-1] == pytest.approx(run.shaft_frequency * run.duration, rel=1e-3)
    assert run.states.inner_force.shape == (len(run.states), 2 * 16 + 2 + 1)
    assert run.states.cage_offset is not None
    assert run.states.cage_offset.shape == (len(run.states), 2, 2)
    assert run.states.rollers(2) == slice(16, 32)
    assert run.states.names[run.states.column("cage2")] == "cage2"
    assert run.truth.load[0].tolist() == [0.0, -100e3]
    assert run.truth.frequency("BPFO")[0] == pytest.approx(run.orders.bpfo * run.truth.speed[0] / (2.0 * np.pi))


def test_representations_say_what_things_are(run: SimulationResult) -> None:
    assert repr(run) == "<SimulationResult: 0.3 s at 51.2 kHz (15360 samples), shaft at 20.00 Hz, outer_1: 2 mm wide>"
    assert repr(run.configuration) == str(run.configuration) == "<Configuration: 125.664 rad/s (1200 rpm), 100 kN, outer_1: 2 mm wide>"
    block = next(Simulation(Configuration()).blocks())
    assert repr(block) == "<Block: 1024 samples at 51.2 kHz from 0.0000 s, 1 states>"
    assert "35 bodies from row1/roller01 to inner_ring" in repr(run.states)
    assert repr(run.truth) == "<GroundTruth: 3 times, at the end outer_1: 2 mm wide>"


@pytest.mark.parametrize(
    "settings",
    [
        {"operating.speed": 100.0, "faults.inner_1.width": 0.002},
        {"operating": {"speed": 100.0}, "faults": {"inner_1": {"width": 0.002}}},
        {"operating.speed": np.float32(100.0), "faults": {"inner_1.width": np.float64(0.002)}},
        ["operating.speed=100", "faults.inner_1.width=0.002"],
    ],
)
def test_settings_come_in_several_forms(settings: Any) -> None:
    expected = Configuration.model_validate({"operating": {"speed": 100.0}, "faults": {"inner_1": {"width": 0.002}}})
    assert Configuration(operating={"speed": 100.0}, faults={"inner_1": {"width": 0.002}}) == expected
    assert load_configuration("dry", settings) == expected
    assert load_configuration(load_configuration("dry"), settings) == expected
    assert simulate(expected, 0.02).configuration == simulate("dry", 0.02, settings=settings).configuration


def test_seed_changes_the_noise_only_where_it_is_given() -> None:
    first, again, other = simulate("dry", 0.05, seed=7), simulate("dry", 0.05, seed=7), simulate("dry", 0.05, seed=8)
    assert np.array_equal(first.acceleration, again.acceleration)
    assert not np.array_equal(first.acceleration, other.acceleration)
    assert first.configuration.simulation.seed == 7


def test_a_scenario_takes_effect_and_tells_the_truth() -> None:
    story = {"start": {"operating.speed": 60.0}, "timeline": [{"at": 0.1, "set": {"faults.outer_1.width": 0.002}}]}
    run = simulate("dry", 0.2, scenario=story)
    assert run.configuration.operating.speed == 60.0
    assert run.truth.truths[0].faults == {}
    assert run.truth.faults["outer_1"]["onset"] == pytest.approx(0.1)


def test_shipped_scenario_by_name() -> None:
    assert simulate("dry", 0.05, scenario="run_up").configuration.operating.speed == pytest.approx(20.0 / 3.6 / 0.46)


def test_lost_blocks_are_left_out_and_the_index_jumps() -> None:
    run = simulate("dry", 0.5, settings={"publishing.loss_probability": 0.3})
    gaps = np.diff(run.index) != 1
    assert gaps.any()
    assert len(run) < 0.5 * run.sampling_rate
    assert "samples lost" in repr(run)
    pieces = list(run.pieces())
    assert sum(len(piece.shaft_angle) for piece in pieces) == len(run)
    assert {piece.first_index for piece in pieces} >= set(run.index[1:][gaps].tolist())


def test_a_stretch_of_a_run(run: SimulationResult) -> None:
    part = run.between(0.1, 0.2)
    assert isinstance(part, SimulationResult)
    assert part.time[0] == pytest.approx(0.1)
    assert len(part) == len(part.clean) == 5120
    assert np.array_equal(part.acceleration, run.acceleration[5120:10240])


@pytest.mark.parametrize("rate", [1000, 25600, 51200])
def test_stretches_between_tenths_of_a_second_have_equal_lengths(rate: int) -> None:
    waveform = Waveform.from_arrays(np.zeros(4 * rate), rate)
    assert {len(waveform.between(k * 0.1, (k + 1) * 0.1)) for k in range(39)} == {rate // 10}
    assert {int(waveform.between(k / 10).index[0]) - k * rate // 10 for k in range(40)} == {0}


@pytest.mark.parametrize(
    ("start", "stop", "sentence"),
    [
        (3.0, None, "no sample from 3 s on"),
        (None, 0.0, "no sample before 0 s"),
        (2.0, 1.0, "start = 2 s is not below stop = 1 s"),
        ("a", None, "start = 'a' is not a number"),
        (float("nan"), None, "start = nan s is not a finite number"),
    ],
)
def test_stretches_without_samples_are_refused(start: Any, stop: Any, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        Waveform.from_arrays(np.zeros(1000), 1000).between(start, stop)


@pytest.mark.parametrize("duration", [np.float32(0.125), np.float64(0.125)])
def test_a_duration_may_be_a_number_of_numpy(duration: Any) -> None:
    assert len(simulate("dry", duration)) == 6400
    assert len(simulate("dry", np.int64(1))) == 51200


def test_frames_carry_time_and_columns(run: SimulationResult) -> None:
    frame = run.to_pandas()
    assert list(frame.columns) == ["ax", "ay", "shaft_angle", "ax_clean", "ay_clean"]
    assert frame.index.name == "time"
    assert frame["ay"].to_numpy() == pytest.approx(run.acceleration[:, 1])
    bodies = run.states.to_pandas()
    assert bodies["inner_force", "row1/roller01"].to_numpy() == pytest.approx(run.states.inner_force[:, 0])
    truth = run.truth.to_pandas()
    assert truth["faults"].iloc[-1] == "outer_1"
    assert truth["BPFO"].to_numpy() == pytest.approx(run.truth.frequency("BPFO"))


def test_without_pandas_one_sentence(run: SimulationResult, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(Refusal, match="to_pandas needs pandas, which is not installed: pip install pandas"):
        run.to_pandas()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"duration": 0.0}, "duration = 0 s is out of range: it must be above 0 and at most 3600 s"),
        ({"duration": float("nan")}, "duration = nan s is not a finite number"),
        ({"duration": "5"}, "duration = '5' is not a number"),
        ({"duration": True}, "duration = True is not a number"),
        ({"duration": 1e-6}, r"duration = 1e-06 s is shorter than one sample \(19.5 us at 51200 Hz\)"),
        ({"duration": 1e5}, "block by block with dcrb_ros.Simulation"),
        ({"configuration": "heathy"}, "did you mean 'healthy'"),
        ({"settings": {"operating.sped": 1.0}}, "did you mean 'operating.speed'"),
        ({"settings": {"operating.speed": "fast"}}, "operating.speed = 'fast' rad/s is not a number within"),
        ({"scenario": "nothing"}, "there is no scenario 'nothing'"),
        ({"scenario": {"timeline": 1}}, "scenario is not a scenario"),
    ],
)
def test_refusals_name_value_range_and_remedy(arguments: dict[str, Any], sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        simulate(**{"duration": 0.1, **arguments})


def test_unknown_bodies_and_rows_are_refused(run: SimulationResult) -> None:
    with pytest.raises(Refusal, match="there is no body 'cage3'"):
        run.states.column("cage3")
    with pytest.raises(Refusal, match="there is no row 3: the bearing has 2"):
        run.states.rollers(3)
    with pytest.raises(Refusal, match=r"no sample from 1 s on: it has samples from 0 to 0.29"):
        run.between(1.0)


def test_plain_arrays_become_a_waveform() -> None:
    angle = np.linspace(0.0, 20.0, 500)
    waveform = Waveform.from_arrays(np.zeros(500), 1000, shaft_angle=angle, bearing=dcrb_ros.Bearing())
    assert waveform.acceleration.shape == (500, 2)
    assert waveform.turns[-1] == pytest.approx(20.0 / (2.0 * np.pi))
    assert waveform.shaft_frequency == pytest.approx(20.0 / (2.0 * np.pi) / 0.499, rel=1e-6)
    assert not Waveform.from_arrays(np.zeros((500, 2)), 1000).tracked


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((np.zeros((10, 3)), 1000), r"acceleration of shape \(10, 3\) is not a waveform"),
        ((np.zeros((3, 1000)), 1000), r"shape \(3, 1000\) is not a waveform: .* one sample; transpose the array"),
        ((np.zeros(10), "51200"), "sampling_rate = '51200' is not a number: give it in Hz"),
        ((np.zeros(0), 1000), "at least one sample"),
        ((np.zeros(10, complex), 1000), "give real numbers"),
        ((np.zeros(10), 0.0), "sampling_rate = 0.0 Hz is not a whole number"),
        ((np.zeros(10), 1000.5), "sampling_rate = 1000.5 Hz is not a whole number"),
    ],
)
def test_arrays_that_are_no_waveform_are_refused(arguments: Any, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        Waveform.from_arrays(*arguments)


def test_characteristic_frequencies_of_a_catalogue_bearing() -> None:
    # Eqs. 43 to 45 of Fan et al. 2025 with 14 rollers of 5 mm radius on a pitch radius of 30 mm.
    bearing = dcrb_ros.Bearing(
        rollers_per_row=14, roller_radius=0.005, pitch_radius=0.03, inner_raceway_radius=0.02495, outer_raceway_radius=0.03505
    )
    found = dcrb_ros.characteristic_frequencies(bearing, 2.0 * np.pi * 10.0)
    ratio = 5.0 / 30.0
    rings = {"FTF": 5.0 * (1.0 - ratio), "BPFO": 70.0 * (1.0 - ratio), "BPFI": 70.0 * (1.0 + ratio)}
    assert found == pytest.approx({**rings, "BSF": 5.0 * (1.0 - ratio**2) / ratio})
    assert dcrb_ros.characteristic_frequencies(bearing, -2.0 * np.pi * 10.0) == found
    with pytest.raises(Refusal, match="speed = nan rad/s"):
        dcrb_ros.characteristic_frequencies(bearing, float("nan"))


LATE = {"timeline": [{"at": 1.0, "set": {"operating.load": 9e4}}]}


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: dcrb_ros.characteristic_frequencies("healthy", "20"), "speed = '20' is not a number: give it in rad/s"),  # type: ignore[arg-type]
        (lambda: dcrb_ros.detect(np.zeros(10), 1000, bearing="healthy"), r"give dcrb_ros.load_configuration\('healthy'\)"),  # type: ignore[arg-type]
        (lambda: dcrb_ros.detect(np.zeros(10), 1000, bearing=5), "bearing = 5 is not a bearing"),  # type: ignore[arg-type]
        (lambda: dcrb_ros.detect("bags/healthy"), r"use dcrb_ros.Recording\('bags/healthy'\)"),
        (lambda: dcrb_ros.envelope_spectrum("bags/healthy"), r"use dcrb_ros.Recording\('bags/healthy'\)"),
        (lambda: dcrb_ros.Recording(3), "3 is not the path of a recording"),  # type: ignore[arg-type]
        (lambda: load_configuration(5), "5 is not a configuration"),  # type: ignore[arg-type]
        (lambda: load_configuration("dry", 5), "settings = 5 is neither a mapping nor texts"),  # type: ignore[arg-type]
        (lambda: load_configuration("dry", ["operating.speed"]), "setting 'operating.speed': write KEY=VALUE"),
        (lambda: dcrb_ros.simulate("dry", scenario={"timeline": []}), "scenario changes nothing: it has no 'start'"),
        (lambda: dcrb_ros.simulate("dry", 1.0, scenario=LATE), "scenario changes nothing in a run of 1 s, its first entry is at 1 s"),
        (lambda: Simulation("healthy"), r"'healthy' is not a Configuration: give dcrb_ros.load_configuration"),  # type: ignore[arg-type]
        (lambda: Simulation(Configuration(), "run_up"), "scenario = 'run_up' is not a list of scheduled changes"),  # type: ignore[arg-type]
        (lambda: Simulation(Configuration()).blocks(-1.0), "duration = -1 s is negative"),
        (lambda: dcrb_ros.Bearing(rows=3), r"^rows = 3 is outside 1 \.\. 2"),
        (lambda: dcrb_ros.Bearing(row=2), r"^unknown parameter 'row'; did you mean 'rows'\?"),  # type: ignore[call-arg]
        (lambda: dcrb_ros.Bearing(inner_raceway_radius=78.86), r"^inner_raceway_radius = 78.86 m is outside .*did you mean 0.07886"),
        (lambda: dcrb_ros.DetectorParameters(hop=100), r"^hop = 100 s is outside 0.05 \.\. 60 s"),
        (lambda: Configuration(operating={"speed": "x"}), "^operating.speed = 'x' rad/s is not a number"),  # type: ignore[arg-type]
        (lambda: Configuration(operating={"sped": 1.0}), r"^unknown parameter 'operating.sped'; did you mean 'operating.speed'\?"),  # type: ignore[arg-type]
        (lambda: Configuration(operating={"speed": float("nan")}), "^operating.speed = nan rad/s is not a finite number"),  # type: ignore[arg-type]
        (lambda: Configuration(simulation={"seed": -1}), r"^simulation.seed = -1 is outside 0 \.\. 2147483647"),  # type: ignore[arg-type]
        (lambda: Configuration(friction={"static_coefficient": 0.01}), "^friction.static_coefficient = 0.01 is below"),  # type: ignore[arg-type]
    ],
)
def test_invalid_input_is_rejected_in_one_sentence(call: Any, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence) as caught:
        call()
    assert "\n" not in str(caught.value)
    assert isinstance(caught.value, ValueError)


def test_settings_may_be_one_text() -> None:
    assert load_configuration("dry", "operating.speed=100").operating.speed == 100.0


def test_names_in_the_ground_truth(run: SimulationResult) -> None:
    with pytest.raises(Refusal, match=r"there is no characteristic frequency 'BPFX': .*did you mean 'BPF"):
        run.truth.frequency("BPFX")
    with pytest.raises(Refusal, match=r"there is no characteristic frequency \["):
        run.truth.frequency(["BPFO"])  # type: ignore[arg-type]
    assert run.truth.to_pandas()["event"].tolist()[:2] == ["start", ""]
