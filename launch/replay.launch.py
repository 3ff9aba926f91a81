"""Replayer and fault detector: ros2 launch dcrb_ros replay.launch.py bag:=/tmp/bag."""

from __future__ import annotations

from typing import Any

from dcrb_ros.nodes import launching
from dcrb_ros.recordings.replay import Replay, ReplayParameters
from dcrb_ros.settings.files import validated
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "bag": launching.Argument(None, "a recording: its folder or an .mcap file"),
    "rate": launching.Argument("1.0", "recorded over wall time, 0.0 as fast as possible", float),
    "loop": launching.Argument("false", "whether to start again at the end: true or false", bool),
    "offset": launching.Argument("0.0", "recorded time to skip at the beginning [s]", float),
    "clock": launching.Argument("false", "whether to publish /clock: true or false", bool),
    "topics": launching.Argument("", "topics to publish, such as 'outer_ring/vibration, diagnosis'; empty for those of the simulator"),
    "listeners": launching.Argument("1", launching.LISTENERS, int),
    "wait": launching.WAIT,
    **launching.common("dcrb"),
}


def nodes(context: LaunchContext) -> list[Any]:
    """Return the replayer and the fault detector."""
    given = launching.values_of(context, ARGUMENTS)
    namespace = given["namespace"]
    parameters = {name: given[name] for name in ReplayParameters.model_fields if given[name] is not None}
    replayed = validated(parameters, ReplayParameters, "replay")
    with launching.naming("bag", replayed.bag):
        replay = Replay(replayed)
    with launching.naming("offset", given["offset"]) if given["offset"] else launching.naming("bag", replayed.bag):
        replay.check()
    return [
        *launching.suspicions(context, ARGUMENTS),
        launching.node("replayer", namespace, parameters),
        launching.node("fault_detector", namespace, launching.detector_parameters(given["detector"])),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the replay."""
    return LaunchDescription(launching.declarations(ARGUMENTS, nodes))
