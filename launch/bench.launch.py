"""Simulator and fault detector: ros2 launch dcrb_ros bench.launch.py config:=outer_ring_defect record:=/tmp/bag."""

from __future__ import annotations

from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from dcrb_ros.nodes.launching import CONFIG, TIME_SCALE, arguments, fault_detector, given, node, simulator
from launch import LaunchContext, LaunchDescription


def nodes(context: LaunchContext) -> list[Node]:
    """Return the nodes of the bench, and the viewer where it is asked for."""
    namespace = given(context, "namespace")
    own = {
        "time_scale": float(given(context, "time_scale")),
        "recording.path": given(context, "record"),
        "publishing.clock": given(context, "clock") == "true",
    }
    return [
        *([node("viewer", namespace)] if given(context, "rerun") == "true" else []),
        simulator(namespace, given(context, "config"), own, scenario=given(context, "scenario")),
        fault_detector(namespace),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the bench."""
    described = {
        "config": ("healthy", CONFIG),
        "scenario": ("", "a scenario file or a shipped one, such as growing_spall"),
        "record": ("", "folder of a recording, empty for none"),
        "time_scale": ("1.0", TIME_SCALE),
        "clock": ("false", "whether to publish /clock: true or false"),
        "rerun": ("false", "whether to show it in Rerun: true or false"),
    }
    return LaunchDescription([*arguments(described, namespace="dcrb"), OpaqueFunction(function=nodes)])
