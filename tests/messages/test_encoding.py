"""Blocks to messages and back."""

from __future__ import annotations

import contextlib
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up_blocks import BODIES, blocks
from ros_types import typestore
from runs import simulated

from dcrb_ros.messages.cdr import IMU, decoded
from dcrb_ros.messages.description import decode_frame, decode_sensor, sensor_text
from dcrb_ros.messages.encoder import BlockEncoder, diagnosis_messages
from dcrb_ros.messages.joints import decode_joints
from dcrb_ros.messages.plain import decode_float, decode_text, decode_wrench, encode_preview, encode_text
from dcrb_ros.messages.points import SAMPLE, decode_vibration, decode_waveform, encode_points, encode_vibration, sample_type
from dcrb_ros.messages.statuses import decode_diagnostics, decode_truth
from dcrb_ros.messages.topics import (
    AMBIENT_TEMPERATURE,
    BOX_TEMPERATURE,
    DETECTED,
    FEATURES,
    GROUND_TRUTH,
    LUBRICATION_STATE,
    OUTER_RING_TEMPERATURE,
    ROLLER_STATES,
    SENSOR,
    SIMULATED,
    VIBRATION,
)
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.stream.states import BodyNames


def block_at(index: int, count: int, rate: int = 51200) -> Block:
    random = np.random.default_rng(index)
    samples = random.standard_normal((count, 2)).astype(np.float32)
    return Block(index, rate, samples, random.uniform(0.0, 6.28, count).astype(np.float32), samples)


@given(st.integers(0, 10**12), st.integers(1, 3000), st.sampled_from([12800, 25600, 51200, 102400]))
def test_waveform_round_trip(index: int, count: int, rate: int) -> None:
    block = block_at(index, count, rate)
    found = decode_vibration(encode_vibration(block, block.acceleration))
    assert np.array_equal(found.acceleration, block.acceleration)
    assert np.array_equal(found.shaft_angle, block.shaft_angle)
    assert found.first_index(rate) == index
    exact = [(index + k) * 10**9 // rate - found.stamp_ns for k in range(count)]
    assert found.offsets_ns.tolist() == exact


@pytest.mark.parametrize("tracked", [True, False])
def test_three_axes_round_trip(tracked: bool) -> None:
    blocks, samples = [block_at(0, 512), block_at(512, 512)], np.random.default_rng(1).standard_normal((1024, 3)).astype(np.float32)
    data = [encode_vibration(block, samples[part]) for block, part in zip(blocks, (slice(512), slice(512, None)), strict=True)]
    if not tracked:
        found = [decode_vibration(message) for message in data]
        data = []
        for block in found:
            points = np.zeros(512, sample_type(3, tracked=False))
            points["t"] = block.offsets_ns
            for name, column in zip(("ax", "ay", "az"), block.acceleration.T, strict=True):
                points[name] = column
            data.append(encode_points(points, block.stamp_ns))
    _, acceleration, angle = decode_waveform(data)
    assert np.array_equal(acceleration, samples)
    assert np.array_equal(angle, np.concatenate([block.shaft_angle for block in blocks])) is tracked
    assert bool(np.isnan(angle).any()) is not tracked
    with pytest.raises(Refusal, match="have two and three axes"):
        decode_waveform([*data, encode_vibration(blocks[1], samples[:512, :2])])


def test_many_messages_decode_to_the_same_waveform_as_one_by_one() -> None:
    blocks = [block_at(index, count) for index, count in ((0, 1024), (1024, 1024), (9000, 512), (9512, 188))]
    data = [encode_vibration(block, block.acceleration) for block in blocks]
    # Middleware pads a message to a multiple of four bytes.
    data[1] += bytes(-len(data[1]) % 4)
    time_ns, acceleration, shaft_angle = decode_waveform(data)
    each = [decode_vibration(message) for message in data]
    assert time_ns.tolist() == [block.stamp_ns + int(offset) for block in each for offset in block.offsets_ns]
    assert np.array_equal(acceleration, np.concatenate([block.acceleration for block in each]))
    assert np.array_equal(shaft_angle, np.concatenate([block.shaft_angle for block in each]))


def test_a_waveform_with_another_message_is_refused() -> None:
    block = block_at(0, 64)
    data = encode_vibration(block, block.acceleration)
    with pytest.raises(Refusal, match=r"is not a waveform"):
        decode_waveform([data, data.replace(b"shaft_angle", b"shift_angle")])


def test_states_truth_and_features_round_trip() -> None:
    run = simulated(0.3, fault="outer_1", state_rate=100)
    encoder = BlockEncoder(run.configuration, BodyNames(2, 16))
    messages = [message for block in run.blocks for message in encoder.encode(block)]
    states = [decode_joints(m.data) for m in messages if m.topic is ROLLER_STATES]
    assert [s.stamp_ns for s in states] == [s.time_ns for s in run.states]
    for joints, expected in zip(states, run.states, strict=True):
        assert joints.names == tuple(BodyNames(2, 16).names)
        assert np.array_equal(joints.position, expected.azimuth)
        assert np.array_equal(joints.velocity, expected.speed)
        assert np.array_equal(joints.effort, expected.inner_force)
    truths = [decode_truth(m.data) for m in messages if m.topic is GROUND_TRUTH]
    expected_truths = [truth for block in run.blocks for truth in block.truths]
    assert [(t.time_ns, t.speed, t.load, t.event) for t in truths] == [(t.time_ns, t.speed, t.load, t.event) for t in expected_truths]
    assert truths[0].faults["outer_1"]["width"] == 0.002
    rms = decode_joints(next(m.data for m in messages if m.topic is FEATURES)).position[0]
    y = run.blocks[0].acceleration[:, 1].astype(float)
    assert rms == pytest.approx(y.std(), rel=1e-6)


def test_the_sensor_description_has_rate_units_and_orders() -> None:
    about = json.loads(decode_text(encode_text(sensor_text(Configuration()))))
    assert about["sampling_rate"] == 51200
    assert about["acceleration_unit"] == "m/s^2"
    rate, orders = decode_sensor(encode_text(sensor_text(Configuration())))
    assert (rate, round(orders.bpfo, 4)) == (51200, 6.7234)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{}",
        "[1]",
        "[" * 100_000,
        '{"sampling_rate": "fast", "orders": {}}',
        '{"sampling_rate": -1, "orders": {"FTF":1,"BPFO":1,"BPFI":1,"BSF":1}}',
    ],
)
def test_other_texts_are_not_a_sensor_description(text: str) -> None:
    with pytest.raises(Refusal, match="sensor's description"):
        decode_sensor(encode_text(text))


