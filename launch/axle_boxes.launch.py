"""Four axle boxes at once, each with a bearing, a seed and a namespace of its own: ros2 launch dcrb_ros axle_boxes.launch.py.

The third box has what `fault` says. One core carries one box in real time, so four cores are wanted, or a time scale below one.
"""

from __future__ import annotations

from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from dcrb_ros.nodes.launching import TIME_SCALE, arguments, asked, fault_detector, given, simulator
from launch import LaunchContext, LaunchDescription

BOXES = 4
FAULTY = 3


def nodes(context: LaunchContext) -> list[Node]:
    """Return simulator and fault detector of every box."""
    found = []
    for box in range(1, BOXES + 1):
        namespace = f"{given(context, 'namespace')}/box{box}"
        own = {
            "simulation.seed": box,
            "publishing.frame": f"{namespace}/outer_ring",
            # There is one /clock in a graph; the boxes start together and keep the same time scale.
            "publishing.clock": box == 1 and given(context, "clock") == "true",
            **asked(context, {"time_scale": ("time_scale", float)}),
        }
        config = given(context, "fault" if box == FAULTY else "config")
        found += [simulator(namespace, config, own), fault_detector(namespace, given(context, "detector"))]
    return found


def generate_launch_description() -> LaunchDescription:
    """Describe the axle boxes of a wagon."""
    described = {
        "config": ("healthy", "bench of the sound boxes: a YAML file or a shipped one"),
        "fault": ("outer_ring_defect", f"bench of box {FAULTY}"),
        "time_scale": ("", TIME_SCALE),
        "clock": ("false", "whether box 1 publishes /clock: true or false"),
    }
    return LaunchDescription([*arguments(described, namespace="wagon"), OpaqueFunction(function=nodes)])
