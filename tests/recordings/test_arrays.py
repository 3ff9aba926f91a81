"""A recording as arrays, from messages made up without the model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import FrozenInstanceError, replace
from pathlib import Path

import numpy as np
import pytest
from made_up_blocks import BODIES, FREQUENCIES, blocks

from dcrb_ros.exchange.export import export
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.joints import encode_joints
from dcrb_ros.messages.points import encode_vibration
from dcrb_ros.messages.statuses import Status, encode_diagnostics, encode_truth
from dcrb_ros.messages.topics import DIAGNOSIS, GROUND_TRUTH, ROLLER_CONTACTS, ROLLER_STATES, VIBRATION, Message, Topic
from dcrb_ros.recordings.arrays import RecordedVerdict
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.block import Truth

NAMES = ("row1/roller01", "inner_ring")
RANGES = (5000.0, 100.0, 50.0, 20.0)
"""The sensor's range in each of four blocks [m/s^2]."""


def recording_of(path: Path, messages: Iterable[Message]) -> Recording:
    with Recorder(path, Configuration(), BODIES) as recorder:
        recorder.write_messages(messages)
    return Recording(path)


def waveform_in(path: Path, order: Sequence[int]) -> Recording:
    """Record four blocks of 20 ms, with a range each, in an order."""
    made = [replace(block, range=limit) for block, limit in zip(blocks(4), RANGES, strict=True)]
    encoder = BlockEncoder(Configuration(), BODIES)
    return recording_of(path, [message for number in order for message in encoder.encode(made[number])])


def joints(topic: Topic, time_ns: int, values: Sequence[float], names: Sequence[str] = NAMES) -> Message:
    position = np.array(values)
    return Message(topic, time_ns, encode_joints(time_ns, names, position, position + 10.0, position + 20.0))


def test_blocks_of_two_and_three_axes_are_refused(tmp_path: Path) -> None:
    messages = [
        Message(VIBRATION, block.stamp_ns, encode_vibration(block, np.zeros((len(block.shaft_angle), axes), np.float32)))
        for axes, block in zip((2, 3), blocks(2), strict=True)
    ]
    recording = recording_of(tmp_path / "bag", messages)
    with pytest.raises(Refusal, match="have two and three axes: publish the same fields in all of them"):
        recording.waveform()
    with pytest.raises(Refusal, match="have two and three axes: publish the same fields in all of them"):
        export(recording, tmp_path / "x.npz")
    assert recording.waveform(0.0, 0.02).acceleration.shape[1] == 2


@pytest.mark.parametrize(
    ("start", "stop", "first", "last", "limit"),
    [
        (None, None, 0, 4, 20.0),
        (None, 0.06, 0, 3, 50.0),
        (0.02, 0.06, 1, 3, 50.0),
        (0.02, 0.04, 1, 2, 100.0),
        (0.06, None, 3, 4, 20.0),
        (0.0, 0.02, 0, 1, 5000.0),
    ],
)
def test_a_stretch_has_the_samples_from_its_start_until_before_its_end(
    start: float | None, stop: float | None, first: int, last: int, limit: float, tmp_path: Path
) -> None:
    waveform = waveform_in(tmp_path / "bag", range(4)).waveform(start, stop)
    assert np.array_equal(waveform.index, np.arange(first * 1024, last * 1024))
    assert np.array_equal(waveform.acceleration, np.concatenate([block.acceleration for block in blocks(4)])[first * 1024 : last * 1024])
    assert waveform.sensor_range == limit


def test_a_stretch_within_blocks_is_cut_at_the_sample(tmp_path: Path) -> None:
    waveform = waveform_in(tmp_path / "bag", range(4)).waveform(0.03, 0.05)
    assert (waveform.index[0], waveform.index[-1]) == (1536, 2559)
    assert waveform.sensor_range == 50.0


def test_blocks_that_come_twice_or_late_are_kept_once_in_their_place(tmp_path: Path) -> None:
    waveform = waveform_in(tmp_path / "bag", (0, 2, 1, 1, 3)).waveform()
    assert np.array_equal(waveform.index, np.arange(4 * 1024))
    assert np.array_equal(waveform.acceleration, np.concatenate([block.acceleration for block in blocks(4)]))
    assert np.array_equal(waveform.shaft_angle, np.concatenate([block.shaft_angle for block in blocks(4)]))


@pytest.mark.parametrize(
    ("start", "stop", "where"),
    [
        (0.08, 0.1, "from 0.08 to 0.1 s"),
        (0.08, None, "from 0.08 s on"),
        (3.0, 4.0, "from 3 to 4 s"),
        (None, 0.02, "before 0.02 s"),
        (0.0, 0.02, "from 0 to 0.02 s"),
    ],
)
def test_a_stretch_without_samples_is_refused_with_those_there_are(
    start: float | None, stop: float | None, where: str, tmp_path: Path
) -> None:
    recording = waveform_in(tmp_path / "bag", (3, 1, 2))
    with pytest.raises(Refusal, match=rf"bag has no sample {where}: it has samples from 0.02 to 0.08 s"):
        recording.waveform(start, stop)