def test_other_point_clouds_are_refused() -> None:
    points = np.zeros(4, [("x", "<f4"), ("y", "<f4")])
    with pytest.raises(Refusal, match=r"\['x', 'y'\] is not a waveform"):
        decode_vibration(encode_points(points, 0))
    with pytest.raises(Refusal, match="declares 0 samples"):
        decode_vibration(encode_points(np.zeros(0, SAMPLE), 0))


@given(st.binary(max_size=600))
def test_any_bytes_are_decoded_or_refused(data: bytes) -> None:
    with pytest.raises(Refusal):
        decode_vibration(data)


@given(st.binary(max_size=600), st.sampled_from([b"", b"\x00\x01\x00\x00"]))
def test_any_bytes_raise_at_most_a_refusal(data: bytes, begin: bytes) -> None:
    for decode in (decode_float, decode_wrench, decode_joints, decode_diagnostics, decode_sensor):
        with contextlib.suppress(Refusal):
            decode(begin + data)


def test_commands_are_decoded() -> None:
    store = typestore()
    number = store.types["std_msgs/msg/Float64"](140.5)
    assert decode_float(bytes(store.serialize_cdr(number, "std_msgs/msg/Float64"))) == 140.5
    vector, name = store.types["geometry_msgs/msg/Vector3"], "geometry_msgs/msg/Wrench"
    wrench = store.types[name](vector(1.0, -2.0, 0.0), vector(0.0, 0.0, 0.0))
    assert decode_wrench(bytes(store.serialize_cdr(wrench, name))) == (1.0, -2.0)


@pytest.mark.parametrize("data", [b"", b"\x00\x01\x00\x00", b"\x00\x01\x00\x00abc", b"\xff" * 12, b"\x00\x01\x00\x00" + bytes(90)])
def test_malformed_commands_are_refused(data: bytes) -> None:
    for decode in (decode_float, decode_wrench):
        with pytest.raises(Refusal, match=f"a message of {len(data)} bytes is not a valid"):
            decode(data)


