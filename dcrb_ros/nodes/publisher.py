"""Messages to and from ROS topics, as the bytes to which they were encoded."""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import Message, Topic

DELIVERY_TIMEOUT = 5.0
"""Wall time in which the last messages must be delivered [s]. Every 3 s Fast DDS asks each subscriber which messages it lacks."""
OPTIONAL = "tf2_msgs"
"""Package of messages that PyPI does not have."""

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.qos import QoSProfile


def qos(topic: Topic) -> QoSProfile:
    """Return the quality of service of a topic for rclpy."""
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    policies: dict[str, Any] = {"history": HistoryPolicy, "reliability": ReliabilityPolicy, "durability": DurabilityPolicy}
    return QoSProfile(depth=topic.qos["depth"], **{name: kind.get_from_short_key(topic.qos[name]) for name, kind in policies.items()})


def message_class(topic: Topic) -> type[Any]:
    """Return the message class of a topic."""
    package, _, name = topic.type.split("/")
    kind: type[Any] = getattr(importlib.import_module(f"{package}.msg"), name)
    return kind


def subscribe(node: Any, topic: Topic, receive: Callable[[bytes], None], **options: Any) -> Any:
    """Pass the bytes of each message on a topic to ``receive``; return the subscription of the node.

    The middleware does not decode them: it would drop malformed messages silently.
    """
    return node.create_subscription(message_class(topic), topic.name, lambda data: receive(bytes(data)), qos(topic), raw=True, **options)


class Publisher:
    """A sink that publishes on topics of a node; without the package `OPTIONAL`, transforms are left out."""

    def __init__(self, node: Node, topics: Iterable[Topic]) -> None:
        from dcrb_ros.nodes.qos_overrides import overridable

        self._node = node
        # Latched topics last: who has received one of their messages has discovered the publishers of the others.
        ordered = sorted(topics, key=lambda topic: topic.latched)
        self._absent = {topic for topic in ordered if topic.type.startswith(OPTIONAL) and importlib.util.find_spec(OPTIONAL) is None}
        self._publishers: dict[Topic, Any] = {
            topic: node.create_publisher(message_class(topic), topic.name, qos(topic), qos_overriding_options=overridable())
            for topic in ordered
            if topic not in self._absent
        }

    def start(self, messages: Sequence[Message]) -> None:
        """Publish the messages that precede the first bundle."""
        self.write_messages(messages)

    def write(self, bundle: Bundle) -> None:
        """Publish the messages of a bundle."""
        self.write_messages(bundle.messages)

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Publish messages."""
        for message in messages:
            if message.topic not in self._absent:
                self._publishers[message.topic].publish(message.data)

    def subscribers(self, topic: Topic) -> int:
        """Return the number of subscribers to a topic."""
        return int(self._publishers[topic].get_subscription_count())

    def delivered(self, topic: Topic) -> bool:
        """Return whether every subscriber to a topic has acknowledged its messages."""
        from rclpy.duration import Duration

        return bool(self._publishers[topic].wait_for_all_acked(Duration(seconds=0.0)))

    def flush(self) -> None:
        """Wait until the published messages have been delivered on all topics, at most `DELIVERY_TIMEOUT` in total."""
        from rclpy.duration import Duration

        deadline = time.monotonic() + DELIVERY_TIMEOUT
        for publisher in self._publishers.values():
            publisher.wait_for_all_acked(Duration(seconds=max(0.0, deadline - time.monotonic())))

    def close(self) -> None:
        """Leave the topics."""
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)
