"""Replayer and the detector of a bearing or a vehicle: ros2 launch dcrb_ros replay.launch.py bag:=/tmp/bag."""

from __future__ import annotations

from typing import Any

from dcrb_ros.nodes import launching
from dcrb_ros.recordings.replay import Replay, ReplayParameters
from dcrb_ros.recordings.vehicle import VehicleRecording
from dcrb_ros.settings.files import validated
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "bag": launching.Argument(None, "a recording: its folder or an .mcap file"),
    "rate": launching.Argument("1.0", "recorded over wall time, 0.0 as fast as possible", float),
    "loop": launching.Argument("false", "whether to start again at the end: true or false", bool),
    "offset": launching.Argument("0.0", "recorded time to skip at the beginning [s]", float),
    "clock": launching.Argument("false", "whether to publish /clock: true or false", bool),
    "topics": launching.Argument("", "topics to publish, such as 'outer_ring/vibration, diagnosis'; empty for those of the simulator"),
    "listeners": launching.Argument("1", "subscribers to wait for before the first block", int),
    "wait": launching.Argument("30.0", "longest wall time to wait for them [s]", float),
    **launching.common("dcrb"),
}


def nodes(context: LaunchContext) -> list[Any]:
    """Return the replayer and the detector."""
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
        launching.detector_node(namespace, given["detector"], of_vehicle=isinstance(replay.recording, VehicleRecording)),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the replay."""
    return LaunchDescription(launching.declarations(ARGUMENTS, nodes))
