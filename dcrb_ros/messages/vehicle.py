"""Messages about a vehicle: description, motion, frames, ground truth and diagnosis."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np

from dcrb_ros.messages.cdr import encoded, header, ros_type
from dcrb_ros.messages.plain import decode_text
from dcrb_ros.messages.statuses import ERROR, OK, WARN, Status, decode_diagnostics, encode_diagnostics
from dcrb_ros.messages.topics.transforms import TF, stamped
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import UNDECIDED, VehicleDiagnosis, kind_of
from dcrb_ros.text.json import parsed_json
from dcrb_ros.vehicle.block import VehicleTruth
from dcrb_ros.vehicle.description import JOURNAL_DISTANCE, Vehicle

ODOMETRY = "nav_msgs/msg/Odometry"
ODOM, BASE, BOGIE = "odom", "base_link", "bogie"
"""Frames of the track, of the vehicle at rail level, and of the bogie at the height of its axles."""
FROM_LEFT = 0.0, 0.5**0.5, 0.5**0.5, 0.0
"""Quaternion (x, y, z, w) of a bearing seen from the left in the frame of its box: X backwards, Y up, Z to the left."""
GIVEN = "command "
"""Begin of the message of the status `vehicle` where commands were given."""
CONTEXT = ("gear", "track")
"""Kinds of status whose verdicts name a cause that is no fault of the vehicle."""

Quaternion = tuple[float, float, float, float]


def decode_description(data: bytes) -> VehicleDescription:
    """Return the description of a vehicle."""
    return VehicleDescription.from_json(decode_text(data))


def box_path(name: str) -> str:
    """Return the relative namespace and frame of a box from its name, ``axle_1/left`` for ``axle_1.left``."""
    return name.replace(".", "/")


@dataclasses.dataclass(frozen=True)
class Pose:
    """Where the vehicle is in the frame of the track."""

    x: float
    """[m]"""
    y: float
    """[m]"""
    yaw: float
    """Heading, counter-clockwise from x [rad]."""

    def moved(self, distance: float, curvature: float) -> Pose:
        """Return the pose after a distance [m] along a curve [1/m]; each step is a chord."""
        middle = self.yaw + 0.5 * curvature * distance
        return Pose(self.x + distance * math.cos(middle), self.y + distance * math.sin(middle), self.yaw + curvature * distance)

    @property
    def rotation(self) -> Quaternion:
        """The heading as a quaternion."""
        return 0.0, 0.0, math.sin(0.5 * self.yaw), math.cos(0.5 * self.yaw)


def encode_state(time_ns: int, pose: Pose, speed: float, yaw_rate: float) -> bytes:
    """Return the motion of the vehicle as an Odometry, with speed [m/s] and yaw rate [rad/s] in the frame of the vehicle."""
    vector = ros_type("geometry_msgs/msg/Vector3")
    where = ros_type("geometry_msgs/msg/Pose")(
        ros_type("geometry_msgs/msg/Point")(pose.x, pose.y, 0.0), ros_type("geometry_msgs/msg/Quaternion")(*pose.rotation)
    )
    moving = ros_type("geometry_msgs/msg/Twist")(vector(speed, 0.0, 0.0), vector(0.0, 0.0, yaw_rate))
    exact = np.zeros(36)
    message = ros_type(ODOMETRY)(
        header(time_ns, ODOM),
        BASE,
        ros_type("geometry_msgs/msg/PoseWithCovariance")(where, exact),
        ros_type("geometry_msgs/msg/TwistWithCovariance")(moving, exact),
    )
    return encoded(ODOMETRY, message)


def encode_pose(time_ns: int, pose: Pose) -> bytes:
    """Return the transform from the track to the vehicle as a TFMessage."""
    return encoded(TF, ros_type(TF)([stamped(time_ns, ODOM, BASE, (pose.x, pose.y, 0.0), pose.rotation)]))


def encode_frames(vehicle: Vehicle) -> bytes:
    """Return the frames of bogie, wheelsets, boxes and bearings as a TFMessage: ``base_link > bogie > axle_1 > axle_1/left > ...``."""
    height = float(np.mean([axle.radius for axle in vehicle.axles]))
    transforms = [stamped(0, BASE, BOGIE, (0.0, 0.0, height))]
    transforms += [stamped(0, BOGIE, axle.name, (axle.x, 0.0, axle.radius - height)) for axle in vehicle.axles]
    for box in vehicle.boxes:
        frame = box_path(box.name)
        transforms.append(stamped(0, vehicle.axles[box.axle].name, frame, (0.0, 0.5 * JOURNAL_DISTANCE * box.side, 0.0)))
        transforms.append(stamped(0, frame, box.configuration.publishing.frame, (0.0, 0.0, 0.0), FROM_LEFT))
    return encoded(TF, ros_type(TF)(transforms))


def encode_vehicle_truth(truth: VehicleTruth) -> bytes:
    """Return the ground truth of a vehicle: a status of the vehicle, one of each box, and one of each event on the track."""
    run = {"speed [m/s]": repr(truth.speed), "place [m]": repr(truth.place)}
    run |= {name: repr(value) for name, value in truth.commanded.items()}
    run |= {f"{axle}.creep": repr(value) for axle, value in truth.creep.items()}
    said = GIVEN + json.dumps(truth.commands) if truth.commands else ""
    statuses = [Status("vehicle", OK, said, run)]
    for name, load in truth.load.items():
        own, others, track = truth.parts[name]
        values = {"load [N]": load, "own_bearing [m/s^2]": own, "other_bearings [m/s^2]": others, "track_and_wheels [m/s^2]": track}
        words = {key: repr(value) for key, value in values.items()}
        silent = f"{truth.silent[name]}: silent" if name in truth.silent else ""
        statuses.append(Status(box_path(name), ERROR if silent else OK, silent, words))
    for number, event in enumerate(truth.events):
        about = {key: value for key, value in dataclasses.asdict(event).items() if key != "cause"}
        words = {key: box_path(value) if isinstance(value, str) else repr(value) for key, value in about.items()}
        statuses.append(Status(f"events/{number}", OK, event.cause, words))
    return encode_diagnostics(truth.time_ns, statuses, BASE)


def decode_vehicle_commands(data: bytes) -> list[tuple[str, float | str]]:
    """Return the commands in the ground truth of a vehicle, in their order, and the changes of wheels and slides by their keys.

    Raises:
        Refusal: the message is no such ground truth.
    """
    _, statuses = decode_diagnostics(data)
    said = statuses[0].message if statuses else ""
    if not said.startswith(GIVEN):
        return []
    listed = parsed_json(said.removeprefix(GIVEN), "the ground truth of the vehicle")
    try:
        return [(str(name), value if isinstance(value, str) else float(value)) for name, value in listed]
    except (TypeError, ValueError):
        raise Refusal(f"the commands {said} in the ground truth of the vehicle are not names with values") from None


def encode_vehicle_diagnosis(diagnosis: VehicleDiagnosis, frame: str = BASE) -> bytes:
    """Return the verdicts on a vehicle: a status for each part, with verdict, confidence, score and reason."""
    statuses = []
    for name, status in diagnosis.statuses.items():
        values = {"verdict": status.verdict, "confidence": f"{status.confidence:.3f}", "score [dB]": f"{status.score:.2f}"}
        values["reason"] = status.reason
        statuses.append(Status(name, _level(name, status.verdict), status.verdict, values))
    return encode_diagnostics(diagnosis.time_ns, statuses, frame)


def _level(name: str, verdict: str) -> int:
    """Return the level of a verdict: a warning where the signals allow several causes, an error for a fault."""
    if verdict in ("healthy", "waiting") or kind_of(name) in CONTEXT:
        return OK
    return WARN if verdict == UNDECIDED or kind_of(name) == "sensor" else ERROR
