"""Four axle boxes at once, each with a bearing, a seed and a namespace of its own: ros2 launch dcrb_ros axle_boxes.launch.py.

The third box has what `fault` says. One core carries one box in real time, so four cores are wanted, or a time scale below one.
"""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchContext, LaunchDescription

BOXES = 4
FAULTY = 3


def nodes(context: LaunchContext) -> list[Node]:
    """Return simulator and fault detector of every box."""
    shipped = Path(get_package_share_directory("dcrb_ros")) / "config"
    wagon = LaunchConfiguration("namespace").perform(context)
    found = []
    for box in range(1, BOXES + 1):
        namespace = f"{wagon}/box{box}"
        name = LaunchConfiguration("fault" if box == FAULTY else "config").perform(context)
        parameters = name if Path(name).is_file() else str(shipped / f"{name}.yaml")
        own = {
            "simulation.seed": box,
            "publishing.frame": f"{namespace}/outer_ring",
            # There is one /clock in a graph; the boxes start together and keep the same time scale.
            "publishing.clock": box == 1 and LaunchConfiguration("clock").perform(context) == "true",
            "time_scale": float(LaunchConfiguration("time_scale").perform(context)),
        }
        detector = str(shipped / "detector.yaml")
        found += [
            Node(package="dcrb_ros", executable="simulator", namespace=namespace, parameters=[parameters, own], output="screen"),
            Node(package="dcrb_ros", executable="fault_detector", namespace=namespace, parameters=[detector], output="screen"),
        ]
    return found


def generate_launch_description() -> LaunchDescription:
    """Describe the axle boxes of a wagon."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("config", default_value="healthy", description="bench of the sound boxes: a YAML file or a shipped one"),
            DeclareLaunchArgument("fault", default_value="outer_ring_defect", description=f"bench of box {FAULTY}"),
            DeclareLaunchArgument("time_scale", default_value="1.0", description="simulated over wall time, 0 as fast as possible"),
            DeclareLaunchArgument("clock", default_value="false", description="whether box 1 publishes /clock: true or false"),
            DeclareLaunchArgument("namespace", default_value="wagon", description="namespace above box1 to box4"),
            DeclareLaunchArgument("discovery", default_value="LOCALHOST", description="who may join: LOCALHOST or SUBNET"),
            SetEnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", LaunchConfiguration("discovery")),
            OpaqueFunction(function=nodes),
        ]
    )
