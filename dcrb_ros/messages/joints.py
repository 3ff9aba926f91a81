"""JointState messages: the states of the bodies, and features by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from dcrb_ros.measurement.features import features
from dcrb_ros.messages.cdr import FRAME, JOINT_STATE, TEMPLATES, decoded, encoded, header, ros_type, stamp_of
from dcrb_ros.messages.message_template import MessageTemplate, placeholder_bytes
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.block import Block


@dataclass(frozen=True)
class Joints:
    """A JointState: names with position, velocity and effort."""

    stamp_ns: int
    names: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats


def encode_joints(
    time_ns: int, names: Sequence[str], position: ArrayLike, velocity: ArrayLike = (), effort: ArrayLike = (), frame: str = FRAME
) -> bytes:
    """Return a JointState; quantities other than positions, velocities and efforts are in ``position``."""
    numbers = [np.asarray(values, "<f8").tobytes() for values in (position, velocity, effort)]
    return _joints_template(frame, tuple(names), *map(len, numbers)).filled(time_ns, *numbers)


@lru_cache(TEMPLATES)
def _joints_template(frame: str, names: tuple[str, ...], *sizes: int) -> MessageTemplate:
    """Return the template of a JointState; ``sizes`` are the lengths of its three arrays [bytes]."""
    placeholder = placeholder_bytes(sum(sizes))
    placeholders = [placeholder[sum(sizes[:k]) : sum(sizes[: k + 1])] for k in range(len(sizes))]
    arrays = [np.frombuffer(part, "<f8") for part in placeholders]
    return MessageTemplate(encoded(JOINT_STATE, ros_type(JOINT_STATE)(header(0, frame), list(names), *arrays)), *placeholders)


def encode_features(block: Block, frame: str = FRAME) -> bytes:
    """Return the features of a block as a JointState; the values are in position."""
    values = features(block.acceleration, block.clipped)
    return encode_joints(block.stamp_ns, list(values), list(values.values()), frame=frame)


def decode_joints(data: bytes) -> Joints:
    """Return a JointState."""
    joints = decoded(data, JOINT_STATE)
    return Joints(stamp_of(joints.header), tuple(joints.name), joints.position, joints.velocity, joints.effort)


def decode_alike(messages: Sequence[bytes]) -> Joints | None:
    """Return little-endian JointStates of equal length, names and frame as one with arrays of shape (messages, names) and the first stamp.

    The messages of a topic repeat its names; decoding them once is ten times as fast. Returns None if the messages differ.
    """
    if not messages or len({len(data) for data in messages}) > 1:
        return None
    first = decode_joints(messages[0])
    if not all(data[1] & 1 for data in messages):
        return None
    counts = len(first.position), len(first.velocity), len(first.effort)
    rows = np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), -1)
    numbers: list[Floats] = []
    end = rows.shape[1]
    for count in reversed(counts):
        begin = end - 8 * count
        numbers.insert(0, np.ascontiguousarray(rows[:, begin:end]).view("<f8").reshape(len(messages), count))
        # The length of the array, and padding that aligns its numbers to eight bytes.
        end = begin - (8 if count else 4)
    names_end = rows.shape[1] - sum(8 * count for count in counts) - sum(8 if count else 4 for count in counts[1:])
    same = np.all(rows[:, 12:names_end] == rows[0, 12:names_end])
    alike = [
        np.array_equal(repeated[0], array, equal_nan=True)
        for repeated, array in zip(numbers, (first.position, first.velocity, first.effort), strict=True)
    ]
    return Joints(first.stamp_ns, first.names, *numbers) if same and all(alike) else None
