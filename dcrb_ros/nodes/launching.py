"""What the launch files share: arguments, and the nodes with their parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "dcrb_ros"
CONFIG = "a YAML file or a shipped configuration"
TIME_SCALE = "simulated over wall time, 0 as fast as possible"


def arguments(described: Mapping[str, tuple[str | None, str]], *, namespace: str) -> list[Any]:
    """Declare arguments by name, each with its default (none: it must be given) and description; and who may join."""
    everywhere = {
        "namespace": (namespace, "namespace of topics and nodes"),
        "discovery": ("LOCALHOST", "who may join: LOCALHOST or SUBNET"),
    }
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in {**described, **everywhere}.items()
    ]
    return [*declared, SetEnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", LaunchConfiguration("discovery"))]


def given(context: Any, name: str) -> str:
    """Return the value of an argument."""
    return str(LaunchConfiguration(name).perform(context))


def parameter_file(config: str) -> str:
    """Return a file of parameters: a user's, or a shipped one by its name."""
    shipped = Path(get_package_share_directory(PACKAGE)) / "config"
    return config if Path(config).is_file() else str(shipped / f"{config}.yaml")


def simulator(namespace: Any, config: str, own: Mapping[str, Any], *, scenario: str = "") -> Any:
    """Return the simulator of a bench, with parameters of its own."""
    extra = ["--scenario", scenario] if scenario else []
    return node("simulator", namespace, [parameter_file(config), dict(own)], extra)


def fault_detector(namespace: Any) -> Any:
    """Return the fault detector that listens to a bench."""
    return node("fault_detector", namespace, [parameter_file("detector")])


def node(executable: str, namespace: Any, parameters: Sequence[Any] = (), extra: Sequence[str] = ()) -> Any:
    """Return a node of the package."""
    return Node(
        package=PACKAGE,
        executable=executable,
        namespace=namespace,
        parameters=list(parameters),
        arguments=list(extra),
        output="screen",
    )
