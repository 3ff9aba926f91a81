"""Simulator and fault detector: ros2 launch dcrb_ros bench.launch.py config:=outer_ring_defect record:=/tmp/bag."""

from __future__ import annotations

from launch.actions import OpaqueFunction
from launch_ros.actions import Node

from dcrb_ros.nodes.launching import CONFIG, TIME_SCALE, arguments, fault_detector, node, parameters_from, simulator, value_of
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "time_scale": ("time_scale", float),
    "record": ("recording.path", str),
    "clock": ("publishing.clock", lambda text: text == "true"),
}
"""Arguments with the parameters that they set."""


def nodes(context: LaunchContext) -> list[Node]:
    """Return the nodes of the bench, with the viewer if it is requested."""
    namespace = value_of(context, "namespace")
    parameters = parameters_from(context, ARGUMENTS)
    return [
        *([node("viewer", namespace)] if value_of(context, "rerun") == "true" else []),
        simulator(namespace, value_of(context, "config"), parameters, scenario=value_of(context, "scenario")),
        fault_detector(namespace, value_of(context, "detector")),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the bench."""
    described = {
        "config": ("healthy", CONFIG),
        "scenario": ("", "a scenario file or a shipped one, such as growing_spall"),
        "record": ("", "folder of a recording; empty for the configuration's"),
        "time_scale": ("", TIME_SCALE),
        "clock": ("", "whether to publish /clock: true or false; empty for the configuration's"),
        "rerun": ("false", "whether to show the bench in Rerun: true or false"),
    }
    return LaunchDescription([*arguments(described, namespace="dcrb"), OpaqueFunction(function=nodes)])
