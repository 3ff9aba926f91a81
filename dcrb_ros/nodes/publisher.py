"""Messages to ROS topics, as the bytes they were encoded to."""

from __future__ import annotations

import importlib
import time
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from dcrb_ros.messages.topics import Message, Topic

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.qos import QoSProfile


def qos(topic: Topic) -> QoSProfile:
    """Return the quality of service of a topic."""
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    durability = DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE
    return QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=topic.depth, reliability=ReliabilityPolicy.RELIABLE, durability=durability)


def message_class(topic: Topic) -> type[Any]:
    """Return the message class of a topic."""
    package, _, name = topic.type.split("/")
    found: type[Any] = getattr(importlib.import_module(f"{package}.msg"), name)
    return found


class Publisher:
    """A sink that publishes on a node's topics; a topic is created with its first use or beforehand."""

    def __init__(self, node: Node, topics: Iterable[Topic]) -> None:
        self._node = node
        self._publishers: dict[Topic, Any] = {
            topic: node.create_publisher(message_class(topic), topic.name, qos(topic)) for topic in topics
        }

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Publish messages."""
        for message in messages:
            self._publishers[message.topic].publish(message.data)

    def listeners(self, topic: Topic) -> int:
        """Return how many subscribers a topic has."""
        return int(self._publishers[topic].get_subscription_count())

    def settle(self, seconds: float) -> None:
        """Wait until what was published has arrived, at most ``seconds`` [s] in all."""
        from rclpy.duration import Duration

        end = time.monotonic() + seconds
        for publisher in self._publishers.values():
            publisher.wait_for_all_acked(Duration(seconds=max(0.0, end - time.monotonic())))
