"""Messages of one value: text, number, force, clock, a sample of the preview. Bytes that are no such message are refused."""

from __future__ import annotations

import struct
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from dcrb_ros.messages.cdr import CLOCK, FRAME, IMU, TEMPLATES, TEXT, decoded, encoded, header, ros_type
from dcrb_ros.messages.message_template import MessageTemplate, placeholder_bytes
from dcrb_ros.schema.refusal import Refusal

TEMPERATURE = "sensor_msgs/msg/Temperature"
NO_ESTIMATE = -1.0
"""First element of the covariance of a quantity that is not measured, see sensor_msgs/msg/Imu; zeros mean an unknown covariance."""


def encode_preview(time_ns: int, acceleration: npt.NDArray[np.float32], frame: str = FRAME) -> bytes:
    """Return a sample of the preview as an Imu without orientation and angular velocity; the covariance of the acceleration is unknown."""
    return _preview_template(frame).filled(time_ns, acceleration.astype("<f8").tobytes())


@lru_cache(TEMPLATES)
def _preview_template(frame: str) -> MessageTemplate:
    vector, quaternion, placeholder = ros_type("geometry_msgs/msg/Vector3"), ros_type("geometry_msgs/msg/Quaternion"), placeholder_bytes(16)
    unknown, absent = np.zeros(9), np.zeros(9)
    absent[0] = NO_ESTIMATE
    linear = vector(*struct.unpack("<dd", placeholder), 0.0)
    imu = ros_type(IMU)(header(0, frame), quaternion(0.0, 0.0, 0.0, 1.0), absent, vector(0.0, 0.0, 0.0), absent, linear, unknown)
    return MessageTemplate(encoded(IMU, imu), placeholder)


def encode_text(text: str) -> bytes:
    """Return a String."""
    return encoded(TEXT, ros_type(TEXT)(text))


def encode_clock(time_ns: int) -> bytes:
    """Return a Clock."""
    return encoded(CLOCK, ros_type(CLOCK)(ros_type("builtin_interfaces/msg/Time")(time_ns // 1_000_000_000, time_ns % 1_000_000_000)))


def decode_clock(data: bytes) -> int:
    """Return the time of a Clock [ns]."""
    clock = decoded(data, CLOCK).clock
    return int(clock.sec) * 1_000_000_000 + int(clock.nanosec)


def decode_float(data: bytes) -> float:
    """Return the number of a Float64."""
    return float(decoded(data, "std_msgs/msg/Float64").data)


def encode_temperature(time_ns: int, temperature: float, deviation: float, frame: str = FRAME) -> bytes:
    """Return a Temperature [deg C]; its variance is the square of a standard deviation [K], 0 for one that is not known."""
    return encoded(TEMPERATURE, ros_type(TEMPERATURE)(header(time_ns, frame), temperature, deviation**2))


def decode_temperature(data: bytes) -> float:
    """Return the temperature of a Temperature [deg C]."""
    return float(decoded(data, TEMPERATURE).temperature)


def decode_wrench(data: bytes) -> tuple[float, float]:
    """Return the force of a Wrench in X and Y [N].

    Raises:
        Refusal: it has a force in Z or a torque, for which the bearing has no degree of freedom.
    """
    wrench = decoded(data, "geometry_msgs/msg/Wrench")
    others = {"force.z": (wrench.force.z, "N"), **{f"torque.{axis}": (getattr(wrench.torque, axis), "N m") for axis in "xyz"}}
    for name, (value, unit) in others.items():
        if value != 0.0:
            raise Refusal(f"{name} = {value:g} {unit} is refused, as only force.x and force.y act on the inner ring: give 0")
    return float(wrench.force.x), float(wrench.force.y)


def decode_text(data: bytes) -> str:
    """Return the text of a String."""
    return str(decoded(data, TEXT).data)
