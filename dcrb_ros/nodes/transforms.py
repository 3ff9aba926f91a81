"""The transform of the sensor on /tf_static; it is left out where the package with its message type is not installed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dcrb_ros.messages.topics import TRANSFORMS, Message
from dcrb_ros.messages.topics.transforms import encode_transforms
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.settings.configuration import Configuration

if TYPE_CHECKING:
    from rclpy.node import Node


def publish_transforms(node: Node, configuration: Configuration) -> None:
    """Publish where the sensor of a bearing sits, latched, so that once is enough."""
    Publisher(node, [TRANSFORMS]).write_messages([Message(TRANSFORMS, 0, encode_transforms(configuration))])
