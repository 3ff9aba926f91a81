"""Where the sensor sits: the transform from the centre of the bearing to the frame of the sensor's messages."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from dcrb_ros.messages.cdr import encoded, header, ros_type
from dcrb_ros.messages.topic import Topic

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration

TF = "tf2_msgs/msg/TFMessage"
SENSOR_AZIMUTH = math.pi
"""Azimuth of the sensor from the load line (-Y), counter-clockwise [rad]: the top. The rigid ring moves alike everywhere."""


def centre_frame(frame: str) -> str:
    """Return the frame of a bearing's centre from that of its sensor, so that two bearings differ in both or in none."""
    return f"{frame}_centre"


def encode_transforms(configuration: Configuration) -> bytes:
    """Return the transform as a TFMessage: axes of the bearing (X right, Y up, Z along the shaft), radius of the outer raceway."""
    frame, radius = configuration.publishing.frame, configuration.bearing.outer_raceway_radius
    vector, quaternion = ros_type("geometry_msgs/msg/Vector3"), ros_type("geometry_msgs/msg/Quaternion")
    position = vector(radius * math.sin(SENSOR_AZIMUTH), -radius * math.cos(SENSOR_AZIMUTH), 0.0)
    pose = ros_type("geometry_msgs/msg/Transform")(position, quaternion(0.0, 0.0, 0.0, 1.0))
    stamped = ros_type("geometry_msgs/msg/TransformStamped")(header(0, centre_frame(frame)), frame, pose)
    return encoded(TF, ros_type(TF)([stamped]))


TRANSFORMS = Topic(
    "/tf_static", TF, "place of the sensor in the bearing; simulator only, if `tf2_msgs` is installed", depth=1, latched=True
)
