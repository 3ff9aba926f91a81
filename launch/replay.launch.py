"""Replayer and fault detector: ros2 launch dcrb_ros replay.launch.py bag:=/tmp/bag."""

from __future__ import annotations

from typing import Any

from dcrb_ros.nodes.launching import (
    LISTENERS,
    WAIT,
    Argument,
    common,
    declarations,
    detector_parameters,
    naming,
    node,
    suspicions,
    values_of,
)
from dcrb_ros.recordings.replay import Replay, ReplayParameters
from dcrb_ros.settings.files import validated
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "bag": Argument(None, "a recording: its folder or an .mcap file"),
    "rate": Argument("1.0", "recorded over wall time, 0.0 as fast as possible", float),
    "loop": Argument("false", "whether to start again at the end: true or false", bool),
    "offset": Argument("0.0", "recorded time to skip at the beginning [s]", float),
    "clock": Argument("false", "whether to publish /clock: true or false", bool),
    "topics": Argument("", "topics to publish, such as 'outer_ring/vibration, diagnosis'; empty for those of the simulator"),
    "listeners": Argument("1", LISTENERS, int),
    "wait": WAIT,
    **common("dcrb"),
}


def nodes(context: LaunchContext) -> list[Any]:
    """Return the replayer and the fault detector."""
    given = values_of(context, ARGUMENTS)
    namespace = given["namespace"]
    parameters = {name: given[name] for name in ReplayParameters.model_fields if given[name] is not None}
    replayed = validated(parameters, ReplayParameters, "replay")
    with naming("bag", replayed.bag):
        Replay(replayed)
    return [
        *suspicions(context, ARGUMENTS),
        node("replayer", namespace, parameters),
        node("fault_detector", namespace, detector_parameters(given["detector"])),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the replay."""
    return LaunchDescription(declarations(ARGUMENTS, nodes))
