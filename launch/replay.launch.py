"""Replayer and fault detector: ros2 launch dcrb_ros replay.launch.py bag:=/tmp/bag."""

from __future__ import annotations

from launch.actions import OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from dcrb_ros.nodes.launching import arguments, fault_detector, node, value_of
from launch import LaunchContext, LaunchDescription


def detector_node(context: LaunchContext) -> list[Node]:
    """Return the fault detector."""
    return [fault_detector(value_of(context, "namespace"), value_of(context, "detector"))]


def generate_launch_description() -> LaunchDescription:
    """Describe the replay."""
    namespace = LaunchConfiguration("namespace")
    kinds = {"bag": str, "rate": float, "loop": bool, "offset": float, "clock": bool}
    parameters = {name: ParameterValue(LaunchConfiguration(name), value_type=kind) for name, kind in kinds.items()}
    described = {
        "bag": (None, "a recording: its folder or an .mcap file"),
        "rate": ("1.0", "recorded over wall time, 0.0 as fast as possible"),
        "loop": ("false", "start again at the end"),
        "offset": ("0.0", "recorded time to skip at the beginning [s]"),
        "clock": ("false", "publish /clock"),
    }
    replayer, detector = node("replayer", namespace, [parameters]), OpaqueFunction(function=detector_node)
    return LaunchDescription([*arguments(described, namespace="dcrb"), replayer, detector])
