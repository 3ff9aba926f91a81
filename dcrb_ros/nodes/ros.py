"""What all nodes share: checks before start, parameters from the schema, spinning until told to stop."""

from __future__ import annotations

import argparse
import importlib.util
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, TypeVar

from dcrb_ros.messages.topics import NAMESPACE
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.runtime.signals import TERMINATION
from dcrb_ros.schema.fields import Group
from dcrb_ros.settings.files import ParameterField, flatten, parameter_fields, validated

if TYPE_CHECKING:
    from rclpy.node import Node

    from dcrb_ros.nodes.parameters import ObedientNode

Model = TypeVar("Model", bound=Group)
DISCOVERY = "ROS_AUTOMATIC_DISCOVERY_RANGE"
"""The variable of ROS that says who may join: LOCALHOST, SUBNET or OFF."""
PAUSE = 0.01
"""Wall time after a callback's failure, so that one without end does not take a processor [s]."""


def stay_on_this_machine() -> None:
    """Let nobody on other machines discover the bench, unless the user's environment says otherwise."""
    os.environ.setdefault(DISCOVERY, "LOCALHOST")


def check_ros() -> None:
    """Refuse to start where ROS 2 or the middleware asked for is absent.

    The wheels end the process without a word of ours when the middleware is missing, so it is looked for beforehand.
    """
    if importlib.util.find_spec("rclpy") is None:
        raise Refusal(
            "the nodes need ROS 2 Jazzy, and rclpy is not installed: source a ROS installation, or pip install 'dcrb_ros[ros]' "
            "on x86-64 Linux; everything but the nodes works without"
        )
    wanted = os.environ.get("RMW_IMPLEMENTATION", "")
    found = middlewares()
    if wanted and found and wanted not in found:
        raise Refusal(f"RMW_IMPLEMENTATION = {wanted} is not installed here: unset it or choose from {', '.join(found)}")


def middlewares() -> list[str]:
    """Return the ROS middlewares whose library can be found."""
    folders = [Path(p) for p in os.environ.get("LD_LIBRARY_PATH", "").split(":") if p]
    folders += [Path(prefix) / "lib" for prefix in [*os.environ.get("AMENT_PREFIX_PATH", "").split(":"), sys.prefix] if prefix]
    names = {library.stem.removeprefix("lib") for folder in folders for library in folder.glob("librmw_*_cpp.so")}
    return sorted(name for name in names if "shared" not in name and "common" not in name)


def own_arguments(parser: argparse.ArgumentParser, arguments: Sequence[str]) -> argparse.Namespace:
    """Return what a node's own options say; those of ROS are left out."""
    check_ros()
    from rclpy.utilities import remove_ros_args

    return parser.parse_args(remove_ros_args([parser.prog, *arguments])[1:])


@contextmanager
def running(name: str, arguments: Sequence[str]) -> Iterator[tuple[ObedientNode, threading.Event]]:
    """Yield a node, and what is set once it is told to stop."""
    check_ros()
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import try_shutdown

    told = stop_on_signals()
    stay_on_this_machine()
    rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    node = create_node(name)
    try:
        yield node, told
    finally:
        node.destroy_node()
        try_shutdown()


def create_node(name: str) -> ObedientNode:
    """Return a node in the default namespace that has taken whatever parameters it was given."""
    from dcrb_ros.nodes.parameters import ObedientNode

    return ObedientNode(name, namespace=NAMESPACE, automatically_declare_parameters_from_overrides=True)


def declare(
    node: Node, model: type[Model], *, run_time: Sequence[str] = (), begun: Callable[[Model], Model] = lambda given: given
) -> Model:
    """Declare every parameter of a model with type, range and description; return the model with the node's overrides.

    ``begun`` changes what the node was given, before it is declared.

    Raises:
        Refusal: an override that is unknown, mistyped or out of range.
    """
    from dcrb_ros.nodes.parameters import OWN

    found: dict[str, Any] = node.get_parameters_by_prefix("")
    given = {key: parameter.value for key, parameter in found.items() if key not in OWN}
    checked = begun(validated(given, model, "parameters"))
    values = flatten(checked.model_dump())
    for field in parameter_fields(model):
        if node.has_parameter(field.key):
            node.undeclare_parameter(field.key)
        node.declare_parameter(field.key, values[field.key], _descriptor(field, field.key not in run_time), ignore_override=True)
    return checked


def _descriptor(field: ParameterField, read_only: bool) -> Any:
    from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor

    unit = f" [{field.unit}]" if field.unit != "-" else ""
    about = ParameterDescriptor(name=field.key, description=f"{field.description}{unit}", read_only=read_only)
    if field.low is not None and field.high is not None:
        if field.kind is int:
            about.integer_range = [IntegerRange(from_value=int(field.low), to_value=int(field.high), step=1)]
        else:
            about.floating_point_range = [FloatingPointRange(from_value=float(field.low), to_value=float(field.high), step=0.0)]
    elif field.choices:
        about.additional_constraints = "one of " + ", ".join(field.choices)
    return about


def changed(model: Model, changes: Mapping[str, Any]) -> Model:
    """Return a model with some dotted keys changed, checked as a whole."""
    return validated({**flatten(model.model_dump()), **changes}, type(model), "parameters")


def spin(node: Node, ended: Callable[[], bool], stop: threading.Event) -> None:
    """Serve callbacks until told to stop or ``ended`` says so; a callback that fails is logged, and the node serves on.

    The environment variable DCRB_DEBUG=1 lets the failure through.
    """
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

    executor = SingleThreadedExecutor()
    executor.add_node(node)
    failures = 0
    try:
        while not (stop.is_set() or ended()):
            try:
                executor.spin_once(timeout_sec=0.1)
            except ExternalShutdownException:
                raise
            except Exception as error:  # whatever one message leads to must not end the node
                if os.environ.get("DCRB_DEBUG") == "1":
                    raise
                failures += 1
                _log_failure(node, error, failures)
                stop.wait(PAUSE)
    except ExternalShutdownException:
        stop.set()
    finally:
        executor.remove_node(node)


def _log_failure(node: Node, error: Exception, count: int) -> None:
    """Log the first failure of a callback, the second, the fourth and so on."""
    if count & (count - 1) == 0:
        node.get_logger().error(f"a callback failed ({count} so far, DCRB_DEBUG=1 shows where): {type(error).__name__}: {error}")


def stop_on_signals() -> threading.Event:
    """Return an event that SIGINT, SIGTERM and SIGHUP set, however often they come.

    A hangup that is ignored stays so (``nohup``); what was held back by `signals_held` comes now.
    """
    stop = threading.Event()

    def told(number: int, frame: FrameType | None) -> None:
        stop.set()

    for number in TERMINATION:
        if signal.getsignal(number) is not signal.SIG_IGN or number != signal.SIGHUP:
            signal.signal(number, told)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, TERMINATION)
    return stop


@contextmanager
def signals_held() -> Iterator[None]:
    """Let processes started meanwhile keep back what would end them until `stop_on_signals`, so that none ends amid its imports."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, TERMINATION)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
