"""The transform of the sensor: what it says, and that it is published where its message type is installed."""

from __future__ import annotations

import importlib.util
import sys
from types import ModuleType
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from dcrb_ros.messages.topics import TRANSFORMS, Message
from dcrb_ros.messages.topics.transforms import encode_transforms
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.settings.configuration import Configuration

BOX = Configuration.model_validate({"publishing": {"frame": "wagon/box1/outer_ring"}, "bearing": {"outer_raceway_radius": 0.10915}})


class Graph:
    """A node that keeps its publishers and what is published."""

    def __init__(self) -> None:
        self.publishers: list[tuple[type, str, Any]] = []
        self.published: list[bytes] = []

    def create_publisher(self, kind: type, name: str, qos: Any, *, qos_overriding_options: Any) -> Graph:
        self.publishers.append((kind, name, qos))
        return self

    def publish(self, data: bytes) -> None:
        self.published.append(data)


def publish(graph: Graph) -> None:
    """Publish the transform as the simulator does."""
    Publisher(graph, [TRANSFORMS]).write_messages([Message(TRANSFORMS, 0, encode_transforms(BOX))])  # type: ignore[arg-type]


def test_the_sensor_sits_at_the_top_of_the_outer_raceway_with_the_axes_of_the_bearing(monkeypatch: pytest.MonkeyPatch) -> None:
    from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

    stub = ModuleType("tf2_msgs.msg")
    stub.TFMessage = type("TFMessage", (), {})  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "tf2_msgs", ModuleType("tf2_msgs"))
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", stub)
    monkeypatch.setattr(importlib.util, "find_spec", lambda package: package)
    graph = Graph()
    publish(graph)
    ((kind, name, qos),) = graph.publishers
    assert (kind, name) == (stub.TFMessage, "/tf_static")
    assert (qos.durability, qos.reliability) == (DurabilityPolicy.TRANSIENT_LOCAL, ReliabilityPolicy.RELIABLE)
    ((found,),) = (TRANSFORMS.decoded(data).transforms for data in graph.published)
    assert (found.header.frame_id, found.child_frame_id) == ("wagon/box1/outer_ring_centre", "wagon/box1/outer_ring")
    place, turn = found.transform.translation, found.transform.rotation
    assert (place.x, place.y, place.z) == pytest.approx((0.0, 0.10915, 0.0), abs=1e-15)
    assert (turn.x, turn.y, turn.z, turn.w) == (0.0, 0.0, 0.0, 1.0)


def test_nothing_is_published_without_the_message_type(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda package: None)
    graph = Graph()
    publish(graph)
    assert graph.publishers == []
