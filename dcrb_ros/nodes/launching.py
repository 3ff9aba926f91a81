"""Arguments and nodes of the launch files."""

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
    """Return actions that declare arguments, given by name with default (none for a mandatory one) and description, and set discovery."""
    common = {
        "namespace": (namespace, "namespace of topics and nodes"),
        "detector": ("detector", "parameters of the fault detector: a YAML file or the shipped ones"),
        "discovery": (EnvironmentVariable(RANGE, default_value="LOCALHOST"), "range of discovery: LOCALHOST or SUBNET"),
    }
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in {**described, **common}.items()
    ]
    return [*declared, SetEnvironmentVariable(RANGE, LaunchConfiguration("discovery"))]


def value_of(context: Any, name: str) -> str:
    """Return the value of an argument."""
    return str(LaunchConfiguration(name).perform(context))


def parameters_from(context: Any, arguments: Mapping[str, tuple[str, Callable[[str], Any]]]) -> dict[str, Any]:
    """Return parameters from arguments, given by name with key and type of the parameter; empty arguments are left out."""
    return {key: convert(value) for name, (key, convert) in arguments.items() if (value := value_of(context, name))}


def parameter_file(config: str) -> str:
    """Return the path of a parameter file, given by its path or by the name of a shipped one."""
    shipped = Path(get_package_share_directory(PACKAGE)) / "config"
    return config if Path(config).is_file() else str(shipped / f"{config}.yaml")


def simulator(namespace: Any, config: str, parameters: Mapping[str, Any], *, scenario: str = "") -> Any:
    """Return the simulator of a bench; ``parameters`` override those of the file ``config``."""
    extra = ["--scenario", scenario] if scenario else []
    return node("simulator", namespace, [parameter_file(config), dict(parameters)], extra)


def fault_detector(namespace: Any, parameters: str) -> Any:
    """Return the fault detector of a bench, with the parameters in a file."""
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
