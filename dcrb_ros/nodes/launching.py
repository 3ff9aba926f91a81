"""Arguments and nodes of the launch files. Arguments are checked before a node is started: `launch` drops a missing parameter file."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, SetEnvironmentVariable, Shutdown
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from dcrb_ros.diagnosis.detector import check_parameters
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.nodes.ros import DISCOVERY, check_bench_discovery
from dcrb_ros.schema.numbers import duration_within
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.simulated_time import MAX_DURATION
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration, read_parameters, validated
from dcrb_ros.settings.sections import OF_ROS
from dcrb_ros.settings.shipped import find_configuration, shipped_folder
from dcrb_ros.simulation.scenario import read_scenario, read_scenario_file
from dcrb_ros.stream.late_scenario import refuse_late
from dcrb_ros.text.files import expanded_path, is_file
from dcrb_ros.text.writing import check_new_folder
from dcrb_ros.vehicle.file import read_parameters as parameters_of_vehicle
from dcrb_ros.vehicle.file import read_vehicle, vehicle_of
from dcrb_ros.vehicle.scenario import starting_parameters, vehicle_scenario

PACKAGE = "dcrb_ros"
TRUE, FALSE = ("true", "yes", "on", "1"), ("false", "no", "off", "0")
NAMESPACE = re.compile(r"/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)
OF_LAUNCH = ("ros_namespace", "ros_remaps", "ros_params", "global_params")
"""Names under which actions such as `PushRosNamespace` keep their values beside the arguments."""
EXIT_TIMEOUT = "15"
"""Wall time in which a node must end after SIGINT before `launch` sends SIGTERM, which changes nothing, and then SIGKILL [s]."""


@dataclass(frozen=True)
class Argument:
    """An argument of a launch file."""

    default: Any
    """Its text; None for a mandatory argument, "" for one that may be left out."""
    description: str
    kind: type = str
    choices: tuple[str, ...] = ()


CONFIG = Argument("healthy", "configuration: a YAML file or a shipped one")
TIME_SCALE = Argument("", "simulated over wall time, 0 as fast as possible; empty for the configuration's", float)
WAIT = Argument("", "longest wall time to wait for subscribers before the first block [s]; empty for the configuration's", float)
DURATION = Argument("", "simulated time after which the launch ends [s], for tests; empty for an endless run", float)
LISTENERS = "subscribers to the waveform to wait for; empty for the configuration's, at least one for each node that this file starts"
RUN = {
    "time_scale": "time_scale",
    "record": "recording.path",
    "clock": "publishing.clock",
    "listeners": "publishing.listeners",
    "wait": "publishing.wait",
}
"""Parameters of a simulator by the arguments of `run_arguments` that set them."""
Read = TypeVar("Read")


def common(namespace: str) -> dict[str, Argument]:
    """Return the arguments of every launch file, with the default namespace."""
    environment = EnvironmentVariable(DISCOVERY, default_value="LOCALHOST")
    ranges = ("LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")
    return {
        "namespace": Argument(namespace, "namespace of topics and nodes"),
        "detector": Argument("detector", "parameters of the fault detector: a YAML file or the shipped ones"),
        "discovery": Argument(environment, f"range of discovery: {', '.join(ranges)}", choices=ranges),
    }


def run_arguments(source: str, shown: str) -> dict[str, Argument]:
    """Return the arguments of a launch file that runs what ``source`` gives, and on request shows it, the ``shown``."""
    return {
        "record": Argument("", f"folder of a recording; empty for the {source}'s"),
        "duration": DURATION,
        "time_scale": TIME_SCALE,
        "clock": Argument("", f"whether to publish /clock: true or false; empty for the {source}'s", bool),
        "rerun": Argument("false", f"whether to show the {shown} in Rerun: true or false", bool),
        "listeners": Argument("", LISTENERS, int),
        "wait": WAIT,
        **common("dcrb"),
    }


def declarations(arguments: Mapping[str, Argument], start: Any) -> list[Any]:
    """Return actions that declare arguments, set the range of discovery, and start the nodes that ``start(context)`` returns."""
    declared = [
        DeclareLaunchArgument(name, default_value=argument.default, description=argument.description)
        for name, argument in arguments.items()
    ]
    return [*declared, SetEnvironmentVariable(DISCOVERY, LaunchConfiguration("discovery")), OpaqueFunction(function=start)]


def values_of(context: Any, arguments: Mapping[str, Argument]) -> dict[str, Any]:
    """Return the values of arguments by name; None for those left empty.

    Raises:
        Refusal: a value has the wrong type, or is not among the choices, or discovery is off.
    """
    check_bench_discovery(str(LaunchConfiguration("discovery").perform(context)))
    values = {name: _value(name, str(LaunchConfiguration(name).perform(context)), argument) for name, argument in arguments.items()}
    if not NAMESPACE.fullmatch(values["namespace"] or ""):
        raise Refusal(
            f"namespace:={values['namespace'] or ''} is not a ROS namespace: write words of letters, digits and _ between /, such as dcrb"
        )
    return values


def _value(name: str, text: str, argument: Argument) -> Any:
    if not text and argument.default:
        raise Refusal(f"{name}:= is empty: leave it out, or give the {argument.description}")
    if not text:
        return None
    if argument.kind is bool:
        return _truth(name, text)
    if argument.kind in (int, float):
        return _number(name, text, argument.kind)
    if argument.choices and text not in argument.choices:
        raise Refusal(f"{name}:={text} is not one of {', '.join(argument.choices)}{nearest(text, argument.choices)}")
    return text


def _truth(name: str, text: str) -> bool:
    if text.lower() not in (*TRUE, *FALSE):
        raise Refusal(f"{name}:={text} is neither true nor false: write {name}:=true or {name}:=false")
    return text.lower() in TRUE


def _number(name: str, text: str, kind: type) -> Any:
    try:
        number = kind(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        wanted, example = ("a whole number", "1") if kind is int else ("a finite number", "1.0")
        raise Refusal(f"{name}:={text} is not {wanted}: write one, such as {name}:={example}")
    return number


def run_options(given: Mapping[str, Any]) -> list[str]:
    """Return the options of a simulator: its scenario and its duration, if they are given.

    Raises:
        Refusal: the duration is out of range.
    """
    options = ["--scenario", given["scenario"]] if given["scenario"] else []
    if given["duration"] is not None:
        seconds = duration_within("duration:=", given["duration"], MAX_DURATION, "give the simulated time to run in seconds")
        options += ["--duration", repr(seconds)]
    return options


def suspicions(context: Any, arguments: Mapping[str, Argument]) -> list[Any]:
    """Return log actions for given arguments that no launch file takes but that resemble one of ``arguments``: `launch` ignores them."""
    given = (name for name in context.launch_configurations if name not in (*arguments, *OF_LAUNCH))
    return [LogInfo(msg=f"the argument '{name}' is ignored{near}") for name in given if (near := nearest(name, arguments))]


@contextmanager
def naming(argument: str, value: Any) -> Iterator[None]:
    """Name the argument in a refusal."""
    try:
        yield
    except Refusal as refusal:
        raise Refusal(f"{argument}:={value}: {refusal}") from None


def simulator_parameters(argument: str, given: Mapping[str, Any], keys: Mapping[str, str], scenario: str | None = None) -> dict[str, Any]:
    """Return the parameters of a configuration and of other arguments by their dotted keys, if they are valid, with a scenario as well.

    Args:
        argument: the name of the argument that gives the configuration, a path or a shipped name.
        given: values by argument, None for those left empty.
        keys: parameters by the arguments that set them.
        scenario: a path or a shipped name.

    Raises:
        Refusal: there is no such file, or it is invalid; the sentence names the argument.
    """
    with naming(argument, given[argument]):
        configuration: Configuration = load_configuration(given[argument])
    configuration = _with_arguments(configuration, partial(load_configuration, configuration), given, keys)
    if scenario is not None:
        with naming("scenario", scenario):
            read_scenario(Path(scenario), configuration)
            _check_effect(read_scenario_file(Path(scenario)), given)
    _check_recording(configuration, argument, given)
    return {**_parameters(find_configuration(given[argument]), "simulator"), **_set_by(given, keys, configuration)}


def vehicle_parameters(argument: str, given: Mapping[str, Any], keys: Mapping[str, str], scenario: str | None = None) -> dict[str, Any]:
    """Return the parameters of ROS of a vehicle, and those that other arguments set, if all are valid; see `simulator_parameters`."""
    with naming(argument, given[argument]):
        vehicle = read_vehicle(given[argument])
    vehicle = _with_arguments(vehicle, partial(read_vehicle, given[argument]), given, keys)
    if scenario is not None:
        with naming("scenario", scenario):
            tree = read_scenario_file(Path(scenario))
            start = starting_parameters(tree, parameters_of_vehicle(given[argument]), scenario)
            vehicle_scenario(tree, vehicle_of(start, given[argument]), scenario)
            _check_effect(tree, given)
    _check_recording(vehicle.boxes[0].configuration, argument, given)
    of_ros = {key: value for key, value in parameters_of_vehicle(given[argument], of_ros=True).items() if _is_of_ros(key) and value != {}}
    return {**of_ros, **_set_by(given, keys, vehicle.boxes[0].configuration)}


def _check_effect(tree: Any, given: Mapping[str, Any]) -> None:
    """Refuse a scenario that changes nothing in a run of the given duration, if there is one."""
    refuse_late(tree, given.get("duration"), "the scenario", "increase duration:= or leave out scenario:=")


def _with_arguments(bare: Read, read: Callable[[Mapping[str, Any]], Read], given: Mapping[str, Any], keys: Mapping[str, str]) -> Read:
    """Return what ``read`` makes of the parameters that arguments set, ``bare`` without one; a refusal names the argument."""
    content, changes = bare, dict[str, Any]()
    for name, key in keys.items():
        if given[name] is not None:
            changes[key] = given[name]
            with naming(name, given[name]):
                content = read(changes)
    return content


def _check_recording(configuration: Configuration, argument: str, given: Mapping[str, Any]) -> None:
    """Check that the folder of the recording can be created, if there is to be one."""
    recorded = given.get("record")
    if configuration.recording.path:
        with naming("record" if recorded else argument, recorded or given[argument]):
            check_new_folder(expanded_path(configuration.recording.path))


def _parameters(path: Path, name: str) -> dict[str, Any]:
    """Return the parameters of a valid file for a node of the bench by their dotted keys.

    The path itself is no parameter file for every node: ROS reads no plain groups, and a section counts in its own namespace only.
    """
    return {key: value for key, value in read_parameters(path, name, of_ros=True).items() if value != {}}


def _set_by(given: Mapping[str, Any], keys: Mapping[str, str], configuration: Configuration) -> dict[str, Any]:
    """Return the parameters that arguments set on top of a configuration, without those of empty arguments.

    Unless an argument sets it, the number of subscribers to wait for is at least that of the nodes that are started.
    """
    listeners = max(configuration.publishing.listeners, 2 if given.get("rerun") else 1)
    return {"publishing.listeners": listeners, **{key: given[name] for name, key in keys.items() if given[name] is not None}}


def _is_of_ros(key: str) -> bool:
    """Return whether a dotted key is a parameter that every node of ROS has."""
    return key.partition(".")[0] in OF_ROS


def detector_parameters(detector: str) -> dict[str, Any]:
    """Return the parameters of the fault detector from a file given by its path, or as ``detector`` for the shipped one.

    Raises:
        Refusal: there is no such file, or it is invalid; the sentence names the argument.
    """
    path = Path(detector)
    with naming("detector", detector):
        if not is_file(path):
            if detector != "detector":
                remedy = f"give a YAML file, or detector for the shipped parameters{nearest(detector, ['detector'])}"
                raise Refusal(f"there is no such file: {remedy}")
            path = shipped_folder() / "detector.yaml"
        check_parameters(validated(read_parameters(path, "fault_detector"), DetectorParameters, str(path)))
        return _parameters(path, "fault_detector")


def detector_node(namespace: str, detector: str, *, of_vehicle: bool = False) -> Any:
    """Return the fault detector, or the one that compares the boxes of a vehicle, with the parameters of `detector_parameters`."""
    parameters = detector_parameters(detector)
    if not of_vehicle:
        return node("fault_detector", namespace, parameters)
    below = {key if _is_of_ros(key) else f"boxes.{key}": value for key, value in parameters.items()}
    return node("vehicle_detector", namespace, below)


def _ending(name: str) -> Callable[[Any, Any], Any]:
    """Return what follows the end of a node: the launch ends, with status 1 if the node has failed."""

    def end(event: Any, context: Any) -> Any:
        # Once the launch ends, `launch` itself may kill a node that takes too long; a node that fails has a positive status.
        if event.returncode > 0 or (event.returncode != 0 and not context.is_shutdown):
            raise Refusal(f"{name} has failed with status {event.returncode}; its last lines above say why")
        return Shutdown(reason=f"{name} has ended")

    return end


def node(
    executable: str, namespace: str, parameters: Mapping[str, Any] | None = None, *, extra: Sequence[str] = (), required: bool = True
) -> Any:
    """Return a node of the package; the end of a ``required`` one ends the launch, and its failure makes the launch fail."""
    # Without its type, launch would take the text 2026 for a number.
    given = {key: ParameterValue(value, value_type=str) if isinstance(value, str) else value for key, value in (parameters or {}).items()}
    ending = {"on_exit": _ending(f"{executable} in {namespace}")} if required else {}
    return Node(
        package=PACKAGE,
        executable=executable,
        namespace=namespace,
        parameters=[given] if given else [],
        arguments=list(extra),
        output="screen",
        sigterm_timeout=EXIT_TIMEOUT,
        **ending,
    )