def test_every_header_and_status_names_the_hardware() -> None:
    frame, names = "box2/outer_ring", BodyNames(2, 16)
    publishing = {"frame": frame, "clean": True, "contacts": True, "features": True}
    configuration = Configuration.model_validate({"publishing": publishing, "tacho": {"pulses_per_turn": 60}})
    encoder, blocks = BlockEncoder(configuration, names), simulated(1.1, fault="outer_1", state_rate=100).blocks
    diagnosis = Diagnosis(0, 1.0, "healthy", "test", spectrum=(np.arange(3.0), np.ones(3)))
    messages = [*(message for block in blocks for message in encoder.encode(block)), *diagnosis_messages(diagnosis, frame)]
    headed = [message for message in messages if message.topic != SENSOR]
    assert {message.topic for message in headed} == {*SIMULATED, *DETECTED} - {
        SENSOR,
        LUBRICATION_STATE,
        OUTER_RING_TEMPERATURE,
        BOX_TEMPERATURE,
        AMBIENT_TEMPERATURE,
    }  # dry
    for message in headed:
        found = decoded(message.data, message.topic.type)
        assert found.header.frame_id == frame, message.topic.name
        assert all(status.hardware_id == frame for status in getattr(found, "status", ())), message.topic.name


@pytest.mark.parametrize("name", ["force.z", "torque.x", "torque.y", "torque.z"])
@pytest.mark.parametrize("value", [1.0, -1e-300, float("nan")])
def test_a_wrench_that_the_bearing_cannot_take_is_refused(name: str, value: float) -> None:
    vector, wrench = (typestore().types[f"geometry_msgs/msg/{kind}"] for kind in ("Vector3", "Wrench"))
    message = wrench(vector(1.0, -2.0, 0.0), vector(0.0, 0.0, 0.0))
    encode = typestore().serialize_cdr
    assert decode_wrench(bytes(encode(message, "geometry_msgs/msg/Wrench"))) == (1.0, -2.0)
    part, _, axis = name.partition(".")
    setattr(getattr(message, part), axis, value)
    with pytest.raises(Refusal, match=rf"^{name} = .* is refused, as only force.x and force.y act on the inner ring: give 0$"):
        decode_wrench(bytes(encode(message, "geometry_msgs/msg/Wrench")))


@pytest.mark.parametrize(
    ("text", "frame"),
    [('{"frame": "box2"}', "box2"), ("{}", "outer_ring"), ('{"frame": 3}', "outer_ring"), ("[", "outer_ring"), ("[]", "outer_ring")],
)
def test_the_frame_of_a_description_is_read_if_it_has_one(text: str, frame: str) -> None:
    assert decode_frame(encode_text(text)) == frame


@pytest.mark.parametrize(("size", "expected"), [(1024, [50, 100, 150]), (1000, [51, 102, 153]), (51200, [1, 2]), (60000, [1, 2])])
def test_the_sensor_is_described_again_every_second(size: int, expected: list[int]) -> None:
    """With the block on which the second falls, before its waveform; the messages before the first block describe it at zero."""
    encoder = BlockEncoder(Configuration(), BODIES)
    found = {}
    for number, block in enumerate(blocks(-(-3 * 51200 // size) + 1 if size < 51200 else 3, size=size)):
        messages = encoder.encode(block)
        if messages[0].topic == SENSOR:
            found[number] = (messages[0].time_ns, messages[0].data)
            assert messages[1].topic == VIBRATION
    assert list(found) == expected
    assert {data for _, data in found.values()} == {encoder.start()[0].data}
    assert [time_ns for time_ns, _ in found.values()] == [number * size * 1_000_000_000 // 51200 for number in expected]


def test_the_covariance_of_the_acceleration_is_unknown_and_orientation_is_absent() -> None:
    """As sensor_msgs/msg/Imu states: zeros for an unknown covariance, and -1 for a quantity that is not measured."""
    imu = decoded(encode_preview(1, np.array([1.0, -2.0], np.float32)), IMU)
    assert (imu.linear_acceleration.x, imu.linear_acceleration.y, imu.linear_acceleration.z) == (1.0, -2.0, 0.0)
    assert not np.any(imu.linear_acceleration_covariance)
    assert imu.orientation_covariance[0] == imu.angular_velocity_covariance[0] == -1.0
