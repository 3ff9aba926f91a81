"""Messages in CDR, encoded and decoded by the type store of rosbags: the same bytes with and without ROS."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from dcrb_ros.messages.definitions import DEFINITIONS
from dcrb_ros.schema.refusal import Refusal

POINT_CLOUD = "sensor_msgs/msg/PointCloud2"
JOINT_STATE = "sensor_msgs/msg/JointState"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
TEXT = "std_msgs/msg/String"
IMU = "sensor_msgs/msg/Imu"
CLOCK = "rosgraph_msgs/msg/Clock"
FRAME = "outer_ring"
TEMPLATES = 64
"""Message templates kept, so that a message that differs from an earlier one in stamp and numbers only is not encoded anew."""
STAMP_END = 12
"""Length of a message with a header up to its frame [bytes]."""


def typestore(type_name: str) -> Typestore:
    """Return a type store that has a message type, if ROS 2 Jazzy has it; the types in `definitions` have a store of their own."""
    own = _own_types()
    return own if type_name in own.types else _all_types()


@cache
def _own_types() -> Typestore:
    store = get_typestore(Stores.EMPTY)
    types: dict[str, Any] = {}
    for name, fields in DEFINITIONS.items():
        types |= get_types_from_msg(fields.replace("; ", "\n"), name)
    store.register(types)
    return store


@cache
def _all_types() -> Typestore:
    return get_typestore(Stores.ROS2_JAZZY)


def definition_of(type_name: str) -> str:
    """Return the text of a message definition with those of nested messages; the empty string if the type is unknown."""
    store = typestore(type_name)
    return store.generate_msgdef(type_name, ros_version=2)[0] if type_name in store.types else ""


def ros_type(name: str) -> Any:
    """Return the class of a message type."""
    return typestore(name).types[name]


def encoded(type_name: str, message: Any) -> bytes:
    """Return a message in CDR."""
    return bytes(typestore(type_name).serialize_cdr(message, type_name))


def header(time_ns: int, frame: str = FRAME) -> Any:
    """Return a header with a stamp [ns]."""
    stamp = ros_type("builtin_interfaces/msg/Time")(time_ns // 1_000_000_000, time_ns % 1_000_000_000)
    return ros_type("std_msgs/msg/Header")(stamp, frame)


def stamp_of(header: Any) -> int:
    """Return the stamp of a decoded header [ns]."""
    return int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)


def decoded(data: bytes, type_name: str) -> Any:
    """Return the message in some bytes.

    Raises:
        Refusal: the bytes are not such a message.
    """
    try:
        return typestore(type_name).deserialize_cdr(data, type_name)
    except Exception as error:  # the decoders that rosbags generates raise exceptions of any kind
        raise Refusal(f"a message of {len(data)} bytes is not a valid {type_name}: {type(error).__name__}") from None


def check_header(data: bytes, mistake: str = "is not valid") -> None:
    """Refuse a message that is too short for a header; the sentence says with ``mistake`` what it is not."""
    if len(data) < STAMP_END:
        raise Refusal(f"a message of {len(data)} bytes {mistake}: it has no header")


def stamps(messages: Sequence[bytes]) -> npt.NDArray[np.int64]:
    """Return the stamps of messages that begin with a header, in either byte order, shape (messages,) [ns].

    Raises:
        Refusal: one of them is too short.
    """
    check_header(min(messages, key=len, default=bytes(STAMP_END)))
    heads = np.frombuffer(b"".join(data[4:12] for data in messages), "<i4").reshape(-1, 2)
    little = np.array([data[1] & 1 for data in messages], bool)
    seconds, nanoseconds = np.where(little[:, None], heads, heads.byteswap()).T
    found: npt.NDArray[np.int64] = seconds.astype(np.int64) * 1_000_000_000 + nanoseconds.astype(np.uint32)
    return found
