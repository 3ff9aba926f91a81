"""JointStates decoded together equal those decoded one by one."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.messages.cdr import stamps
from dcrb_ros.messages.joints import decode_alike, decode_joints, encode_joints
from dcrb_ros.schema.refusal import Refusal

TIMES = st.integers(0, 2**31 * 1_000_000_000 - 1)


@given(st.lists(TIMES, min_size=1, max_size=5), st.lists(st.text("abc/é", max_size=9), max_size=6), st.tuples(*[st.integers(0, 3)] * 3))
def test_similar_messages_are_decoded_together(times: list[int], names: list[str], counts: tuple[int, int, int]) -> None:
    random = np.random.default_rng(len(names))
    messages = [encode_joints(time, names, *(random.normal(size=count) for count in counts)) for time in times]
    singly = [decode_joints(data) for data in messages]
    joined = decode_alike(messages)
    assert stamps(messages).tolist() == times
    if joined is None:
        assert 0 in counts  # messages with three arrays are always decoded together
        return
    assert joined.names == tuple(names)
    for name in ("position", "velocity", "effort"):
        assert np.array_equal(getattr(joined, name), np.array([getattr(joints, name) for joints in singly]))


def test_stamps_are_read_in_both_byte_orders() -> None:
    little, big = b"\0\1\0\0" + struct.pack("<iI", 3, 5), b"\0\0\0\0" + struct.pack(">iI", 3, 5)
    assert stamps([little, big, little]).tolist() == [3_000_000_005] * 3


def test_a_message_too_short_for_a_stamp_is_refused() -> None:
    assert stamps([]).shape == (0,)
    with pytest.raises(Refusal, match="a message of 5 bytes is not valid: it has no header"):
        stamps([encode_joints(3, ["a"], [0.0]), b"\0\1\0\0\0"])


def test_messages_that_differ_are_not_decoded_together() -> None:
    none = np.zeros(0)
    one, other = encode_joints(0, ["a"], np.ones(1), none, none), encode_joints(0, ["b"], np.ones(1), none, none)
    assert decode_alike([]) is None
    assert decode_alike([one, other]) is None
    assert decode_alike([one, one + bytes(4)]) is None


def test_big_endian_messages_are_not_decoded_together() -> None:
    names = struct.pack(">2I4s", 1, 2, b"a")
    messages = [struct.pack(">4x2iI4s", 0, 0, 2, b"f") + names + struct.pack(">IdII", 1, value, 0, 0) for value in (0.0, 1.0)]
    assert [decode_joints(data).position.tolist() for data in messages] == [[0.0], [1.0]]
    assert decode_alike(messages) is None