def test_states_are_arrays_of_times_and_bodies(tmp_path: Path) -> None:
    states = recording_of(tmp_path / "bag", [joints(ROLLER_STATES, 10_000_000 * k, (k, 0.5)) for k in range(3)]).states()
    assert states.time == pytest.approx([0.0, 0.01, 0.02], abs=1e-12)
    assert states.names == NAMES
    assert states.azimuth.tolist() == [[0.0, 0.5], [1.0, 0.5], [2.0, 0.5]]
    assert states.speed.tolist() == (states.azimuth + 10.0).tolist()
    assert states.inner_force.tolist() == (states.azimuth + 20.0).tolist()
    assert (states.outer_force, states.slip, states.friction) == (None, None, None)


@pytest.mark.parametrize(("shift", "given"), [(0, True), (1000, False)])
def test_contacts_are_given_where_they_have_the_times_of_the_states(shift: int, given: bool, tmp_path: Path) -> None:
    times = [10_000_000 * k for k in range(1, 4)]
    messages = [joints(ROLLER_STATES, time_ns, (1.0, 2.0)) for time_ns in times]
    contacts = [joints(ROLLER_CONTACTS, time_ns + shift, (3.0, 4.0)) for time_ns in times]
    states = recording_of(tmp_path / "bag", [*messages, *contacts]).states()
    expected = [[3.0 + offset, 4.0 + offset] for offset in (0.0, 10.0, 20.0)]
    found = (states.outer_force, states.slip, states.friction)
    assert [values is not None for values in found] == [given] * 3
    assert [values.tolist() for values in found if values is not None] == ([[row] * 3 for row in expected] if given else [])


@pytest.mark.parametrize("count", [1, 2])
def test_states_with_numbers_that_are_not_finite_are_read(count: int, tmp_path: Path) -> None:
    messages = [joints(ROLLER_STATES, 10_000_000 * k, (math.nan, float(k))) for k in range(count)]
    states = recording_of(tmp_path / "bag", messages).states()
    assert np.array_equal(states.azimuth, [[math.nan, float(k)] for k in range(count)], equal_nan=True)
    assert states.names == NAMES


def test_states_of_different_bodies_are_refused(tmp_path: Path) -> None:
    messages = [joints(ROLLER_STATES, 0, (0.0, 1.0)), joints(ROLLER_STATES, 1, (0.0, 1.0), ("row1/roller01", "row1/roller02"))]
    with pytest.raises(Refusal, match="roller_states name different bodies: give a recording of one bench"):
        recording_of(tmp_path / "bag", messages).states()


def test_a_recording_without_states_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="has no messages on roller_states: record this topic too"):
        recording_of(tmp_path / "bag", []).states()


def test_truths_differ_by_their_time_where_their_content_is_repeated(tmp_path: Path) -> None:
    truths = [Truth(10 + k, speed, (0.0, -1e5), FREQUENCIES, {}) for k, speed in enumerate((100.0, 100.0, 125.0, 100.0))]
    recording = recording_of(tmp_path / "bag", [Message(GROUND_TRUTH, truth.time_ns, encode_truth(truth)) for truth in truths])
    assert [(truth.time_ns, truth.speed) for truth in recording.truth().truths] == [(10, 100.0), (11, 100.0), (12, 125.0), (13, 100.0)]


def test_a_recording_without_ground_truth_has_none(tmp_path: Path) -> None:
    assert len(recording_of(tmp_path / "bag", []).truth()) == 0


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"verdict": "cage", "confidence": "0.75", "reason": "FTF"}, ("cage", 0.75, "FTF")),
        ({"confidence": "high"}, ("outer_ring", math.nan, "")),
        ({}, ("outer_ring", math.nan, "")),
    ],
)
def test_a_verdict_is_read_from_the_first_status(values: dict[str, str], expected: tuple[str, float, str], tmp_path: Path) -> None:
    statuses = [Status("detector", 0, "outer_ring", values), Status("other", 0, "inner_ring", {"verdict": "roller"})]
    messages = [Message(DIAGNOSIS, 2_500_000_000, encode_diagnostics(2_500_000_000, found)) for found in (statuses, [])]
    (verdict,) = recording_of(tmp_path / "bag", messages).verdicts()
    assert (verdict.verdict, verdict.reason) == (expected[0], expected[2])
    assert verdict.confidence == pytest.approx(expected[1], nan_ok=True)
    assert verdict.time == pytest.approx(2.5, abs=1e-9)


def test_a_verdict_cannot_be_changed() -> None:
    verdict = RecordedVerdict(1.0, "cage", 0.5, "FTF")
    with pytest.raises(FrozenInstanceError):
        verdict.time = 2.0  # type: ignore[misc]
    assert repr(verdict) == "<RecordedVerdict: cage at 1.00 s>"
