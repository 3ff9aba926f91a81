"""The comparing detector on synthetic bogies whose causes are known."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from types import MappingProxyType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from synthetic_bearing import ORDERS
from synthetic_bogie import BOXES, DESCRIPTION, FREQUENCY, LAG, SECONDS, Boxes, bogie, diagnosed, last, verdicts

from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.rules.outer_ring import OuterRing
from dcrb_ros.diagnosis.vehicle.causes import Lag, correlated_lag, silent_boxes
from dcrb_ros.diagnosis.vehicle.contact import Contact, impacts_of
from dcrb_ros.diagnosis.vehicle.detection import VehicleDetectionResult, detect_vehicle
from dcrb_ros.diagnosis.vehicle.detector import BoxBlock, VehicleDetector
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.vehicle_diagnosis import Status, VehicleDiagnosis

SPALLS = {"outer_ring": {"outer": 900.0}, "inner_ring": {"inner": 1500.0}, "roller": {"roller": 1500.0}}


TURNED = {"polygons": {"axle_1/right": (18, 3.0)}, "mesh": {"axle_1/left": 1.0, "axle_1/right": 0.7}}
"""A polygon and a mesh."""


@pytest.mark.parametrize("verdict", SPALLS)
@pytest.mark.parametrize("box", ["axle_1/right", pytest.param("axle_2/left", marks=pytest.mark.slow)])
def test_only_the_damaged_box_is_named(verdict: str, box: str) -> None:
    diagnosis = last(bogie({box: SPALLS[verdict]}))
    assert verdicts(diagnosis, "bearing") == {box: verdict}
    assert diagnosis.damaged() == {box: verdict}


def test_lines_that_a_healthy_bearing_may_have_damage_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(OuterRing, "healthy_evidence", lambda rule, orders: 100.0)
    assert verdicts(last(bogie({"axle_1/left": SPALLS["outer_ring"]})), "bearing") == {}


def test_the_other_box_of_the_wheelset_alone_would_be_named_too() -> None:
    diagnosis = last(bogie({"axle_1/left": {"outer": 2000.0}}))
    assert diagnosis.boxes["axle_1/right"].verdict == "outer_ring"
    assert verdicts(diagnosis, "bearing") == {"axle_1/left": "outer_ring"}


def dead(signals: Boxes, box: str) -> Boxes:
    """Return signals with a constant one in a box."""
    return {**signals, box: (np.full_like(signals[box][0], 3.0), signals[box][1])}


def test_beside_a_dead_sensor_lines_are_undecided() -> None:
    diagnosis = last(dead(bogie({"axle_1/left": {"outer": 2000.0}}), "axle_1/left"))
    assert diagnosis.damaged() == {}
    assert diagnosis.statuses["axle_1/right/bearing"].verdict == "undecided"
    assert diagnosis.statuses["axle_1/right/bearing"].reason.endswith("but the other box of the wheelset is not judged")


def test_beside_a_dead_sensor_a_flat_is_undecided() -> None:
    diagnosis = last(dead(bogie(flats={"axle_1/left": 200.0}), "axle_1/left"))
    assert verdicts(diagnosis, "wheel") == {"axle_1/left": "waiting", "axle_1/right": "undecided"}
    assert diagnosis.statuses["axle_1/left/wheel"].reason == diagnosis.statuses["axle_1/left/sensor"].reason


def test_beside_a_dead_sensor_a_polygon_is_undecided() -> None:
    signals = bogie(polygons={"axle_1/left": (18, 3.0), "axle_1/right": (18, 1.0)})
    assert verdicts(last(dead(signals, "axle_1/left")), "wheel") == {"axle_1/left": "waiting", "axle_1/right": "undecided"}


def test_after_a_gap_of_the_damaged_box_the_other_one_has_no_alarm() -> None:
    signals = bogie({"axle_1/left": {"outer": 2000.0}})
    detector = VehicleDetector(DESCRIPTION, box_parameters=DetectorParameters(window=1.5, least_window=1.0))
    found = diagnosed(signals, block=512, detector=detector, lost=lambda name, k: name == "axle_1/left" and 80000 <= k < 98000)
    assert {one.statuses["axle_1/right/bearing"].verdict for one in found} <= {"waiting", "healthy", "undecided"}


def test_a_sensor_of_twice_the_gain_does_not_take_the_fault() -> None:
    diagnosis = last(bogie({"axle_1/left": {"outer": 7.0}}, across=0.3, gains={"axle_1/right": 2.5}))
    assert diagnosis.damaged() == {"axle_1/left": "outer_ring"}


def test_equal_lines_in_two_boxes_are_undecided() -> None:
    diagnosis = last(bogie({"axle_2/left": {"outer": 200.0}}, across=1.0, along=0.0))
    assert verdicts(diagnosis, "bearing") == {"axle_2/left": "undecided", "axle_2/right": "undecided"}


def test_among_equal_lines_the_box_that_is_earlier_counts() -> None:
    signals, late = bogie({"axle_2/left": {"outer": 200.0}}, across=1.0, along=0.0), round(0.9e-3 * 51200)
    acceleration, angle = signals["axle_2/right"]
    signals["axle_2/right"] = np.roll(acceleration, late, axis=0), angle
    diagnosis = last(signals)
    assert verdicts(diagnosis, "bearing") == {"axle_2/left": "outer_ring"}
    assert "0.9 ms later" in diagnosis.statuses["axle_2/left/bearing"].reason


def test_the_earlier_box_is_known_after_a_late_start_of_the_other_one() -> None:
    """Both turn by 9.4 turns in a hop, which are no whole bins."""
    signals, late = bogie({"axle_2/left": {"outer": 200.0}}, across=1.0, along=0.0), round(0.9e-3 * 51200)
    acceleration, angle = signals["axle_2/right"]
    signals["axle_2/right"] = np.roll(acceleration, late, axis=0), angle
    detector = VehicleDetector(DESCRIPTION, box_parameters=DetectorParameters(window=1.41, least_window=0.94, hop=0.47))
    found = diagnosed(signals, block=512, detector=detector, lost=lambda name, k: name == "axle_2/right" and k < 20000)
    status = found[-1].statuses["axle_2/left/bearing"]
    assert (status.verdict, "0.9 ms later" in status.reason) == ("outer_ring", True), status


def test_two_damaged_bearings_of_a_wheelset_keep_their_components() -> None:
    diagnosis = last(bogie({"axle_1/left": {"outer": 1500.0}, "axle_1/right": {"inner": 2500.0}}))
    assert diagnosis.damaged() == {"axle_1/left": "outer_ring", "axle_1/right": "inner_ring"}


def test_faint_lines_count_where_no_other_box_has_them() -> None:
    signals = bogie({"axle_1/left": {"outer": 1.8}}, across=0.0, along=0.0)
    strict = VehicleDetector(DESCRIPTION, VehicleDetectorParameters(relief=0.0))
    assert not diagnosed(signals, detector=strict)[-1].damaged()
    assert last(signals).damaged() == {"axle_1/left": "outer_ring"}


def test_joints_are_the_tracks_and_damage_no_bearing() -> None:
    diagnosis = last(bogie(joints=np.arange(0.2, SECONDS, 0.43).tolist()))
    assert diagnosis.statuses["track"].verdict == "joint"
    assert verdicts(diagnosis, "bearing") == {}


def test_a_spall_between_joints_is_found() -> None:
    joints = np.arange(0.2, SECONDS, 0.21)
    diagnosis = last(bogie({"axle_1/left": {"outer": 30.0}}, joints=joints.tolist()))
    assert (diagnosis.statuses["track"].verdict, diagnosis.damaged()) == ("joint", {"axle_1/left": "outer_ring"})


@pytest.mark.slow
def test_joints_whose_frequency_divides_that_of_a_fault_damage_no_bearing() -> None:
    """Every joint strikes four times, longer than the part of the time in which envelopes are limited."""
    joints = np.arange(0.2, SECONDS, 18.0 / (ORDERS.bpfo * FREQUENCY))
    diagnosis = last(bogie(joints=np.add.outer(joints, [0.0, 0.0025, 0.005, 0.0075]).ravel().tolist()))
    assert diagnosis.statuses["track"].verdict == "joint"
    assert verdicts(diagnosis, "bearing") == {}


def test_kinks_of_one_rail_are_a_crossing() -> None:
    diagnosis = last(bogie(joints=[0.5, 1.3, 2.2], joint_sides=(0,)))
    assert (diagnosis.statuses["track"].verdict, "left" in diagnosis.statuses["track"].reason) == ("crossing", True)


def test_the_loudness_of_an_impact_does_not_depend_on_how_long_it_rings() -> None:
    times = np.arange(4000) * 1e-3
    found = []
    for ringing in (5, 60):  # of 4 impacts: 0.5 and 6 % of the time
        envelope = np.ones(4000)
        for begin in (500, 1400, 2300, 3200):
            envelope[begin : begin + ringing] = 10.0
            envelope[begin] = 1000.0
        found.append(impacts_of(envelope, times, 6.0, 0.1))
    assert [len(impacts) for impacts, _ in found] == [4, 4]
    assert [impact.loudness for impacts, _ in found for impact in impacts] == pytest.approx([30.0] * 8)
    assert [faintest for _, faintest in found] == pytest.approx([6.0, 16.0])


def test_impacts_that_no_other_wheelset_repeats_are_not_the_tracks() -> None:
    signals = bogie()
    quiet, struck = signals["axle_1/left"], bogie(joints=[0.5, 1.3, 2.2], joint_sides=(0,))["axle_1/left"]
    only_first = struck[0] - 0.0
    for begin in (0.5, 1.3, 2.2):  # without the second passage
        k = slice(round((begin + 0.5 * LAG) * 51200), round((begin + 2.0 * LAG) * 51200))
        only_first[k] = quiet[0][k]
    assert last({**signals, "axle_1/left": (only_first, quiet[1])}).statuses["track"].verdict == "healthy"


@pytest.mark.parametrize("box", [BOXES[0], *(pytest.param(box, marks=pytest.mark.slow) for box in BOXES[1:])])
def test_a_flat_is_its_wheels_and_damages_no_bearing(box: str) -> None:
    diagnosis = last(bogie(flats={box: 60.0}))
    assert verdicts(diagnosis, "wheel") == {box: "flat"}
    assert verdicts(diagnosis, "bearing") == {}


def test_a_flat_that_two_wheels_hear_alike_is_undecided() -> None:
    signals = bogie(flats={"axle_1/left": 60.0})
    diagnosis = last({**signals, "axle_1/right": signals["axle_1/left"]})
    assert verdicts(diagnosis, "wheel") == {"axle_1/left": "undecided", "axle_1/right": "undecided"}


def test_swapped_sensors_are_found_by_the_lag_of_the_rail() -> None:
    signals = bogie()
    signals["axle_1/left"], signals["axle_2/left"] = signals["axle_2/left"], signals["axle_1/left"]
    assert verdicts(last(signals), "sensor") == {"axle_1/left": "swapped", "axle_2/left": "swapped"}


def test_sensors_between_the_compared_wheelsets_are_not_swapped() -> None:
    axles = tuple(replace(DESCRIPTION.axles[0], name=f"axle_{number}", x=2.0 - number) for number in (1, 2, 3))
    boxes = tuple(
        replace(box, name=f"{axle.name}/{box.side}", axle=axle.name) for axle, box in itertools.product(axles, DESCRIPTION.boxes[:2])
    )
    sides = {"left": Lag(0.08, 0.08, forward=0.1, backward=0.9), "right": Lag(0.08, 0.08, forward=0.9, backward=0.1)}
    sensors = VehicleDetector(replace(DESCRIPTION, axles=axles, boxes=boxes))._sensors({}, {}, sides)
    assert {name: status.verdict for name, status in sensors.items()} == {"axle_1/left": "swapped", "axle_3/left": "swapped"}


def test_a_vehicle_that_may_run_backwards_has_no_swapped_sensors() -> None:
    """A tachometer without a direction counts upwards in reverse, when the trailing wheelset leads."""
    signals = bogie()
    reverse = {name: signals[name.translate(str.maketrans("12", "21"))] for name in BOXES}
    assert verdicts(last(reverse), "sensor") == dict.fromkeys(BOXES, "undecided")


@pytest.mark.parametrize("speed", [np.nan, 0.0, 0.09])
def test_a_wheel_that_hardly_turns_is_not_judged(speed: float) -> None:
    """Without an angle, at standstill, and with five turns in 3 s."""
    turned = {
        name: (acceleration, (angle * 0.0 + np.arange(len(angle)) * speed * 20.0 / 51200 % 1.0 * 6.28).astype(np.float32))
        for name, (acceleration, angle) in bogie().items()
    }
    assert verdicts(last(turned), "wheel") == dict.fromkeys(BOXES, "waiting")


def test_the_lag_is_that_of_the_wheelbase() -> None:
    assert last(bogie()).indicators["left/lag"] == pytest.approx(LAG, abs=1.0 / 1600.0)


@pytest.mark.parametrize(("first", "gap"), [(1024, 0), (0, 16000)])
def test_a_box_that_lost_samples_is_compared_over_the_same_time(first: int, gap: int) -> None:
    """The first block of one box, or 0.31 s of it, which restarts its window of 1.5 s."""
    detector = VehicleDetector(DESCRIPTION, box_parameters=DetectorParameters(window=1.5, least_window=1.0))

    def lost(name: str, k: int) -> bool:
        return name == "axle_2/left" and (k < first or 20000 <= k < 20000 + gap)

    diagnoses = diagnosed(bogie(), block=512, detector=detector, lost=lost)
    assert diagnoses[-1].indicators["left/lag"] == pytest.approx(LAG, abs=1.0 / 1600.0)
    assert {status.verdict for one in diagnoses for name, status in one.statuses.items() if name.endswith("sensor")} <= {
        "healthy",
        "waiting",
    }


def test_five_hops_are_judged_wherever_they_begin() -> None:
    samples = round(2.5 * 51200)
    signals = {name: (a[:samples], angle[:samples]) for name, (a, angle) in bogie().items()}
    (diagnosis,) = diagnosed(signals, block=samples, first=dict.fromkeys(BOXES, 1000))
    assert {diagnosis.statuses[f"{name}/bearing"].verdict for name in BOXES} == {"healthy"}


def test_a_box_that_loses_samples_in_every_hop_has_a_faulty_sensor() -> None:
    """A gap of 0.3 s in every 0.6 s, so that no hop of 0.5 s is whole."""
    detector = VehicleDetector(DESCRIPTION, VehicleDetectorParameters(patience=0.5))
    found = diagnosed(bogie(), block=512, detector=detector, lost=lambda name, k: name == "axle_2/left" and k // 15360 % 2 == 1)
    sensors = [one.statuses["axle_2/left/sensor"] for one in found]
    assert (sensors[0].verdict, sensors[0].reason) == ("waiting", "its signal began anew")
    assert (sensors[-1].verdict, sensors[-1].reason) == ("sensor", "its signal has gaps")


@pytest.mark.parametrize("sign", [1, -1])
def test_a_delayed_copy_has_its_lag(sign: int) -> None:
    values = np.random.default_rng(1).normal(size=4000)
    delayed = np.roll(values, sign * 80)
    lag = correlated_lag(values, delayed, 1600.0, sign * 0.05, 0.004)
    assert lag is not None
    assert lag.found == pytest.approx(sign * 0.05, abs=5e-6)  # of 1 / 1600 s between two values
    assert lag.forward > 0.9 > 5.0 * abs(lag.backward)


def test_a_sensor_that_hears_no_rail_is_faulty() -> None:
    signals = bogie(gains={"axle_2/right": 0.05})
    assert verdicts(last(signals), "sensor") == {"axle_2/right": "sensor"}


def test_a_sensor_that_hears_no_rail_is_faulty_beside_one_of_zeros() -> None:
    levels = zip(BOXES, (1.0, 0.5, 0.0, 1e-3), strict=True)
    contacts = {box: Contact(0, level, 1.0, 0.0, 54.0, 27.0, SECONDS, [], 6.0, np.zeros(10), None) for box, level in levels}
    assert silent_boxes(contacts, VehicleDetectorParameters())[BOXES[3]] == pytest.approx(27.0, abs=0.1)


def test_of_two_sensors_no_level_is_compared() -> None:
    signals = bogie(gains={"axle_1/right": 0.05})
    two = VehicleDetector(replace(DESCRIPTION, axles=DESCRIPTION.axles[:1], boxes=DESCRIPTION.boxes[:2]))
    diagnosis = diagnosed({box: signals[box] for box in BOXES[:2]}, detector=two)[-1]
    assert {diagnosis.statuses[f"{box}/sensor"].reason for box in BOXES[:2]} == {"three boxes are needed to compare its level"}


def test_a_box_without_signal_is_said_and_the_others_go_on() -> None:
    signals = bogie({"axle_1/left": SPALLS["outer_ring"]})
    del signals["axle_2/left"]
    diagnosis = diagnosed(signals, detector=VehicleDetector(DESCRIPTION, VehicleDetectorParameters(patience=0.2)))[-1]
    assert verdicts(diagnosis, "sensor") == {"axle_2/left": "sensor"}
    assert diagnosis.damaged() == {"axle_1/left": "outer_ring"}


def test_a_fast_clock_is_seen_in_the_turns() -> None:
    signals = bogie()
    acceleration, angle = signals["axle_1/right"]
    turned = np.unwrap(angle.astype(np.float64)) * (1.0 - 1e-4)
    signals["axle_1/right"] = acceleration, np.mod(turned, 2.0 * np.pi).astype(np.float32)
    diagnosis = last(signals)
    assert diagnosis.indicators["axle_1/clock"] == pytest.approx(-100.0, abs=2.0)
    assert verdicts(diagnosis, "sensor") == {"axle_1/left": "undecided", "axle_1/right": "undecided"}


@pytest.mark.parametrize(("box", "share"), [("axle_1/left", 3e-4), ("axle_1/right", -3e-4), ("axle_2/right", 3e-4)])
def test_the_wrong_clock_is_that_whose_lag_drifts(box: str, share: float) -> None:
    signals = bogie()
    acceleration, angle = signals[box]
    index = np.arange(len(angle), dtype=np.float64)
    at = index / (1.0 + share)
    turned = np.interp(at, index, np.unwrap(angle.astype(np.float64)))
    skewed = np.column_stack([np.interp(at, index, axis) for axis in acceleration.T])
    signals[box] = skewed.astype(np.float32), np.mod(turned, 2.0 * np.pi).astype(np.float32)
    diagnosis = last(signals)
    assert verdicts(diagnosis, "sensor") == {box: "clock"}


def test_left_and_right_swapped_on_one_wheelset_are_undecided() -> None:
    signals = bogie()
    signals["axle_2/left"], signals["axle_2/right"] = signals["axle_2/right"], signals["axle_2/left"]
    assert verdicts(last(signals), "sensor") == dict.fromkeys(BOXES, "undecided")


def test_a_spall_under_rough_wheels_is_found() -> None:
    signals = bogie({"axle_1/left": {"outer": 3.0}})
    turn = round(51200 / FREQUENCY)
    for number, (acceleration, _) in enumerate(signals.values()):
        rough = np.random.default_rng(number).normal(scale=12.0, size=turn)
        acceleration[:, 1] += np.resize(rough, len(acceleration)).astype(np.float32)
    diagnosis = last(signals)
    assert diagnosis.boxes["axle_1/left"].verdict == "healthy"
    assert diagnosis.damaged() == {"axle_1/left": "outer_ring"}


def test_a_healthy_bogie_has_no_verdict_but_healthy() -> None:
    diagnosis = last(bogie())
    assert {status.verdict for status in diagnosis.statuses.values()} == {"healthy"}


def comparable(diagnoses: list[VehicleDiagnosis]) -> list[Any]:
    """Return what must not depend on the size of the blocks."""
    return [(d.index, dict(d.statuses), dict(d.indicators)) for d in diagnoses]


@pytest.mark.parametrize("block", [333, 25600])
def test_diagnoses_do_not_depend_on_the_size_of_the_blocks(block: int) -> None:
    signals = bogie({"axle_1/left": SPALLS["inner_ring"]}, flats={"axle_2/left": 60.0}, joints=[0.6, 1.7], **TURNED)
    assert comparable(diagnosed(signals, block=block)) == comparable(diagnosed(signals, block=1024))


def test_the_last_diagnosis_of_one_whole_block_is_that_of_the_stream() -> None:
    signals = bogie({"axle_1/left": SPALLS["roller"]})
    assert comparable(diagnosed(signals, block=10**6))[-1] == comparable(diagnosed(signals, block=1024))[-1]


def test_blocks_of_boxes_may_arrive_one_after_the_other() -> None:
    signals = bogie({"axle_1/left": SPALLS["outer_ring"]})
    assert comparable(diagnosed(signals, together=False)) == comparable(diagnosed(signals))


def test_an_unknown_box_is_refused_by_name() -> None:
    with pytest.raises(Refusal, match="no box 'axle_1/lefft'; did you mean 'axle_1/left'"):
        VehicleDetector(DESCRIPTION).add({"axle_1/lefft": BoxBlock(0, np.zeros((10, 2)), np.zeros(10))})


@pytest.mark.parametrize(
    ("blocks", "message"), [(None, "blocks is a NoneType"), ({"axle_1/left": 3}, "3 is not a block of axle_1/left: give a BoxB")]
)
def test_what_is_no_block_is_refused(blocks: Any, message: str) -> None:
    with pytest.raises(Refusal, match=message):
        VehicleDetector(DESCRIPTION).add(blocks)


@pytest.mark.parametrize(("acceleration", "angle"), [(np.array(1.0), np.zeros(10)), (np.zeros((10, 2)), np.array(1.0)), (None, None)])
def test_arrays_without_dimensions_are_refused(acceleration: Any, angle: Any) -> None:
    with pytest.raises(Refusal, match=r"a block of axle_1/left has an array without dimensions: give acceleration \(samples, axes\)"):
        VehicleDetector(DESCRIPTION).add({"axle_1/left": BoxBlock(0, acceleration, angle)})


def test_bands_without_a_width_are_refused() -> None:
    with pytest.raises(Refusal, match="are empty"):
        VehicleDetector(DESCRIPTION, VehicleDetectorParameters(wheel_low=9000.0, wheel_high=8000.0))


def test_a_baseline_is_refused() -> None:
    with pytest.raises(Refusal, match=r"baseline = b\.yaml is the baseline of a single bearing: leave it out for a vehicle"):
        VehicleDetector(DESCRIPTION, box_parameters=DetectorParameters(baseline="b.yaml"))


@pytest.mark.parametrize("whitening", [pytest.param(0.0, marks=pytest.mark.slow), 5.0, pytest.param(100.0, marks=pytest.mark.slow)])
def test_the_width_of_whitening_is_not_that_of_tones(whitening: float) -> None:
    detector = VehicleDetector(DESCRIPTION, box_parameters=DetectorParameters(whitening=whitening))
    diagnosis = diagnosed(bogie({"axle_1/left": SPALLS["outer_ring"]}), detector=detector)[-1]
    assert verdicts(diagnosis, "bearing") == {"axle_1/left": "outer_ring"}


def recording(
    signals: Boxes, length: int = 5120, lost: Mapping[str, slice] = MappingProxyType({}), ranges: Mapping[str, float] = MappingProxyType({})
) -> Any:
    """Return a recording of signals in pieces of a length, without the ``lost`` pieces of some boxes; ``ranges`` are those of sensors."""
    boxes = {}
    for name, signal in signals.items():
        pieces = [Piece(k, *(part[k : k + length] for part in signal), ranges.get(name, 0.0)) for k in range(0, len(signal[1]), length)]
        del pieces[lost.get(name, slice(0))]
        boxes[name.replace("/", ".")] = SimpleNamespace(pieces=partial(iter, pieces), sampling_rate=DESCRIPTION.sampling_rate)
    return SimpleNamespace(description=DESCRIPTION, boxes=boxes)


def test_a_box_that_lost_blocks_of_a_recording_is_compared_over_the_same_time() -> None:
    """Without 1.2 s of one box, whose pieces then have other numbers than those of the others."""
    recorded = recording(bogie({"axle_1/left": SPALLS["outer_ring"]}), lost={"axle_2/left": slice(4, 16)})
    result = detect_vehicle(recorded, box_parameters=DetectorParameters(window=1.0, least_window=1.0))
    assert result.statuses["axle_2/left/sensor"].reason == "it measures the rail as the others do"
    assert result.damaged == {"axle_1/left": "outer_ring"}


@pytest.mark.parametrize(("lost", "sensor"), [(slice(None), "sensor"), (slice(-4, None), "waiting")])
def test_the_end_of_a_recording_is_judged_without_a_box(lost: slice, sensor: str) -> None:
    """One of the boxes is missing, or ends 0.4 s before the others."""
    result = detect_vehicle(recording(bogie({"axle_1/left": SPALLS["outer_ring"]}), lost={"axle_2/left": lost}))
    assert result.last.time == pytest.approx(SECONDS, abs=1e-4)
    assert result.last.statuses["axle_2/left/sensor"].verdict == sensor
    assert result.damaged == {"axle_1/left": "outer_ring"}


@pytest.mark.parametrize(
    ("verdict", "causes"), [("flat", {"flats": {"axle_2/left": 200.0}}), ("polygon", {"polygons": {"axle_2/left": (18, 3.0)}})]
)
def test_what_is_confirmed_remains_if_the_other_boxes_of_the_wheelsets_end_earlier(verdict: str, causes: dict[str, Any]) -> None:
    """A corrugation, which the spall resembles, is judged by all boxes only."""
    signals, right = bogie({"axle_1/left": {"outer": 2000.0}}, **causes), ("axle_1/right", "axle_2/right")
    whole, shorter = (detect_vehicle(recording(signals, lost=lost)) for lost in ({}, dict.fromkeys(right, slice(-1, None))))
    assert shorter.last.statuses["axle_1/right/bearing"].reason == "its signal has ended"
    expected, found = ({name: s.verdict for name, s in each.statuses.items() if name != "track"} for each in (whole, shorter))
    assert (found, found["axle_2/left/wheel"]) == (expected, verdict)
    bearing = shorter.last.statuses["axle_1/left/bearing"]
    assert (bearing.verdict, bearing.score) == ("outer_ring", pytest.approx(whole.last.statuses["axle_1/left/bearing"].score, abs=1.0))


def test_what_is_confirmed_remains_beside_a_gap_in_the_other_boxes_of_the_wheelsets() -> None:
    """The gap restarts windows of 1 s, which are longer than a fault without evidence remains."""
    signals = bogie({"axle_1/left": {"outer": 2000.0}}, flats={"axle_2/left": 200.0})
    recorded = recording(signals, lost=dict.fromkeys(("axle_1/right", "axle_2/right"), slice(15, 18)))
    result = detect_vehicle(recorded, box_parameters=DetectorParameters(window=1.0, least_window=1.0, release=2))
    found = [(one.statuses["axle_1/left/bearing"].verdict, one.statuses["axle_2/left/wheel"].verdict) for one in result.history]
    assert "waiting" in {one.statuses["axle_1/right/bearing"].verdict for one in result.history[-3:]}
    assert found[-3:] == [("outer_ring", "flat")] * 3, found


def test_another_sampling_rate_than_that_of_the_description_is_refused() -> None:
    recorded = recording(bogie())
    recorded.boxes["axle_1.right"].sampling_rate = 25600
    with pytest.raises(Refusal, match=r"axle_1/right is sampled at 25600 Hz, .* 51200 Hz: resample it"):
        detect_vehicle(recorded)


def test_the_diagnoses_of_a_recording_do_not_depend_on_the_length_of_its_pieces() -> None:
    signals = bogie({"axle_1/left": SPALLS["outer_ring"]})
    expected = comparable(diagnosed(signals))
    assert [comparable(list(detect_vehicle(recording(signals, length)).history)) for length in (1000, 10**6)] == [expected, expected]


def test_of_a_recording_the_last_diagnosis_alone_has_spectra() -> None:
    result = detect_vehicle(recording(bogie()))
    spectra = [{name for name, box in diagnosis.boxes.items() if len(box.spectrum[0])} for diagnosis in result.history]
    assert spectra == [set()] * (len(spectra) - 1) + [set(BOXES)]


def test_the_limits_of_each_box_are_learned_for_their_time() -> None:
    """From the first judgement on, at the fourth hop of half a second."""
    found = diagnosed(bogie(), detector=VehicleDetector(DESCRIPTION, box_parameters=DetectorParameters(learn=10.0)))
    remarks = [[box.baseline for box in diagnosis.boxes.values()] for diagnosis in found]
    assert remarks[-1] == ["learning for another 8.5 s: outer-ring defects are not reported yet"] * len(BOXES)


def test_the_evidence_required_depends_on_the_length_of_the_window(monkeypatch: pytest.MonkeyPatch) -> None:
    windows: list[float] = []
    monkeypatch.setattr("dcrb_ros.diagnosis.vehicle.detector.least_evidence", lambda _, window, least: windows.append(window) or least)
    diagnosed(bogie(), detector=VehicleDetector(DESCRIPTION, box_parameters=DetectorParameters(window=1.5, least_window=1.0)))
    assert set(windows) == {1.0, 1.5}


def heated(signals: Boxes, hot: str) -> VehicleDiagnosis:
    """Return the last diagnosis of signals with readings of 170 degrees C at a box from 1 s on."""
    time = np.arange(1.0, SECONDS, 0.2)
    readings = TemperatureReadings(time=time, outer_ring=np.full(len(time), 170.0), box=time * np.nan, ambient=np.full(len(time), 20.0))
    recorded = recording(signals)
    recorded.boxes[hot.replace("/", ".")].temperatures = readings
    return detect_vehicle(recorded).last


@pytest.mark.parametrize("hot", ["axle_1/left", "axle_1/right"])
def test_a_hot_box_is_overheated_beside_lines_of_its_own_or_of_another_box(hot: str) -> None:
    diagnosis = heated(bogie({"axle_1/left": {"outer": 2000.0}}), hot)
    assert diagnosis.boxes[hot].verdict == "compound"
    own = {"axle_1/left": "compound"} if hot == "axle_1/left" else {"axle_1/left": "outer_ring", hot: "overheating"}
    assert verdicts(diagnosis, "bearing") == own


def test_a_hot_box_whose_lines_are_undecided_is_overheated() -> None:
    diagnosis = heated(bogie({"axle_2/left": {"outer": 200.0}}, across=1.0, along=0.0), "axle_2/left")
    assert verdicts(diagnosis, "bearing") == {"axle_2/left": "overheating", "axle_2/right": "undecided"}


def test_the_sensor_of_a_hot_box_may_be_faulty() -> None:
    signals, hot = bogie(), "axle_2/right"
    diagnosis = heated({**signals, hot: (np.full_like(signals[hot][0], 3.0), signals[hot][1])}, hot)
    assert verdicts(diagnosis, "bearing") == {hot: "overheating"}
    assert verdicts(diagnosis, "sensor") == {hot: "sensor"}


@pytest.mark.parametrize(("stated", "verdict"), [(5000.0, "sensor"), (8.0, None), (0.0, "sensor")])
def test_the_range_of_a_sensor_may_change_in_a_recording(stated: float, verdict: str | None) -> None:
    signals, box = bogie(), "axle_2/right"
    clipped = {**signals, box: (np.clip(signals[box][0], -8.0, 8.0), signals[box][1])}
    recorded = recording(clipped, ranges=dict.fromkeys(BOXES, 5000.0) | {box: stated})
    recorded.description = replace(DESCRIPTION, boxes=tuple(replace(each, sensor_range=5000.0) for each in DESCRIPTION.boxes))
    diagnosis = detect_vehicle(recorded).last
    assert verdicts(diagnosis, "sensor") == ({box: verdict} if verdict else {})


@pytest.mark.parametrize(
    ("verdicts", "summary"),
    [
        (("healthy", "healthy"), "no bearing damaged"),
        (("outer_ring", "healthy"), "axle_1/left outer_ring"),
        (("outer_ring", "waiting"), "axle_1/left outer_ring, no verdict on 1 of 2 bearings"),
        (("undecided", "waiting"), "no verdict on 2 of 2 bearings"),
    ],
)
def test_bearings_without_a_verdict_are_not_called_undamaged(verdicts: tuple[str, str], summary: str) -> None:
    statuses = {f"axle_1/{side}/bearing": Status(verdict, "") for side, verdict in zip(("left", "right"), verdicts, strict=True)}
    result = VehicleDetectionResult((VehicleDiagnosis(0, 1.0, {**statuses, "track": Status("healthy", "")}, {}),))
    assert result.summary == summary
    assert summary in repr(result)


@pytest.mark.parametrize("silent", [None, BOXES[0], *(pytest.param(box, marks=pytest.mark.slow) for box in BOXES[1:])])
def test_after_a_restart_the_boxes_are_compared_again(silent: str | None) -> None:
    """The blocks of the boxes arrive one after the other, as at a node; one of them may be silent from then on."""
    signals, detector = bogie(), VehicleDetector(DESCRIPTION)
    diagnosed(signals, detector=detector, first=dict.fromkeys(BOXES, 1_000_000), together=False)
    found = diagnosed(signals, detector=detector, lost=lambda name, _: name == silent, together=False)
    reasons = {one.statuses[f"{name}/sensor"].reason for one in found for name in BOXES if name != silent}
    assert reasons == {"it measures the rail as the others do"}


def test_after_a_restart_a_flat_is_confirmed_again() -> None:
    detector, samples = VehicleDetector(DESCRIPTION), round(1.6 * 51200)
    signals = {name: (a[:samples], angle[:samples]) for name, (a, angle) in bogie(flats={"axle_1/left": 60.0}).items()}
    found = [one for start in (1_000_000, 0) for one in diagnosed(signals, detector=detector, first=dict.fromkeys(BOXES, start))]
    assert [one.statuses["axle_1/left/wheel"].verdict for one in found] == ["waiting", "flat", "flat"] * 2


@pytest.mark.parametrize(("counted", "reason"), [(0, "22.5 s behind"), (90_000_000, "1735.3 s ahead of")])
def test_a_box_that_counts_its_samples_otherwise_does_not_silence_the_others(counted: int, reason: str) -> None:
    """One box begins to count anew, or its count jumps; the others go on, and are diagnosed without it."""
    signals, detector, later = bogie(), VehicleDetector(DESCRIPTION), 1_153_600
    before = dict.fromkeys(BOXES, later - len(signals[BOXES[0]][1]))
    starts = before, dict.fromkeys(BOXES, later) | {BOXES[0]: counted}
    found = [one for first in starts for one in diagnosed(signals, detector=detector, first=first, together=False)]
    indices = [one.index for one in found]
    assert indices == sorted(set(indices))
    assert verdicts(found[-1], "sensor") == {BOXES[0]: "sensor"}
    assert found[-1].statuses[f"{BOXES[0]}/sensor"].reason == f"its samples are {reason} those of the others"
    assert found[-1].statuses[f"{BOXES[0]}/bearing"].verdict == "waiting"
    assert max(len(watch.hops) for watch in detector._boxes.values()) <= 1
