"""Responses of the detector node to messages, without ROS: every message that cannot be used is answered."""

from __future__ import annotations

import json

import numpy as np
import pytest
from made_up_blocks import blocks

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.description import sensor_text
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import SPECTRUM, UNTRACKED_SAMPLE, decode_vibration, encode_points, encode_vibration
from dcrb_ros.nodes.detector_input import MAX_EARLY, DetectorInput, Response
from dcrb_ros.settings.configuration import Configuration

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


def test_blocks_without_a_description_are_answered() -> None:
    detector = DetectorInput(DetectorParameters())
    assert all(detector.block(waveform()[0]) == Response() for _ in range(MAX_EARLY))
    assert "no description on outer_ring/sensor" in reason(detector.block(waveform()[0]))


@pytest.mark.parametrize("late", [1, MAX_EARLY])
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


@pytest.mark.parametrize("rate", [25600, 102400])
def test_a_rate_that_contradicts_the_description_is_answered(rate: int) -> None:
    assert f"mean {1e9 / RATE:.0f} ns" in reason(described_input().block(waveform(rate=rate)[0]))


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
