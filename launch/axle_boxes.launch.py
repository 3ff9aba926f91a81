"""Four axle boxes, each with its own bearing, seed and namespace: ros2 launch dcrb_ros axle_boxes.launch.py.

The third box has the configuration `fault`. Each box needs a core for real time; with fewer than four cores use a time scale below one.
"""

from __future__ import annotations

from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from dcrb_ros.nodes.launching import TIME_SCALE, arguments, fault_detector, parameters_from, simulator, value_of
from launch import LaunchContext, LaunchDescription

BOXES = 4
FAULTY = 3


def nodes(context: LaunchContext) -> list[Node]:
    """Return simulator and fault detector of every box."""
    found = []
    for box in range(1, BOXES + 1):
        namespace = f"{value_of(context, 'namespace')}/box{box}"
        parameters = {
            "simulation.seed": box,
            "publishing.frame": f"{namespace}/outer_ring",
            # A graph has one /clock; the boxes start together and have the same time scale.
            "publishing.clock": box == 1 and value_of(context, "clock") == "true",
            **parameters_from(context, {"time_scale": ("time_scale", float)}),
        }
        config = value_of(context, "fault" if box == FAULTY else "config")
        found += [simulator(namespace, config, parameters), fault_detector(namespace, value_of(context, "detector"))]
    return found


def generate_launch_description() -> LaunchDescription:
    """Describe the axle boxes of a wagon."""
    described = {
        "config": ("healthy", "configuration of the healthy boxes: a YAML file or a shipped one"),
        "fault": ("outer_ring_defect", f"configuration of box {FAULTY}"),
        "time_scale": ("", TIME_SCALE),
        "clock": ("false", "whether box 1 publishes /clock: true or false"),
    }
    return LaunchDescription([*arguments(described, namespace="wagon"), OpaqueFunction(function=nodes)])
