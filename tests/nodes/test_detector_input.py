"""Responses of the detector node to messages, without ROS: every message that cannot be used is answered."""

from __future__ import annotations

import dataclasses
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_blocks import blocks
from ros2_bag_record import messages_of
from synthetic_bogie import DESCRIPTION as BOGIE

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.description import sensor_text
from dcrb_ros.messages.plain import encode_temperature, encode_text
from dcrb_ros.messages.points import SPECTRUM, UNTRACKED_SAMPLE, decode_vibration, encode_points, encode_vibration
from dcrb_ros.messages.topics import SENSOR, VIBRATION
from dcrb_ros.nodes import detector_input
from dcrb_ros.nodes.detector_input import AMBIENT_AGE, DetectorInput, Response, StampedRate
from dcrb_ros.nodes.vehicle_detector_input import VehicleDetectorInput, VehicleDetectorSettings
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.diagnosis import Diagnosis

RATE = 51200


def described(**changes: object) -> bytes:
    return encode_text(json.dumps({**json.loads(sensor_text(Configuration())), **changes}))


def waveform(count: int = 1, *, rate: int = RATE) -> list[bytes]:
    return [encode_vibration(block, block.acceleration) for block in blocks(count, rate=rate)]


def described_input() -> DetectorInput:
    found = DetectorInput(DetectorParameters())
    assert "51200 Hz" in found.sensor(described()).information
    return found


def reason(response: Response) -> str:
    (diagnosis,) = response.diagnoses
    assert diagnosis.verdict == "waiting"
    assert response.warning
    return diagnosis.reason


def test_the_range_of_a_box_follows_the_description_of_its_sensor() -> None:
    detector, box = VehicleDetectorInput(VehicleDetectorSettings()), "axle_1/left"
    assert detector.sensor(described(range=50.0), box) == Response()  # before the description of the vehicle
    detector.describe(encode_text(BOGIE.to_json()))
    assert detector._detector is not None
    watch = detector._detector._boxes[box].detector
    for stated, taken in ((50.0, 50.0), (None, 50.0), (80.0, 80.0)):
        assert detector.sensor(described(range=stated), box) == Response()
        assert watch.sensor_range == taken
    assert detector.sensor(b"", box).warning


def test_blocks_without_a_description_are_answered() -> None:
    detector = DetectorInput(DetectorParameters())
    *early, late = waveform(77)  # the last one begins 1.52 s after the first
    assert all(detector.block(data) == Response() for data in early)
    assert "no description on outer_ring/sensor" in reason(detector.block(late))


