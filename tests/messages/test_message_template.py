"""Messages from a template equal those that the type store encodes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ros_types import typestore

from dcrb_ros.messages.cdr import JOINT_STATE, POINT_CLOUD
from dcrb_ros.messages.joints import decode_joints, encode_joints
from dcrb_ros.messages.message_template import MessageTemplate, placeholder_bytes
from dcrb_ros.messages.plain import encode_preview
from dcrb_ros.messages.points import SAMPLE, SPECTRUM, encode_points

STAMPS = st.integers(0, 2**31 * 1_000_000_000 - 1)
NUMBERS = st.tuples(*[st.lists(st.floats(width=64), max_size=4)] * 3)


@given(STAMPS, st.lists(st.text("row1/é", max_size=9), max_size=4), NUMBERS)
def test_joints(time_ns: int, names: list[str], numbers: tuple[list[float], list[float], list[float]]) -> None:
    arrays = [np.array(values, np.float64) for values in numbers]
    data = encode_joints(time_ns, names, *arrays)
    found = decode_joints(data)
    assert (found.stamp_ns, found.names) == (time_ns, tuple(names))
    assert [a.tobytes() for a in (found.position, found.velocity, found.effort)] == [a.tobytes() for a in arrays]
    assert bytes(typestore().serialize_cdr(typestore().deserialize_cdr(data, JOINT_STATE), JOINT_STATE)) == data


@given(STAMPS, st.sampled_from([SAMPLE, SPECTRUM]), st.integers(0, 5), st.text("abc/_", max_size=6))
def test_points(time_ns: int, kind: np.dtype[np.void], count: int, frame: str) -> None:
    points = np.frombuffer(np.random.default_rng(count).bytes(count * kind.itemsize), kind)
    data = encode_points(points, time_ns, frame)
    cloud = typestore().deserialize_cdr(data, POINT_CLOUD)
    assert (cloud.width, cloud.header.frame_id, cloud.data.tobytes()) == (count, frame, points.tobytes())
    assert bytes(typestore().serialize_cdr(cloud, POINT_CLOUD)) == data


@given(STAMPS, st.floats(width=32, allow_nan=False), st.floats(width=32, allow_nan=False), st.text("abc/_", max_size=6))
def test_preview(time_ns: int, x: float, y: float, frame: str) -> None:
    name = "sensor_msgs/msg/Imu"
    data = encode_preview(time_ns, np.array([x, y], np.float32), frame)
    imu = typestore().deserialize_cdr(data, name)
    acceleration = imu.linear_acceleration
    assert (acceleration.x, acceleration.y, acceleration.z, imu.header.frame_id) == (x, y, 0.0, frame)
    assert bytes(typestore().serialize_cdr(imu, name)) == data
    # sensor_msgs/msg/Imu: zeros for an unknown covariance, -1 first for a quantity that is not measured.
    assert imu.linear_acceleration_covariance.tolist() == [0.0] * 9
    assert imu.orientation_covariance.tolist() == imu.angular_velocity_covariance.tolist() == [-1.0, *[0.0] * 8]


def test_a_placeholder_must_be_in_the_message() -> None:
    with pytest.raises(ValueError, match="not found"):
        MessageTemplate(bytes(40), placeholder_bytes(8))
