"""What the detector's node answers to messages, without ROS: nothing that it cannot use goes unanswered."""

from __future__ import annotations

import json

import numpy as np
import pytest
from made_up_blocks import blocks

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.description import sensor_text
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import SPECTRUM, UNTRACKED_SAMPLE, decode_vibration, encode_points, encode_vibration
from dcrb_ros.nodes.detector_input import HELD, Hearing, Said
from dcrb_ros.settings.configuration import Configuration

RATE = 51200


def described(**changes: object) -> bytes:
    return encode_text(json.dumps({**json.loads(sensor_text(Configuration())), **changes}))


def waveform(count: int = 1, *, rate: int = RATE) -> list[bytes]:
    return [encode_vibration(block, block.acceleration) for block in blocks(count, rate=rate)]


def hearing() -> Hearing:
    found = Hearing(DetectorParameters())
    assert "51200 Hz" in found.sensor(described()).news
    return found


def reason(said: Said) -> str:
    (diagnosis,) = said.diagnoses
    assert diagnosis.verdict == "waiting"
    assert said.complaint
    return diagnosis.reason


def test_blocks_without_a_description_are_answered() -> None:
    heard = Hearing(DetectorParameters())
    assert all(heard.block(waveform()[0]) == Said() for _ in range(HELD))
    assert "no description on outer_ring/sensor" in reason(heard.block(waveform()[0]))


@pytest.mark.parametrize("late", [1, HELD])
def test_a_description_may_come_after_the_first_blocks(late: int) -> None:
    messages = waveform(100)
    in_time, heard = hearing(), Hearing(DetectorParameters())
    expected = [diagnosis for data in messages for diagnosis in in_time.block(data).diagnoses]
    found = [diagnosis for data in messages[:late] for diagnosis in heard.block(data).diagnoses]
    found += heard.sensor(described()).diagnoses
    found += [diagnosis for data in messages[late:] for diagnosis in heard.block(data).diagnoses]
    assert len(found) > 2
    assert [(d.index, d.verdict, d.reason) for d in found] == [(d.index, d.verdict, d.reason) for d in expected]


def test_blocks_that_do_not_fit_the_description_after_them_are_answered() -> None:
    heard = Hearing(DetectorParameters())
    heard.block(waveform()[0])
    assert f"mean {1e9 / 25600:.0f} ns" in reason(heard.sensor(described(sampling_rate=25600)))


def test_other_fields_are_answered() -> None:
    assert "must have t, ax, ay and shaft_angle" in reason(hearing().block(encode_points(np.zeros(8, SPECTRUM), 0)))


def test_bytes_that_are_no_message_are_answered() -> None:
    assert "refused" in reason(hearing().block(b"\xff" * 12))
    assert "refused" in reason(hearing().sensor(described(sampling_rate="fast")))


@pytest.mark.parametrize("rate", [25600, 102400])
def test_another_rate_than_described_is_answered(rate: int) -> None:
    assert f"mean {1e9 / RATE:.0f} ns" in reason(hearing().block(waveform(rate=rate)[0]))


def test_refusals_become_rarer_and_are_counted() -> None:
    heard = hearing()
    said = [heard.block(waveform(rate=25600)[0]) for _ in range(20)]
    assert [k + 1 for k, one in enumerate(said) if one.diagnoses] == [1, 2, 4, 8, 16]
    assert "16 so far" in said[15].complaint


def test_description_repeated_or_with_another_range_begins_nothing_anew() -> None:
    heard = hearing()
    assert heard.sensor(described()).news == ""
    assert heard.sensor(described(range=500.0)) == Said()
    assert "25600 Hz" in heard.sensor(described(sampling_rate=25600)).news


def test_blocks_without_shaft_angle_are_heard() -> None:
    points = np.zeros(64, UNTRACKED_SAMPLE)
    points["t"], points["ax"] = np.arange(64) * 19531, np.arange(64)
    data = encode_points(points, 0)
    found = decode_vibration(data)
    assert np.isnan(found.shaft_angle).all()
    assert found.acceleration[:, 0].tolist() == list(range(64))
    assert hearing().block(data) == Said()


def test_verdict_comes_out_of_blocks() -> None:
    heard = hearing()
    said = [diagnosis for data in waveform(60) for diagnosis in heard.block(data).diagnoses]
    assert [diagnosis.index for diagnosis in said if diagnosis] == [25599, 51199]