def test_a_bounded_number_of_samples_is_kept_without_a_description(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(detector_input, "MAX_EARLY", 3 * 1024)
    detector = DetectorInput(DetectorParameters())
    same = waveform()[0]
    assert [detector.block(same) == Response() for _ in range(4)] == [True, True, True, False]


def test_a_bounded_number_of_blocks_is_kept_without_a_description(monkeypatch: pytest.MonkeyPatch) -> None:
    # The smallest block takes half a kilobyte.
    monkeypatch.setattr(detector_input, "MAX_EARLY_BLOCKS", 3)
    detector = DetectorInput(DetectorParameters())
    same = waveform()[0]
    assert [detector.block(same) == Response() for _ in range(4)] == [True, True, True, False]


@pytest.mark.parametrize("late", [1, 51, 76])
def test_a_description_may_arrive_after_the_first_blocks(late: int) -> None:
    messages = waveform(100)
    in_time, detector = described_input(), DetectorInput(DetectorParameters())
    expected = [diagnosis for data in messages for diagnosis in in_time.block(data).diagnoses]
    found = [diagnosis for data in messages[:late] for diagnosis in detector.block(data).diagnoses]
    found += detector.sensor(described()).diagnoses
    found += [diagnosis for data in messages[late:] for diagnosis in detector.block(data).diagnoses]
    assert len(found) > 2
    assert [(d.index, d.verdict, d.reason) for d in found] == [(d.index, d.verdict, d.reason) for d in expected]


def test_early_blocks_that_contradict_the_description_are_answered() -> None:
    detector = DetectorInput(DetectorParameters())
    detector.block(waveform()[0])
    assert f"mean {1e9 / 25600:.0f} ns" in reason(detector.sensor(described(sampling_rate=25600)))


def test_other_fields_are_answered() -> None:
    assert "must have t, ax, ay and shaft_angle" in reason(described_input().block(encode_points(np.zeros(8, SPECTRUM), 0)))


def test_malformed_messages_are_answered() -> None:
    assert "refused" in reason(described_input().block(b"\xff" * 12))
    assert "refused" in reason(described_input().sensor(described(sampling_rate="fast")))


@pytest.mark.parametrize("rate", [25600, 102400, round(1.02 * RATE), round(0.98 * RATE)])
def test_a_rate_that_contradicts_the_description_is_answered(rate: int) -> None:
    assert f"mean {1e9 / RATE:.0f} ns" in reason(described_input().block(waveform(rate=rate)[0]))


@pytest.mark.parametrize("rate", [round(1.005 * RATE), round(0.995 * RATE)])
def test_a_rate_within_one_per_cent_of_the_description_is_accepted(rate: int) -> None:
    assert described_input().block(waveform(rate=rate)[0]) == Response()


@pytest.mark.parametrize("rate", [51149, 51251])
@pytest.mark.parametrize("lost", [(), (10, 11)])
def test_a_rate_that_the_stamps_contradict_is_remarked(rate: int, lost: tuple[int, ...]) -> None:
    detector, sentence = described_input(), f"the stamps give {rate} Hz, not the 51200 Hz of the description: publish the true rate"
    responses = [detector.block(data) for number, data in enumerate(waveform(150, rate=rate)) if number not in lost]
    assert [response.warning for response in responses if response.warning] == [sentence]
    assert sentence in [diagnosis for response in responses for diagnosis in response.diagnoses][-1].remarks


def test_stamps_that_jitter_are_no_wrong_rate() -> None:
    """A driver that stamps each block when it has arrived, with 0.5 ms of jitter in blocks of 0.1 s."""
    random, stamped = np.random.default_rng(5), StampedRate(RATE)
    for number in range(6000):
        jitter = round(1e9 * float(np.clip(random.normal(0.0, 5e-4), -9e-4, 9e-4)))
        stamped.add(SimpleNamespace(stamp_ns=number * 100_000_000 + jitter, shaft_angle=np.zeros(5120)))  # type: ignore[arg-type]
        assert stamped.wrong == ""


def test_lost_and_repeated_blocks_are_no_wrong_rate() -> None:
    detector, sent = (
        described_input(),
        [data for number, data in enumerate(waveform(150)) if number % 9 for _ in range(1 + (number % 5 == 0))],
    )
    assert not any(detector.block(data).warning for data in sent)


def test_answers_become_rarer_and_give_the_count() -> None:
    detector = described_input()
    responses = [detector.block(waveform(rate=25600)[0]) for _ in range(20)]
    assert [k + 1 for k, response in enumerate(responses) if response.diagnoses] == [1, 2, 4, 8, 16]
    assert "16 so far" in responses[15].warning


def test_a_repeated_description_or_another_range_does_not_restart_the_detector() -> None:
    detector = described_input()
    assert detector.sensor(described()).information == ""
    assert detector.sensor(described(range=500.0)) == Response()
    assert "25600 Hz" in detector.sensor(described(sampling_rate=25600)).information


def test_blocks_without_shaft_angle_are_accepted() -> None:
    points = np.zeros(64, UNTRACKED_SAMPLE)
    points["t"], points["ax"] = np.arange(64) * 19531, np.arange(64)
    data = encode_points(points, 0)
    found = decode_vibration(data)
    assert np.isnan(found.shaft_angle).all()
    assert found.acceleration[:, 0].tolist() == list(range(64))
    assert described_input().block(data) == Response()


def test_blocks_lead_to_diagnoses() -> None:
    detector = described_input()
    diagnoses = [diagnosis for data in waveform(60) for diagnosis in detector.block(data).diagnoses]
    assert [diagnosis.index for diagnosis in diagnoses] == [25599, 51199]


@pytest.mark.parametrize("offset", [0.0, 0.02, 0.5, 1.01, 1.99])
def test_a_recording_played_from_any_offset_is_diagnosed(offset: float) -> None:
    """As `ros2 bag play --start-offset` sends it: the description comes within a second, and no block before it is lost."""
    sent = [message for message in messages_of(250) if message.time_ns >= offset * 1e9]
    played, in_time = DetectorInput(DetectorParameters()), described_input()
    found = [
        diagnosis
        for message in sent
        if message.topic in (SENSOR, VIBRATION)
        for diagnosis in (played.sensor if message.topic == SENSOR else played.block)(message.data).diagnoses
    ]
    expected = [diagnosis for message in sent if message.topic == VIBRATION for diagnosis in in_time.block(message.data).diagnoses]
    assert [(d.index, d.verdict, d.reason) for d in found] == [(d.index, d.verdict, d.reason) for d in expected]
    assert found[-1].verdict != "waiting"


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"window": 1.0, "hop": 2.0}, "window = 1 s is below hop = 2 s"),
        ({"slowest": 80.0}, "slowest = 80 Hz is not below fastest = 70 Hz"),
        ({"hop": 0.1, "band_low": 200.0}, "hop = 0.1 s is below 0.2 s, the least for a band from 200 Hz"),
        ({"baseline": "nowhere.yaml"}, "nowhere.yaml"),
    ],
)
def test_parameters_that_no_detector_accepts_are_refused_before_a_description_arrives(values: dict[str, Any], sentence: str) -> None:
    parameters = DetectorParameters(**values)
    with pytest.raises(Refusal, match=sentence):
        DetectorInput(parameters)
    with pytest.raises(Refusal, match=sentence):
        VehicleDetectorInput(VehicleDetectorSettings(boxes=parameters))


