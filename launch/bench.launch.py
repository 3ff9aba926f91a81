"""Simulator and fault detector: ros2 launch dcrb_ros bench.launch.py config:=outer_ring_defect record:=/tmp/bag."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchContext, LaunchDescription


def nodes(context: LaunchContext) -> list[Node]:
    """Return both nodes; `config` is a file or the name of a shipped configuration."""
    shipped = Path(get_package_share_directory("dcrb_ros")) / "config"
    config = LaunchConfiguration("config").perform(context)
    parameters = config if Path(config).is_file() else str(shipped / f"{config}.yaml")
    namespace = LaunchConfiguration("namespace").perform(context)
    scenario = LaunchConfiguration("scenario").perform(context)
    own = {
        "time_scale": float(LaunchConfiguration("time_scale").perform(context)),
        "recording.path": LaunchConfiguration("record").perform(context),
        "publishing.clock": LaunchConfiguration("clock").perform(context) == "true",
    }
    shown = LaunchConfiguration("rerun").perform(context) == "true"
    return [
        *([Node(package="dcrb_ros", executable="viewer", namespace=namespace, output="screen")] if shown else []),
        Node(
            package="dcrb_ros",
            executable="simulator",
            namespace=namespace,
            parameters=[parameters, own],
            arguments=["--scenario", scenario] if scenario else [],
            output="screen",
        ),
        Node(
            package="dcrb_ros",
            executable="fault_detector",
            namespace=namespace,
            parameters=[str(shipped / "detector.yaml")],
            output="screen",
        ),
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the bench."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("config", default_value="healthy", description="a YAML file or a shipped configuration"),
            DeclareLaunchArgument("scenario", default_value="", description="a scenario file or a shipped one, such as growing_spall"),
            DeclareLaunchArgument("record", default_value="", description="folder of a recording, empty for none"),
            DeclareLaunchArgument("time_scale", default_value="1.0", description="simulated over wall time, 0 as fast as possible"),
            DeclareLaunchArgument("clock", default_value="false", description="whether to publish /clock: true or false"),
            DeclareLaunchArgument("rerun", default_value="false", description="whether to show it in Rerun: true or false"),
            DeclareLaunchArgument("namespace", default_value="dcrb", description="namespace of topics and nodes"),
            DeclareLaunchArgument("discovery", default_value="LOCALHOST", description="who may join: LOCALHOST or SUBNET"),
            SetEnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", LaunchConfiguration("discovery")),
            OpaqueFunction(function=nodes),
        ]
    )
