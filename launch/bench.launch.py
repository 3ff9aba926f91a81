"""Simulator and fault detector: ros2 launch dcrb_ros bench.launch.py config:=outer_ring_defect record:=/tmp/bag."""

from __future__ import annotations

from typing import Any

from dcrb_ros.nodes import launching
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "config": launching.CONFIG,
    "scenario": launching.Argument("", "a scenario file or a shipped one, such as growing_spall"),
    "record": launching.Argument("", "folder of a recording; empty for the configuration's"),
    "duration": launching.DURATION,
    "time_scale": launching.TIME_SCALE,
    "clock": launching.Argument("", "whether to publish /clock: true or false; empty for the configuration's", bool),
    "rerun": launching.Argument("false", "whether to show the bench in Rerun: true or false", bool),
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
    """Return the nodes of the bench, with the viewer if it is requested."""
    given = launching.values_of(context, ARGUMENTS)
    if given["listeners"] is None:
        given["listeners"] = 2 if given["rerun"] else 1
    namespace, scenario = given["namespace"], given["scenario"]
    parameters = launching.simulator_parameters("config", given, PARAMETERS, scenario)
    extra = [*(["--scenario", scenario] if scenario else []), *launching.duration_arguments(given["duration"])]
    return [
        *launching.suspicions(context, ARGUMENTS),
        *([launching.node("viewer", namespace, required=False)] if given["rerun"] else []),
        launching.node("simulator", namespace, parameters, extra=extra),
        launching.node("fault_detector", namespace, launching.detector_parameters(given["detector"])),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the bench."""
    return LaunchDescription(launching.declarations(ARGUMENTS, nodes))