def test_the_boxes_of_a_vehicle_have_no_baseline_in_common() -> None:
    with pytest.raises(Refusal, match=r"baseline = bearing\.yaml is the baseline of a single bearing: leave it out"):
        VehicleDetectorInput(VehicleDetectorSettings(boxes=DetectorParameters(baseline="bearing.yaml")))


def test_a_description_that_no_detector_accepts_is_refused_every_time() -> None:
    detector = DetectorInput(DetectorParameters())
    slow = described(sampling_rate=100)  # the band of the detector begins above half of it
    first = reason(detector.sensor(slow))
    assert "band_low" in first
    assert reason(detector.sensor(slow)).startswith(first.rpartition(" (")[0])
    answers = [response for data in waveform(90) if (response := detector.block(data)).diagnoses]
    assert all("band_low" in reason(response) for response in answers)  # not that a description is lacking
    assert answers
    assert detector.sensor(described()).information


def test_a_refused_description_ends_the_detector_of_the_former_bearing() -> None:
    detector, messages = described_input(), waveform(90)
    assert "band_low" in reason(detector.sensor(described(sampling_rate=100)))
    found = [diagnosis for data in messages for diagnosis in detector.block(data).diagnoses]
    assert found
    assert all(diagnosis.verdict == "waiting" and "band_low" in diagnosis.reason for diagnosis in found)
    assert detector.sensor(described()).information  # the former bearing is watched again


def test_a_refused_description_ends_the_detector_of_the_former_vehicle() -> None:
    detector = VehicleDetectorInput(VehicleDetectorSettings())
    assert detector.describe(encode_text(BOGIE.to_json())).information
    assert "band_low" in detector.describe(encode_text(dataclasses.replace(BOGIE, sampling_rate=2000).to_json())).warning
    assert detector.description is None
    answers = [detector.block(data, "axle_1/left").warning for data in waveform(3)]
    assert "band_low" in answers[0]  # the second refusal; the third is counted only
    assert detector.describe(encode_text(BOGIE.to_json())).information
    assert not any(detector.block(data, "axle_1/left").warning for data in waveform(3))


