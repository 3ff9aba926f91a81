"""Simulator and fault detector: ros2 launch dcrb_ros bench.launch.py config:=outer_ring_defect record:=/tmp/bag."""

from __future__ import annotations

from typing import Any

from dcrb_ros.nodes.launching import (
    CONFIG,
    LISTENERS,
    TIME_SCALE,
    WAIT,
    Argument,
    common,
    declarations,
    detector_parameters,
    node,
    simulator_parameters,
    suspicions,
    values_of,
)
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "config": CONFIG,
    "scenario": Argument("", "a scenario file or a shipped one, such as growing_spall"),
    "record": Argument("", "folder of a recording; empty for the configuration's"),
    "time_scale": TIME_SCALE,
    "clock": Argument("", "whether to publish /clock: true or false; empty for the configuration's", bool),
    "rerun": Argument("false", "whether to show the bench in Rerun: true or false", bool),
    "listeners": Argument("", LISTENERS, int),
    "wait": WAIT,
    **common("dcrb"),
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
    given = values_of(context, ARGUMENTS)
    if given["listeners"] is None:
        given["listeners"] = 2 if given["rerun"] else 1
    namespace, scenario = given["namespace"], given["scenario"]
    parameters = simulator_parameters("config", given, PARAMETERS, scenario)
    extra = ["--scenario", scenario] if scenario else []
    return [
        *suspicions(context, ARGUMENTS),
        *([node("viewer", namespace, required=False)] if given["rerun"] else []),
        node("simulator", namespace, parameters, extra=extra),
        node("fault_detector", namespace, detector_parameters(given["detector"])),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the bench."""
    return LaunchDescription(declarations(ARGUMENTS, nodes))
