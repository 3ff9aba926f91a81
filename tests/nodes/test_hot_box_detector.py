"""The node of the wayside hot-box detector: a message for each passage, and a warning where there is nothing to read."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from dcrb_ros.messages.statuses import ERROR, OK, encode_diagnostics, encode_truth
from dcrb_ros.messages.topics import GROUND_TRUTH, WAYSIDE_ALARM, WAYSIDE_TEMPERATURE, Message
from dcrb_ros.stream.block import Truth

rclpy = pytest.importorskip("rclpy")


@pytest.fixture
def node() -> Iterator[Any]:
    from dcrb_ros.nodes.hot_box_detector import HotBoxDetectorNode

    rclpy.init(args=["--ros-args", "-p", "spacing:=0.05", "-p", "noise:=0.0"])
    made = HotBoxDetectorNode()
    try:
        yield made
    finally:
        made.close()
        made.destroy_node()
        rclpy.try_shutdown()


def truth(second: int, box: float) -> bytes:
    """Return a ground truth at 57.8 m/s with a box of a temperature [deg C]."""
    thermal = {"row1/outer_ring": box, "box": box, "opposite_box": 35.0, "opposite_outer_ring": 35.0, "ambient": 20.0}
    named = {f"{name} [deg C]": value for name, value in thermal.items()} | {"acceleration": 1.0}
    return encode_truth(Truth(second * 1_000_000_000, 125.664, (0.0, -1e5), {}, {}, thermal=named))


def test_each_passage_is_published_and_a_hot_box_is_an_error(node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[Message] = []
    monkeypatch.setattr(node._publisher, "write_messages", sent.extend)
    for second, box in enumerate((35.0, 35.0, 120.0)):
        node._take(truth(second, box))
    assert [message.topic for message in sent] == [WAYSIDE_TEMPERATURE, WAYSIDE_ALARM] * 2
    assert [message.content for message in sent[::2]] == [35.0, 120.0]
    assert [message.content[1][0].level for message in sent[1::2]] == [OK, ERROR]


def test_a_bench_without_temperatures_is_read_nowhere(node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[Message] = []
    monkeypatch.setattr(node._publisher, "write_messages", sent.extend)
    for second in range(5):
        node._take(encode_truth(Truth(second * 1_000_000_000, 125.664, (0.0, -1e5), {}, {})))
    assert sent == []


def test_a_malformed_ground_truth_is_refused_in_one_sentence(node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[Message] = []
    monkeypatch.setattr(node._publisher, "write_messages", sent.extend)
    for data in (b"", b"\x00\x01\x00\x00", encode_diagnostics(0, [])):
        node._receive(data)
    assert node._refusals.count(GROUND_TRUTH.name) == 3
    partly = {"row1/outer_ring [deg C]": 35.0, "opposite_box [deg C]": 35.0}
    node._receive(encode_truth(Truth(0, 125.664, (0.0, -1e5), {}, {}, thermal=partly)))
    assert (node._refusals.count(GROUND_TRUTH.name), sent) == (3, [])
