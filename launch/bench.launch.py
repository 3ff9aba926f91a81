"""Simulator and fault detector: ros2 launch dcrb_ros bench.launch.py config:=outer_ring_defect record:=/tmp/bag."""

from __future__ import annotations

from typing import Any

from dcrb_ros.nodes import launching
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "config": launching.CONFIG,
    "scenario": launching.Argument("", "a scenario file or a shipped one, such as growing_spall"),
    **launching.run_arguments("configuration", "bench"),
}


def nodes(context: LaunchContext) -> list[Any]:
    """Return the nodes of the bench, with the viewer if it is requested."""
    given = launching.values_of(context, ARGUMENTS)
    namespace = given["namespace"]
    parameters = launching.simulator_parameters("config", given, launching.RUN, given["scenario"])
    return [
        *launching.suspicions(context, ARGUMENTS),
        *([launching.node("viewer", namespace, required=False)] if given["rerun"] else []),
        launching.node("simulator", namespace, parameters, extra=launching.run_options(given)),
        launching.detector_node(namespace, given["detector"]),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the bench."""
    return LaunchDescription(launching.declarations(ARGUMENTS, nodes))
