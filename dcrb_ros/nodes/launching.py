"""What the launch files share: arguments, and the nodes with their parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, SetEnvironmentVariable
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "dcrb_ros"
CONFIG = "a YAML file or a shipped configuration"
TIME_SCALE = "simulated over wall time, 0 as fast as possible; empty for the configuration's"
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


def arguments(described: Mapping[str, tuple[Any, str]], *, namespace: str) -> list[Any]:
    """Declare arguments by name, each with its default (none: it must be given) and description; and who may join."""
    everywhere = {
        "namespace": (namespace, "namespace of topics and nodes"),
        "detector": ("detector", "parameters of the fault detector: a YAML file or the shipped ones"),
        "discovery": (EnvironmentVariable(RANGE, default_value="LOCALHOST"), "who may join: LOCALHOST or SUBNET"),
    }
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in {**described, **everywhere}.items()
    ]
    return [*declared, SetEnvironmentVariable(RANGE, LaunchConfiguration("discovery"))]


def given(context: Any, name: str) -> str:
    """Return the value of an argument."""
    return str(LaunchConfiguration(name).perform(context))


def asked(context: Any, wanted: Mapping[str, tuple[str, Callable[[str], Any]]]) -> dict[str, Any]:
    """Return parameters by their keys from arguments by their names; one that is left empty leaves it to the configuration."""
    return {key: convert(value) for name, (key, convert) in wanted.items() if (value := given(context, name))}


def parameter_file(config: str) -> str:
    """Return a file of parameters: a user's, or a shipped one by its name."""
    shipped = Path(get_package_share_directory(PACKAGE)) / "config"
    return config if Path(config).is_file() else str(shipped / f"{config}.yaml")


def simulator(namespace: Any, config: str, own: Mapping[str, Any], *, scenario: str = "") -> Any:
    """Return the simulator of a bench, with parameters of its own."""
    extra = ["--scenario", scenario] if scenario else []
    return node("simulator", namespace, [parameter_file(config), dict(own)], extra)


def fault_detector(namespace: Any, parameters: str) -> Any:
    """Return the fault detector that listens to a bench, with its parameters as in a file."""
    return node("fault_detector", namespace, [parameter_file(parameters)])


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
