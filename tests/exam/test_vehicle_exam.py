"""The exam of a vehicle: its file, its score, and detectors in a process of their own."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from attacked_files import ATTACKS
from synthetic_bogie import BOXES, DESCRIPTION, bogie

from dcrb_ros.exam.credit import vehicle_detection
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.evaluation import evaluate
from dcrb_ros.exam.exam_file import read_exam
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.leaderboard_entry import entry_of, read_entry, write_entry
from dcrb_ros.exam.limits import Limits
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.running_detector import BoxSamples, checked_statuses
from dcrb_ros.exam.vehicle import signals
from dcrb_ros.exam.vehicle.evaluation import (
    ProcessVehicleDetector,
    PythonVehicleDetector,
    VehicleOutcome,
    box_verdict,
    scored_boxes,
    vehicle_scenarios,
)
from dcrb_ros.exam.vehicle.exam_file import VehicleCase, VehicleExam, read_vehicle_exam, vehicle_exam_of
from dcrb_ros.exam.vehicle.signals import VehicleSignal, keep_signal, kept_signal, signal_path
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.vehicle_diagnosis import Status, VehicleDiagnosis
from dcrb_ros.vehicle.block import VehicleBlock
from dcrb_ros.vehicle.description import described
from dcrb_ros.vehicle.file import read_parameters, vehicle_of
from dcrb_ros.vehicle.simulation import VehicleSimulation

CRITERIA = Criteria(silence=3.0)
CASE = VehicleCase("case", {"vehicle.speed_kmh": 120.0}, 3.0, {"axle_1.left": "outer_ring"})


def outcome(**verdicts: str) -> VehicleOutcome:
    """Return an outcome with one verdict on each box from 2 s on; the others are healthy."""
    received = {
        name: [ReceivedDiagnosis(time, verdicts.get(name.replace("/", "_"), "healthy")) for time in (2.0, 2.5, 2.99)] for name in BOXES
    }
    return VehicleOutcome(received)


def credit_of(given: VehicleOutcome) -> float:
    """Return the credit for the damaged box where delays cost nothing."""
    return scored_boxes(CASE, DESCRIPTION, given, CRITERIA)[0].credit.detection["cost"]


def test_the_name_is_half_the_box_and_half_the_component() -> None:
    right = credit_of(outcome(axle_1_left="outer_ring"))
    wrong_component = credit_of(outcome(axle_1_left="roller"))
    wrong_box = credit_of(outcome(axle_1_right="outer_ring"))
    neither = credit_of(outcome(axle_2_right="roller"))
    assert right > 0.0
    assert wrong_component == pytest.approx(0.75 * right)
    assert wrong_box == pytest.approx(0.75 * right)
    assert neither == pytest.approx(0.5 * right)
    assert credit_of(outcome()) == 0.0


def test_a_wrong_box_is_a_false_alarm() -> None:
    results = scored_boxes(CASE, DESCRIPTION, outcome(axle_1_left="outer_ring", axle_1_right="outer_ring"), CRITERIA)
    assert {result.expectation.name: len(result.false_alarms) for result in results if result.false_alarms} == {"case/axle_1/right": 1}
    assert [result.credit.failed for result in results] == [0, 1, 0, 0]


@pytest.mark.parametrize("verdict", ["outer_ring", "roller"])
@pytest.mark.parametrize("box", ["axle_1_left", "axle_2_right"])
def test_the_entry_of_an_alarm_on_any_box_is_read(verdict: str, box: str, tmp_path: Path) -> None:
    results = scored_boxes(CASE, DESCRIPTION, outcome(**{box: verdict}), CRITERIA)
    entry = entry_of(Report("one", "alarming", CRITERIA, "0" * 64, tuple(results)))
    write_entry(entry, tmp_path / "entry.json")
    assert read_entry(tmp_path / "entry.json") == entry
    silent = entry_of(Report("one", "healthy", CRITERIA, "0" * 64, tuple(scored_boxes(CASE, DESCRIPTION, outcome(), CRITERIA))))
    forged = silent.scenarios[0].model_copy(update={"credit": entry.scenarios[0].credit})
    write_entry(silent.model_copy(update={"scenarios": [forged, *silent.scenarios[1:]]}), tmp_path / "silent.json")
    with pytest.raises(Refusal, match="contradicts itself in the scenario 'case/axle_1/left': a credit of"):
        read_entry(tmp_path / "silent.json")


def test_no_alarm_earns_nothing() -> None:
    expectation = Expectation("x", "outer_ring", 3.0, tags={"speed": 70.0})
    assert set(vehicle_detection(expectation, [], [[]], CRITERIA).values()) == {0.0}


def test_undecided_is_no_verdict_and_a_faulty_sensor_counts_first() -> None:
    statuses = {"axle_1/left/bearing": ("undecided", 3.0), "axle_1/right/bearing": ("roller", 3.0), "axle_1/right/sensor": ("sensor", 0.0)}
    assert box_verdict(statuses, "axle_1/left")[0] == "waiting"
    assert box_verdict(statuses, "axle_1/right") == ("sensor", 0.0)
    assert box_verdict(statuses, "axle_2/right") == ("waiting", None)
    assert box_verdict({"axle_1/right/sensor": ("sensor", None)}, "axle_1/right") == ("sensor", None)


@pytest.mark.parametrize(
    ("output", "sentence"),
    [
        ("outer_ring", "return a VehicleDiagnosis"),
        ({"axle_1/left": "outer_ring"}, "its last part must be one of"),
        ({"axle_1/left/bearing": "outer"}, "did you mean 'outer_ring'"),
        ({"track": "flat"}, "return one of"),
        ({"axle_1.left/bearing": "healthy"}, "no box 'axle_1.left'; did you mean 'axle_1/left'?"),
        (VehicleDiagnosis(0, 0.0, {"axle_1/left/bearing": Status("outer", "")}, {}), "did you mean 'outer_ring'"),
        (VehicleDiagnosis(0, 0.0, {"track": Status("joint", "", score=float("nan"))}, {}), "the score nan for track"),
        (VehicleDiagnosis(0, 0.0, {"axle_3/left/sensor": Status("sensor", "")}, {}), "no box 'axle_3/left'"),
    ],
)
def test_invalid_outputs_are_refused(output: object, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        checked_statuses(output, DESCRIPTION)


def test_a_diagnosis_and_a_mapping_say_the_same() -> None:
    diagnosis = VehicleDiagnosis(0, 0.0, {"track": Status("joint", "")}, {})
    assert checked_statuses(diagnosis, DESCRIPTION) == {"track": ("joint", 0.0)}
    assert checked_statuses({"track": "joint"}, DESCRIPTION) == {"track": ("joint", None)}


def signal() -> VehicleSignal:
    """Return a synthetic signal."""
    boxes = bogie()
    return VehicleSignal(DESCRIPTION, {name: a for name, (a, _) in boxes.items()}, {name: angle for name, (_, angle) in boxes.items()})


FOREIGN = """
class Foreign:
    def __init__(self, description):
        self.boxes = [box.name for box in description.boxes]
        self.seconds = 0.0

    def add(self, blocks):
        self.seconds += len(blocks[self.boxes[0]].acceleration) / 51200
        return {f"{box}/bearing": "roller" if box == self.boxes[2] else "healthy" for box in self.boxes} if self.seconds > 2.0 else None

