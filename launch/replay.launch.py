"""Replayer and fault detector: ros2 launch dcrb_ros replay.launch.py bag:=/tmp/bag."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe the replay."""
    namespace = LaunchConfiguration("namespace")
    shipped = Path(get_package_share_directory("dcrb_ros")) / "config"
    kinds = {"bag": str, "rate": float, "loop": bool, "offset": float, "clock": bool}
    parameters = {name: ParameterValue(LaunchConfiguration(name), value_type=kind) for name, kind in kinds.items()}
    return LaunchDescription(
        [
            DeclareLaunchArgument("bag", description="a recording: its folder or an .mcap file"),
            DeclareLaunchArgument("rate", default_value="1.0", description="recorded over wall time, 0.0 as fast as possible"),
            DeclareLaunchArgument("loop", default_value="false", description="begin again at the end"),
            DeclareLaunchArgument("offset", default_value="0.0", description="recorded time to skip at the beginning [s]"),
            DeclareLaunchArgument("clock", default_value="false", description="publish /clock"),
            DeclareLaunchArgument("namespace", default_value="dcrb", description="namespace of topics and nodes"),
            DeclareLaunchArgument("discovery", default_value="LOCALHOST", description="who may join: LOCALHOST or SUBNET"),
            SetEnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", LaunchConfiguration("discovery")),
            Node(package="dcrb_ros", executable="replayer", namespace=namespace, parameters=[parameters], output="screen"),
            Node(
                package="dcrb_ros",
                executable="fault_detector",
                namespace=namespace,
                parameters=[str(shipped / "detector.yaml")],
                output="screen",
            ),
        ]
    )
