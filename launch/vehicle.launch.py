"""The axle boxes of a vehicle and the detector that compares them: ros2 launch dcrb_ros vehicle.launch.py vehicle:=bogie record:=/tmp/run.

Two quiet cores nearly reach real time with four boxes; where it is not reached, use a time scale below one.
"""

from __future__ import annotations

from typing import Any

from dcrb_ros.nodes import launching
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "vehicle": launching.Argument("bogie", "vehicle: a YAML file or a shipped one"),
    "scenario": launching.Argument("", "a scenario file of the vehicle or a shipped one, such as bogie_ride"),
    "record": launching.Argument("", "folder of a recording; empty for none"),
    "duration": launching.DURATION,
    "time_scale": launching.TIME_SCALE,
    "clock": launching.Argument("", "whether to publish /clock: true or false; empty for the vehicle's", bool),
    "rerun": launching.Argument("false", "whether to show the vehicle in Rerun: true or false", bool),
    "listeners": launching.Argument("", launching.LISTENERS, int),
    "wait": launching.WAIT,
    **launching.common("dcrb"),
}
PARAMETERS = {
    "time_scale": "time_scale",
    "record": "recording.path",
    "clock": "publishing.clock",
    "listeners": "publishing.listeners",
    "wait": "publishing.wait",
}
"""Parameters of the simulator by the arguments that set them."""


def nodes(context: LaunchContext) -> list[Any]:
    """Return simulator and detector of the vehicle, with the viewer if it is requested."""
    given = launching.values_of(context, ARGUMENTS)
    if given["listeners"] is None:
        given["listeners"] = 2 if given["rerun"] else 1
    namespace = given["namespace"]
    scenario = given["scenario"]
    parameters = launching.vehicle_parameters("vehicle", given, PARAMETERS, scenario)
    extra = [
        "--vehicle",
        given["vehicle"],
        *(["--scenario", scenario] if scenario else []),
        *launching.duration_arguments(given["duration"]),
    ]
    detector = {f"boxes.{key}": value for key, value in launching.detector_parameters(given["detector"]).items()}
    return [
        *launching.suspicions(context, ARGUMENTS),
        *([launching.node("viewer", namespace, extra=["--vehicle"], required=False)] if given["rerun"] else []),
        launching.node("vehicle_simulator", namespace, parameters, extra=extra),
        launching.node("vehicle_detector", namespace, detector),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the vehicle."""
    return LaunchDescription(launching.declarations(ARGUMENTS, nodes))
