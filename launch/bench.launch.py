"""Simulator and fault detector: ros2 launch dcrb_ros bench.launch.py config:=outer_ring_defect record:=/tmp/bag."""

from __future__ import annotations

from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from dcrb_ros.nodes.launching import CONFIG, TIME_SCALE, arguments, asked, fault_detector, given, node, simulator
from launch import LaunchContext, LaunchDescription

OWN = {
    "time_scale": ("time_scale", float),
    "record": ("recording.path", str),
    "clock": ("publishing.clock", lambda said: said == "true"),
}
"""Parameters that have an argument of their own."""


def nodes(context: LaunchContext) -> list[Node]:
    """Return the nodes of the bench, and the viewer where it is asked for."""
    namespace = given(context, "namespace")
    own = asked(context, OWN)
    return [
        *([node("viewer", namespace)] if given(context, "rerun") == "true" else []),
        simulator(namespace, given(context, "config"), own, scenario=given(context, "scenario")),
        fault_detector(namespace, given(context, "detector")),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the bench."""
    described = {
        "config": ("healthy", CONFIG),
        "scenario": ("", "a scenario file or a shipped one, such as growing_spall"),
        "record": ("", "folder of a recording; empty for the configuration's"),
        "time_scale": ("", TIME_SCALE),
        "clock": ("", "whether to publish /clock: true or false; empty for the configuration's"),
        "rerun": ("false", "whether to show it in Rerun: true or false"),
    }
    return LaunchDescription([*arguments(described, namespace="dcrb"), OpaqueFunction(function=nodes)])