def heated(rise: float, air_at: float = 0.0) -> list[Diagnosis]:
    """Return the diagnoses of blocks with a reading of the outer ring after each, above air of 20 deg C that was read once."""
    detector = described_input()
    assert detector.ambient(encode_temperature(round(air_at * 1e9), 20.0, 0.2)) == Response()
    found: list[Diagnosis] = []
    for number, data in enumerate(waveform(120)):
        found += detector.block(data).diagnoses
        assert detector.temperature(encode_temperature(number * 20_000_000, 20.0 + rise, 0.2)) == Response()
    return found


def test_temperatures_reach_the_detector() -> None:
    assert heated(30.0)[-1].remarks[-1].startswith("the bearing is 30.0 K above ambient")
    assert heated(200.0)[-1].verdict == "overheating"


def test_a_bearing_is_not_compared_with_air_of_another_time() -> None:
    for late in (3600.0, AMBIENT_AGE + 2.5):  # the readings of the bearing end at 2.38 s
        last = heated(200.0, air_at=late)[-1]
        assert "overheating" not in last.scores
        assert any("temperatures of the outer ring had no reading of the air within 60 s, and were not used" in one for one in last.remarks)
    assert AMBIENT_AGE == 60.0


class Compared(DetectorInput):
    """Keeps the times [s] and temperatures [deg C] that are compared."""

    def __init__(self, *readings: tuple[str, float, float]) -> None:
        """Take readings of the ``ring`` or the ``air``, each with its time [s] and temperature [deg C]."""
        super().__init__(DetectorParameters())
        self.taken: list[tuple[float, float, float]] = []
        for place, time, temperature in readings:
            data = encode_temperature(round(time * 1e9), temperature, 0.2)
            assert (self.ambient if place == "air" else self.temperature)(data) == Response()

    def take_temperature(self, box: str, time: float, temperature: float, air: float) -> None:
        self.taken.append((time, temperature, air))


@pytest.mark.parametrize("order", [("ring", "air"), ("air", "ring")])
def test_readings_of_one_time_are_compared_in_any_order(order: tuple[str, str]) -> None:
    temperature = {"ring": 50.0, "air": 20.0}
    detector = Compared(*((place, float(time), temperature[place] + time) for time in range(3) for place in order))
    assert detector.taken == [(0.0, 50.0, 20.0), (1.0, 51.0, 21.0), (2.0, 52.0, 22.0)]


def test_air_that_is_read_rarely_is_compared_with_later_readings_of_the_ring() -> None:
    detector = Compared(("air", 0.0, 20.0), ("ring", 1.0, 51.0), ("ring", 2.0, 52.0), ("air", 2.5, 22.0), ("ring", 3.0, 53.0))
    assert detector.taken == [(1.0, 51.0, 20.0), (2.0, 52.0, 22.0)]


def test_air_that_is_read_later_and_arrives_first_is_compared() -> None:
    readings = [reading for k in range(1, 6) for reading in (("air", 120.0 * k + 0.5, 20.0), ("ring", 120.0 * k, 50.0))]
    detector = Compared(*readings)
    assert (len(detector.taken), detector.unpaired) == (5, 0)


@pytest.mark.parametrize("apart", [-1.0, 1.0, 50.0])
def test_readings_that_are_far_apart_are_compared_with_the_nearest_air(apart: float) -> None:
    times = sorted(
        [*(("ring", 120.0 * k) for k in range(1, 6)), *(("air", 120.0 * k + apart) for k in range(1, 7))], key=lambda one: one[1]
    )
    detector = Compared(*((place, time, 20.0 + time) for place, time in times))
    assert [(ring, air) for _, ring, air in detector.taken] == [(20.0 + 120.0 * k, 20.0 + 120.0 * k + apart) for k in range(1, 6)]
    assert detector.unpaired == 0


def test_air_before_a_reset_is_not_compared() -> None:
    detector = Compared(("air", 9.0, 29.0), ("ring", 10.0, 60.0), ("ring", 0.0, 50.0), ("ring", 1.0, 51.0), ("air", 1.0, 21.0))
    assert detector.taken == [(1.0, 51.0, 21.0)]


def test_malformed_temperatures_are_answered() -> None:
    detector = described_input()
    assert "refused" in reason(detector.ambient(b"\xff" * 3))
    assert "refused" in reason(detector.temperature(b"\xff" * 3))
