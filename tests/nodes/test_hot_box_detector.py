"""The node of the wayside hot-box detector: a message for each passage, and a warning where there is nothing to read."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from dcrb_ros.diagnosis.wayside import WaysideParameters
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.messages.statuses import ERROR, OK, encode_diagnostics, encode_truth
from dcrb_ros.messages.topics import GROUND_TRUTH, WAYSIDE_ALARM, WAYSIDE_TEMPERATURE, Message
from dcrb_ros.stream.block import Truth

rclpy = pytest.importorskip("rclpy")


def made(*arguments: str) -> Iterator[Any]:
    """Yield a node with arguments for ROS."""
    from dcrb_ros.nodes.hot_box_detector import HotBoxDetectorNode

    rclpy.init(args=["--ros-args", "-p", "spacing:=0.05", *arguments])
    node = HotBoxDetectorNode()
    try:
        yield node
    finally:
        node.close()
        node.destroy_node()
        rclpy.try_shutdown()


@pytest.fixture
def node() -> Iterator[Any]:
    yield from made("-p", "noise:=0.0")


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


def test_the_nodes_of_several_boxes_have_noise_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for namespace in ("/dcrb", "/dcrb/axle_1/left", "/dcrb/axle_1/right"):
        for node in made("-r", f"__ns:={namespace}"):
            sent: list[Message] = []
            monkeypatch.setattr(node._publisher, "write_messages", sent.extend)
            for second in range(2):
                node._take(truth(second, 35.0))
            found.append(sent[0].content)
    drawn = random_stream(WaysideParameters().seed, "wayside detector").standard_normal()
    assert found[0] == pytest.approx(35.0 + WaysideParameters().noise * drawn)
    assert len(set(found)) == 3