class Failing(Foreign):
    def add(self, blocks):
        raise ValueError("no idea")
"""


def test_a_class_takes_part_in_a_process_of_its_own(tmp_path: Path) -> None:
    file = tmp_path / "foreign.py"
    file.write_text(FOREIGN, encoding="utf-8")
    found = ProcessVehicleDetector("foreign", f"{file}:Foreign", Limits()).diagnose(signal())
    assert found.failure == ""
    assert {name: received[-1].verdict for name, received in found.received.items()} == {
        name: "roller" if name == "axle_2/left" else "healthy" for name in BOXES
    }
    assert {diagnosis.score for received in found.received.values() for diagnosis in received} == {None}
    failed = ProcessVehicleDetector("failing", f"{file}:Failing", Limits()).diagnose(signal())
    assert "no idea" in failed.failure


def test_a_detector_without_add_is_refused() -> None:
    with pytest.raises(Refusal, match="has no method add"):
        PythonVehicleDetector("x", lambda description: object()).diagnose(signal())


class Listening:
    """A detector that remembers the temperatures, and finds a hot box a roller defect."""

    def __init__(self, description: object) -> None:
        self.readings: list[tuple[str, float, float, float]] = []
        self.samples = 0

    def add(self, blocks: Mapping[str, BoxSamples]) -> dict[str, str] | None:
        self.samples += len(blocks[BOXES[0]].acceleration)
        hot = {name for name, _, ring, air in self.readings if ring - air > 50.0}
        return {f"{name}/bearing": "roller" if name in hot else "healthy" for name in BOXES} if self.samples > 2 * 51200 else None

    def take_temperature(self, box: str, time: float, temperature: float, ambient: float) -> None:
        self.readings.append((box, time, temperature, ambient))


def test_a_detector_receives_the_temperatures_of_each_box_once() -> None:
    warm = {BOXES[2]: np.array([[0.0, 80.0, 20.0], [1.0, 81.0, 20.0], [2.0, 82.0, 20.5]])}
    detectors: list[Listening] = []

    def made(description: object) -> Listening:
        detectors.append(Listening(description))
        return detectors[0]

    found = PythonVehicleDetector("listening", made).diagnose(dataclasses.replace(signal(), temperatures=warm))
    assert detectors[0].readings == [(BOXES[2], *row) for row in warm[BOXES[2]].tolist()]
    assert {name: received[-1].verdict for name, received in found.received.items()} == {
        name: "roller" if name == BOXES[2] else "healthy" for name in BOXES
    }


def test_vehicles_are_evaluated_as_bearings_are(tmp_path: Path) -> None:
    parameters = {**read_parameters("healthy_bogie"), "vehicle.speed_kmh": 120.0}
    case = VehicleCase("case", parameters, 3.0, {"axle_2.left": "roller"})
    exam = VehicleExam("one", "", CRITERIA, (case,))
    scenarios = vehicle_scenarios(exam, tmp_path, workers=2)
    assert not scenarios.scenarios[0].recorded()  # type: ignore[misc]
    given = dataclasses.replace(signal(), temperatures={BOXES[2]: np.array([[0.0, 80.0, 20.0]])})
    keep_signal(given, signal_path(parameters, 3.0, tmp_path))
    report = evaluate(PythonVehicleDetector("listening", Listening), scenarios, workers=2)
    assert {result.expectation.name: result.answer for result in report.results} == {
        f"case/{name}": "roller" if name == BOXES[2] else "healthy" for name in BOXES
    }
    write_entry(entry_of(report), tmp_path / "entry.json")
    assert [scenario.name for scenario in read_entry(tmp_path / "entry.json").scenarios] == [f"case/{name}" for name in BOXES]


def test_the_shipped_exam_covers_boxes_components_and_cross_talk() -> None:
    exam = read_vehicle_exam("bogie")
    single = [case for case in exam.cases if len(case.damaged) == 1 and case.tags["kind"] in ("outer", "inner", "roller")]
    assert {(next(iter(case.damaged.items())), case.tags["variant"]) for case in single} == {
        ((box, verdict), variant)
        for box in ("axle_1.left", "axle_1.right", "axle_2.left", "axle_2.right")
        for verdict in ("outer_ring", "inner_ring", "roller")
        for variant in ("10dB", "20dB", "30dB")
    }
    assert len(single) >= 124
    assert sum(case.tags["kind"] in ("flat", "joints") for case in exam.cases) >= 120


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"scenarios": [{"name": "x", "variants": ["5dB"]}]}, "there is no variant '5dB'"),
        ({"scenarios": [{"name": "x", "set": {"box.bench": "healthy"}}]}, "names no box"),
        ({"scenarios": [{"name": "x", "damaged": {"axle_3.left": "roller"}}]}, "names the box 'axle_3.left'"),
        ({"scenarios": [{"name": "x"}, {"name": "x"}]}, "two scenarios are called"),
        ({"scenarios": [{"name": "x", "set": {"vehicle.seed": []}}]}, "has an empty list"),
        ({"scenarios": []}, "defines no scenario"),
        ({"set": {"time_scale": 2.0}}, "time_scale has no effect in an exam"),
        ({"scenarios": [{"name": ""}]}, "name"),
        ({"set": {"publishing": {"burst_length": 1.0, "burst_period": 5.0}}}, "'x': publishing.burst_period = 5 causes gaps"),
        ({"set": {"publishing.loss_probability": 0.1}}, "'x': publishing.loss_probability = 0.1 causes gaps, which the exam of a vehicle"),
        (
            {"scenarios": [{"name": "x", "set": {"axle_1.left.publishing.loss_probability": [0.0, 0.5]}}]},
            "'x': publishing.loss_probability = 0.5 causes gaps",
        ),
        ({"vehicle": "no_such"}, "no_such"),
        (
            {"scenarios": [{"name": "x", "boxes": ["axle_1.left", "axle_1.lefd"], "damaged": {"box": "sensor"}}]},
            "names the box 'axle_1.lefd'; did you mean 'axle_1.left'",
        ),
        (
            {
                "scenarios": [
                    {
                        "name": "x",
                        "set": {"axle_1.left.bench": ["roller_defect", "inner_ring_defect"]},
                        "damaged": {"axle_1.left": "roller"},
                    }
                ]
            },
            "damaged gives axle_1.left the verdict roller, which contradicts its faults, which make inner_ring correct: change damaged",
        ),
        ({"scenarios": [{"name": "x", "boxes": ["axle_1.left"]}]}, "'x': boxes has no effect without a key of 'box'"),
        ({"scenarios": [{"name": "x", "required": False}]}, "'x': required = false has no effect on healthy boxes"),
        ({"scenarios": [{"name": "x", "set": {"vehicle.cant": [0.0, 0.1]}}]}, "'x': vehicle.cant has no effect on straight track: give"),
        ({"set": {"vehicle.cant": 0.1}}, "exam.yaml, set: vehicle.cant has no effect"),
        ({"points": {"p": {"vehicle": {"cant": 0.1}}}}, "exam.yaml, points, p: vehicle.cant has no effect"),
        (
            {"variants": {"v": {"vehicle.cant": 0.1}}, "scenarios": [{"name": "x", "variants": ["v"]}]},
            "exam.yaml, variants, v: vehicle.cant has no effect",
        ),
        (
            {"scenarios": [{"name": "x", "set": {"axle_2.right.faults.outer_1.width": 0.002}}]},
            "damaged gives axle_2.right the verdict healthy, which contradicts its faults, which make outer_ring correct",
        ),
    ],
)
def test_an_invalid_file_is_refused_in_one_sentence(change: dict[str, object], sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "exam.yaml"
    file.write_text(yaml.safe_dump({"exam": "x", "vehicle": "healthy_bogie", "scenarios": [{"name": "x"}], **change}), encoding="utf-8")
    with pytest.raises(Refusal, match=sentence):
        read_vehicle_exam(file)


def test_a_cant_may_be_given_where_some_scenarios_have_a_curve() -> None:
    scenarios = [{"name": "straight"}, {"name": "curve", "set": {"vehicle.curvature": [0.0, 0.001]}}]
    tree = {"exam": "x", "vehicle": "healthy_bogie", "set": {"vehicle.cant": 0.1}, "scenarios": scenarios}
    assert [case.parameters["vehicle.cant"] for case in vehicle_exam_of(tree, "the test").cases] == [0.1] * 3


def test_speed_and_seed_of_a_vehicle_may_be_the_default_ones(tmp_path: Path) -> None:
    (tmp_path / "vehicle.yaml").write_text("axle_1: {left: {}, right: {}}\n", encoding="utf-8")
    exam = vehicle_exam_of({"exam": "x", "vehicle": str(tmp_path / "vehicle.yaml"), "scenarios": [{"name": "x"}]}, "the test")
    (case,) = exam.cases
    assert exam.seeds == (1,)
    results = scored_boxes(case, described(case.vehicle()), VehicleOutcome(), CRITERIA)
    assert [result.expectation.tags["speed"] for result in results] == pytest.approx([120.0 / 3.6 / 0.46] * 2)


def test_every_vehicle_draws_its_seeds_unless_the_exam_gives_them() -> None:
    flat = {"box.wheel.flat": 0.02}
    scenarios = [{"name": "drawn", "boxes": ["axle_1.left", "axle_2.left"], "set": flat}, {"name": "given", "set": {"track.seed": 5}}]
    tree = {"exam": "x", "vehicle": "healthy_bogie", "set": {"paths.seed": 4}, "scenarios": scenarios}
    drawn = vehicle_exam_of({**tree, "seed": 8}, "the test")
    first, second, given = drawn.cases
    assert len({case.parameters["vehicle.seed"] for case in drawn.cases}) == 3
    assert first.parameters["track.seed"] != second.parameters["track.seed"]
    assert [case.parameters["paths.seed"] for case in drawn.cases] == [4, 4, 4]
    assert given.parameters["track.seed"] == 5
    assert [case.parameters for case in drawn.cases] == [case.parameters for case in vehicle_exam_of({**tree, "seed": 8}, "again").cases]
    assert drawn.digest != vehicle_exam_of({**tree, "seed": 9}, "the test").digest
    assert [case.parameters.get("track.seed") for case in vehicle_exam_of(tree, "the test").cases] == [None, None, 5]


def test_a_seed_that_is_none_is_refused() -> None:
    scenario = {"name": "x", "set": {"vehicle.seed": [1, "two"]}}
    exam = vehicle_exam_of({"exam": "x", "vehicle": "healthy_bogie", "scenarios": [scenario]}, "the test")
    with pytest.raises(Refusal, match=r"scenario 'x/seed=two', vehicle: seed"):
        _ = exam.seeds


def test_the_exam_of_a_bearing_does_not_read_that_of_a_vehicle() -> None:
    with pytest.raises(Refusal, match="is the exam of a vehicle"):
        read_exam("bogie")


def test_an_edited_bench_changes_digest_and_signal(tmp_path: Path) -> None:
    bench = tmp_path / "bench.yaml"
    scenarios = [{"name": "common", "set": {"vehicle.bench": str(bench)}}, {"name": "own", "set": {"axle_1.left.bench": str(bench)}}]
    digests: list[str] = []
    for density in (1e-3, 2e-3, 2e-3):
        bench.write_text(yaml.safe_dump({"sensor": {"noise_density": density}}), encoding="utf-8")
        exam = vehicle_exam_of({"exam": "x", "vehicle": "healthy_bogie", "scenarios": scenarios}, "the test")
        digests += [exam.digest, *(signal_path(case.parameters, 3.0, tmp_path).name for case in exam.cases)]
    assert len(set(digests)) == 6
    assert digests[3:6] == digests[6:]


def swapped(file: Path) -> None:
    kept_signal({"other": 1}, 1.0, file.parent)
    other = next(one for one in file.parent.glob("*.signal") if one != file)
    file.write_bytes(other.read_bytes())


@pytest.mark.parametrize("attack", [swapped, *ATTACKS.values()], ids=["swapped", *ATTACKS])
@pytest.mark.timeout(60)  # a pipe would be waited for
def test_a_kept_signal_that_is_not_as_it_was_written_is_made_again(
    attack: Callable[[Path], object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made = []

    def simulated(vehicle: Any, duration: float, memory: object, threads: int | None) -> VehicleSignal:
        made.append(vehicle)
        value = np.full((100, 2), float(len(vehicle)), np.float32)
        return VehicleSignal(DESCRIPTION, dict.fromkeys(BOXES, value), dict.fromkeys(BOXES, value[:, 0]))

    monkeypatch.setattr(signals, "simulated_signal", simulated)
    monkeypatch.setattr(signals, "vehicle_of", lambda parameters, source: parameters)
    first = kept_signal({}, 1.0, tmp_path)
    (file,) = tmp_path.glob("*.signal")
    again = kept_signal({}, 1.0, tmp_path)
    assert len(made) == 1
    attack(file)
    repaired = kept_signal({}, 1.0, tmp_path)
    assert f"{file} " in (message := capsys.readouterr().err)
    assert "; the vehicle is simulated again" in message
    assert not file.is_symlink()
    assert made[-1] == {}
    for found in (again, repaired):
        for box in BOXES:
            assert np.array_equal(found.acceleration[box], first.acceleration[box])


@pytest.mark.slow
def test_a_motion_is_long_enough_for_every_clock() -> None:
    """With 2023 samples, a clock that is slow by 500 ppm needs a frame more; the motion does not depend on the clock."""
    memory, duration = signals.MotionMemory(), 2023 / 51200
    slow, swapped = {"axle_1.left.sensor.clock_offset_ppm": -500.0}, {"axle_1.left.sensor.swapped_with": "axle_2.left"}
    vehicles = [vehicle_of(read_parameters("healthy_bogie", given), "the test") for given in ({}, slow, {**slow, **swapped}, {})]
    for vehicle in vehicles:
        found, own = (signals.simulated_signal(vehicle, duration, of) for of in (memory, signals.MotionMemory()))
        for box in BOXES:
            assert len(own.acceleration[box]) == 2023
            assert np.array_equal(found.acceleration[box], own.acceleration[box])


def test_a_vehicle_with_a_box_that_failed_is_not_evaluated(monkeypatch: pytest.MonkeyPatch) -> None:
    step_to, failing = Simulation.step_to, [True]

    def fails_once(self: Simulation, end: int) -> Any:
        if failing and self.configuration.publishing.frame.startswith("axle_2/left") and end > signals.FRAME:
            failing.pop()
            raise ModelFailure("a roller left its race")
        return step_to(self, end)

    monkeypatch.setattr(Simulation, "step_to", fails_once)
    vehicle = vehicle_of(read_parameters("healthy_bogie", {"vehicle.on_failure": "continue"}), "the test")
    memory = signals.MotionMemory()
    with pytest.raises(ModelFailure, match=r"axle_2\.left: a roller left its race"):
        signals.simulated_signal(vehicle, 0.03, memory)
    assert {len(samples) for samples in signals.simulated_signal(vehicle, 0.03, memory).acceleration.values()} == {round(0.03 * 51200)}


def test_an_interrupted_simulation_leaves_no_part_of_a_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle, memory = vehicle_of(read_parameters("healthy_bogie", ()), "the test"), signals.MotionMemory()
    blocks = VehicleSimulation.blocks

    def interrupted(self: VehicleSimulation, duration: float) -> Iterator[VehicleBlock]:
        yield next(iter(blocks(self, duration)))
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(VehicleSimulation, "blocks", interrupted)
        with pytest.raises(KeyboardInterrupt):
            signals.simulated_signal(vehicle, 0.2, memory)
    signal = signals.simulated_signal(vehicle, 0.2, memory)
    rate = vehicle.boxes[0].configuration.sensor.sampling_rate
    assert {len(samples) for samples in signal.acceleration.values()} == {round(0.2 * rate)}
