"""The axle boxes of a vehicle and the detector that compares them: ros2 launch dcrb_ros vehicle.launch.py vehicle:=bogie record:=/tmp/run.

Four boxes at real time need more than two cores; where it is not reached, use a time scale below one.
"""

from __future__ import annotations

from typing import Any

from dcrb_ros.nodes import launching
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "vehicle": launching.Argument("bogie", "vehicle: a YAML file or a shipped one"),
    "scenario": launching.Argument("", "a scenario file of the vehicle or a shipped one, such as bogie_ride"),
    **launching.run_arguments("vehicle", "vehicle"),
}


def nodes(context: LaunchContext) -> list[Any]:
    """Return simulator and detector of the vehicle, with the viewer if it is requested."""
    given = launching.values_of(context, ARGUMENTS)
    namespace = given["namespace"]
    parameters = launching.vehicle_parameters("vehicle", given, launching.RUN, given["scenario"])
    extra = ["--vehicle", given["vehicle"], *launching.run_options(given)]
    return [
        *launching.suspicions(context, ARGUMENTS),
        *([launching.node("viewer", namespace, extra=["--vehicle"], required=False)] if given["rerun"] else []),
        launching.node("vehicle_simulator", namespace, parameters, extra=extra),
        launching.detector_node(namespace, given["detector"], of_vehicle=True),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the vehicle."""
    return LaunchDescription(launching.declarations(ARGUMENTS, nodes))
