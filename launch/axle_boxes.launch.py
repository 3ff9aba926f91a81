"""Four axle boxes, each with its own bearing, seed and namespace: ros2 launch dcrb_ros axle_boxes.launch.py.

The third box has the configuration `fault`. Each box needs a core for real time; with fewer than four cores use a time scale below one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from dcrb_ros.nodes import launching
from launch import LaunchContext, LaunchDescription

BOXES = 4
FAULTY = 3
NUMBERED = "simulation.seed is the number of the box, and recording.path has a folder for each box"
ARGUMENTS = {
    "config": replace(launching.CONFIG, description=f"configuration of the healthy boxes: a YAML file or a shipped one; {NUMBERED}"),
    "fault": launching.Argument("outer_ring_defect", f"configuration of box {FAULTY}; {NUMBERED}"),
    "time_scale": launching.TIME_SCALE,
    "clock": launching.Argument("false", "whether box 1 publishes /clock: true or false", bool),
    "wait": launching.WAIT,
    **launching.common("wagon"),
}
PARAMETERS = {"time_scale": "time_scale", "wait": "publishing.wait"}
"""Parameters of every simulator by the arguments that set them."""


def nodes(context: LaunchContext) -> list[Any]:
    """Return simulator and fault detector of every box."""
    given, actions = launching.values_of(context, ARGUMENTS), launching.suspicions(context, ARGUMENTS)
    for box in range(1, BOXES + 1):
        namespace, argument = f"{given['namespace']}/box{box}", "fault" if box == FAULTY else "config"
        parameters = {
            **launching.simulator_parameters(argument, given, PARAMETERS),
            "simulation.seed": box,
            # A frame of tf2 does not begin with a slash.
            "publishing.frame": f"{namespace}/outer_ring".lstrip("/"),
            # A graph has one /clock; the boxes start together and have the same time scale.
            "publishing.clock": box == 1 and bool(given["clock"]),
        }
        if path := parameters.get("recording.path"):
            parameters["recording.path"] = f"{path}/box{box}"
        actions += [launching.node("simulator", namespace, parameters), launching.detector_node(namespace, given["detector"])]
    return actions


def generate_launch_description() -> LaunchDescription:
    """Describe the axle boxes of a wagon."""
    return LaunchDescription(launching.declarations(ARGUMENTS, nodes))
