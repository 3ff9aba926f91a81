"""The topics of a vehicle beside those of its axle boxes: description, state, ground truth, verdicts and commands."""

from __future__ import annotations

from dcrb_ros.messages.cdr import DIAGNOSTICS, JOINT_STATE, TEXT
from dcrb_ros.messages.joints import decode_joints
from dcrb_ros.messages.plain import decode_float
from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topic import Topic
from dcrb_ros.messages.topics.transforms import TF
from dcrb_ros.messages.vehicle import decode_description

VEHICLE_DESCRIPTION = Topic(
    "vehicle/description",
    TEXT,
    "JSON: wheelsets with place, wheel radius and gear; axle boxes with side, bearing and fault orders; sampling rate",
    depth=1,
    latched=True,
    decode=decode_description,
)
VEHICLE_STATE = Topic(
    "vehicle/state",
    "nav_msgs/msg/Odometry",
    "motion of the vehicle per block, at the beginning of the last frame: `base_link` in `odom`, from the distance run and the curvature "
    "of the track; speed [m/s] in `twist.twist.linear.x`, yaw rate [rad/s] in `twist.twist.angular.z`; exact, so all covariances are zero",
)
VEHICLE_TRUTH = Topic(
    "vehicle/ground_truth",
    DIAGNOSTICS,
    "per block: a status `vehicle` with speed, place and commands; a status `axle_1/left` for each box with its load and the levels of "
    "its own bearing, of other bearings, and of track and wheels in it; a status `events/0` and so on for each joint, crossing and flat, "
    "and for each slide that begins or ends",
    decode=decode_diagnostics,
)
VEHICLE_DIAGNOSIS = Topic(
    "vehicle/diagnosis",
    DIAGNOSTICS,
    "the comparing detector: a status for each of `axle_1/left/bearing`, `axle_1/left/wheel`, `axle_1/left/sensor`, `axle_1/gear` and "
    "`track`, with verdict, confidence, score and reason",
    decode=decode_diagnostics,
)
VEHICLE_INDICATORS = Topic(
    "vehicle/indicators", JOINT_STATE, "the quantities behind these verdicts by name, in `position`", decode=decode_joints
)
VEHICLE_TRANSFORM = Topic("/tf", TF, "place of `base_link` in `odom`, per block; vehicle only, if `tf2_msgs` is installed", depth=100)


def _command(name: str, content: str) -> Topic:
    return Topic(f"vehicle/command/{name}", "std_msgs/msg/Float64", content, depth=10, decode=decode_float)


VEHICLE_COMMANDS: dict[str, Topic] = {
    "speed_kmh": _command("speed_kmh", "speed of the vehicle [km/h], reached with `vehicle.ramp`"),
    "curvature": _command("curvature", "curvature of the track [1/m], positive to the left"),
    "brake": _command("brake", "deceleration by the brakes [m/s²]"),
    "wind": _command("wind", "force of the wind on the side of the vehicle [N], positive to the left"),
    "cant": _command("cant", "height of the outer rail over the inner one [m]"),
}
"""Commands by the names that the simulation gives them."""
VEHICLE_DETECTED: tuple[Topic, ...] = (VEHICLE_DIAGNOSIS, VEHICLE_INDICATORS)
"""Topics of the comparing detector."""
VEHICLE: tuple[Topic, ...] = (VEHICLE_DESCRIPTION, VEHICLE_STATE, VEHICLE_TRUTH, *VEHICLE_DETECTED, VEHICLE_TRANSFORM)
"""Topics of a vehicle beside those of its boxes."""
