"""The transform of the sensor on /tf_static, where the package with its message type is installed; PyPI does not have it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dcrb_ros.messages.topics import TRANSFORMS, Message
from dcrb_ros.messages.topics.transforms import encode_transforms
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.ros import installed
from dcrb_ros.settings.configuration import Configuration

if TYPE_CHECKING:
    from rclpy.node import Node

PACKAGE = "tf2_msgs"


def publish_transforms(node: Node, configuration: Configuration) -> None:
    """Publish where the sensor of a bearing sits, latched, so that once is enough."""
    if installed(PACKAGE):
        Publisher(node, [TRANSFORMS]).write_messages([Message(TRANSFORMS, 0, encode_transforms(configuration))])
