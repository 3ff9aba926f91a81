"""Four axle boxes, each with its own bearing, seed and namespace: ros2 launch dcrb_ros axle_boxes.launch.py.

The third box has the configuration `fault`. Each box needs a core for real time; with fewer than four cores use a time scale below one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from dcrb_ros.nodes.launching import (
    CONFIG,
    TIME_SCALE,
    WAIT,
    Argument,
    common,
    configuration_file,
    declarations,
    detector_file,
    node,
    parameters_of,
    suspicions,
    values_of,
)
from launch import LaunchContext, LaunchDescription

BOXES = 4
FAULTY = 3
ARGUMENTS = {
    "config": replace(CONFIG, description="configuration of the healthy boxes: a YAML file or a shipped one"),
    "fault": Argument("outer_ring_defect", f"configuration of box {FAULTY}"),
    "time_scale": TIME_SCALE,
    "clock": Argument("false", "whether box 1 publishes /clock: true or false", bool),
    "wait": WAIT,
    **common("wagon"),
}
PARAMETERS = {"time_scale": "time_scale", "wait": "publishing.wait"}
"""Parameters of every simulator by the arguments that set them."""


def nodes(context: LaunchContext) -> list[Any]:
    """Return simulator and fault detector of every box."""
    given, found = values_of(context, ARGUMENTS), suspicions(context, ARGUMENTS)
    detector = detector_file(given["detector"])
    for box in range(1, BOXES + 1):
        namespace, argument = f"{given['namespace']}/box{box}", "fault" if box == FAULTY else "config"
        parameters = {
            "simulation.seed": box,
            "publishing.frame": f"{namespace}/outer_ring",
            # A graph has one /clock; the boxes start together and have the same time scale.
            "publishing.clock": box == 1 and bool(given["clock"]),
            "publishing.listeners": 1,
            **parameters_of(given, PARAMETERS),
        }
        file = configuration_file(argument, given, PARAMETERS)
        found += [node("simulator", namespace, file=file, parameters=parameters), node("fault_detector", namespace, file=detector)]
    return found


def generate_launch_description() -> LaunchDescription:
    """Describe the axle boxes of a wagon."""
    return LaunchDescription(declarations(ARGUMENTS, nodes))
