"""Where the sensor sits: the transform from the centre of the bearing to the frame of the sensor's messages."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dcrb_ros.messages.cdr import encoded, header, ros_type
from dcrb_ros.messages.topic import Topic

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration

TF = "tf2_msgs/msg/TFMessage"
NO_TURN = 0.0, 0.0, 0.0, 1.0
SENSOR_AZIMUTH = math.pi
"""Azimuth of the sensor from the load line (-Y), counter-clockwise [rad]: the top. The rigid ring moves alike everywhere."""


def stamped(time_ns: int, parent: str, child: str, place: Sequence[float], rotation: Sequence[float] = NO_TURN) -> Any:
    """Return a TransformStamped from one frame to another, whose origin has a place [m] and whose axes have a rotation (x, y, z, w)."""
    vector, quaternion = ros_type("geometry_msgs/msg/Vector3"), ros_type("geometry_msgs/msg/Quaternion")
    pose = ros_type("geometry_msgs/msg/Transform")(vector(*place), quaternion(*rotation))
    return ros_type("geometry_msgs/msg/TransformStamped")(header(time_ns, parent), child, pose)


def encode_transforms(configuration: Configuration) -> bytes:
    """Return the transform as a TFMessage: axes of the bearing (X right, Y up, Z along the shaft), radius of the outer raceway."""
    frame, radius = configuration.publishing.frame, configuration.bearing.outer_raceway_radius
    place = radius * math.sin(SENSOR_AZIMUTH), -radius * math.cos(SENSOR_AZIMUTH), 0.0
    # The frame of the centre follows from that of the sensor, so that two bearings differ in both or in none.
    return encoded(TF, ros_type(TF)([stamped(0, f"{frame}_centre", frame, place)]))


TRANSFORMS = Topic(
    "/tf_static",
    TF,
    "place of the sensor in the bearing; of a vehicle, the places of all boxes, also in a replay; if `tf2_msgs` is installed",
    depth=1,
    latched=True,
)
