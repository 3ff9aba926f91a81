"""Running a node: checks before rclpy is imported, signals, the spin loop."""

from __future__ import annotations

import argparse
import ast
import importlib.util
import os
import re
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from dcrb_ros.messages.topics import NAMESPACE
from dcrb_ros.recordings.splitting import RecordingFailed
from dcrb_ros.runtime.signals import accept_termination, handle_termination, interrupt, restore_ignored_signals
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import is_file

if TYPE_CHECKING:
    from rclpy.node import Node

    from dcrb_ros.nodes.base import BenchNode

DISCOVERY = "ROS_AUTOMATIC_DISCOVERY_RANGE"
"""Environment variable of ROS for the range of discovery: LOCALHOST, SUBNET or OFF."""
DOMAIN, HIGHEST_DOMAIN = "ROS_DOMAIN_ID", 232
"""Environment variable of ROS for the domain, and the highest domain that has ports of its own."""
SOURCE_LINE = re.compile(r", at /\S+:\d+")
"""Place in the source of ROS, in its error messages."""
FAILURE_PAUSE = 0.01
"""Wall time after the failure of a callback [s], so that an endless series of failures does not occupy a core."""


def limit_discovery() -> None:
    """Limit discovery to this machine unless the user's environment sets another range."""
    os.environ.setdefault(DISCOVERY, "LOCALHOST")


def check_domain() -> None:
    """Check the ROS domain of the environment: rclpy names no remedy, and takes -1 for 0.

    Raises:
        Refusal: it is no number, or too high for the ports of the machine.
    """
    text, number = os.environ.get(DOMAIN, ""), -1
    for base in (8, 0):  # as in C, 010 is octal
        with suppress(ValueError):
            number = int(text, base)
    if text and not 0 <= number <= HIGHEST_DOMAIN:
        raise Refusal(f"{DOMAIN} = {text} is not a whole number within 0 .. {HIGHEST_DOMAIN}: unset it, or give such a number")


def check_bench_discovery(discovery: str | None = None) -> None:
    """Check that the nodes of a bench can find each other, with a range of discovery, by default that of the environment.

    Raises:
        Refusal: discovery is off, or the domain is impossible.
    """
    check_domain()
    if (discovery or os.environ.get(DISCOVERY)) == "OFF":
        raise Refusal(f"{DISCOVERY} = OFF hides the nodes of the bench from each other: unset it, or set LOCALHOST or SUBNET")


def installed(package: str) -> bool:
    """Return whether a Python package is installed."""
    return importlib.util.find_spec(package) is not None


def check_ros() -> None:
    """Check that ROS 2 and the requested middleware are installed; to be called before rclpy is imported.

    Without the middleware, the import of rclpy from wheels would end the process.

    Raises:
        Refusal: one of them is missing.
    """
    if not installed("rclpy"):
        raise Refusal(
            "the nodes need ROS 2 Jazzy, and rclpy is not installed: source a ROS installation, or run pip install '.[ros]' in a checkout "
            "of dcrb_ros on x86-64 Linux; everything but the nodes works without it"
        )
    wanted = os.environ.get("RMW_IMPLEMENTATION", "")
    available = middlewares()
    if wanted and available and wanted not in available:
        raise Refusal(f"RMW_IMPLEMENTATION = {wanted} is not installed here: unset it or choose from {', '.join(available)}")


def middlewares() -> list[str]:
    """Return the ROS middlewares whose library is found."""
    folders = [Path(p) for p in os.environ.get("LD_LIBRARY_PATH", "").split(":") if p]
    folders += [Path(prefix) / "lib" for prefix in [*os.environ.get("AMENT_PREFIX_PATH", "").split(":"), sys.prefix] if prefix]
    names = {library.stem.removeprefix("lib") for folder in folders for library in folder.glob("librmw_*_cpp.so")}
    return sorted(name for name in names if "shared" not in name and "common" not in name)


def own_arguments(parser: argparse.ArgumentParser, arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options of a node without the arguments of ROS.

    Raises:
        Refusal: ROS does not understand one of its arguments.
    """
    from rclpy.utilities import remove_ros_args

    with _understood(arguments):
        words = remove_ros_args([parser.prog, *arguments])[1:]
    return parser.parse_args(words)


def run_node(create: Callable[[], BenchNode], arguments: Sequence[str]) -> int:
    """Create a node and run it until its work ends or a termination signal arrives; return the exit status.

    Raises:
        Refusal: the node's parameters, its input or the ROS domain are invalid.
    """
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import try_shutdown

    check_domain()
    limit_discovery()
    try:
        interrupt()  # building the model and compiling its kernels may take minutes
        with _understood(arguments):
            rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
        return _run(create())
    except KeyboardInterrupt:  # before the node was started
        return 0
    finally:
        try_shutdown()


def _run(node: BenchNode) -> int:
    """Load and start a node, and serve it until its work ends or a termination signal arrives; return the exit status."""
    try:
        try:
            node.load()
        finally:  # from here on, a signal interrupts nothing
            stop = stop_on_signals()
        if not stop.is_set():
            node.start()
            spin(node, lambda: node.ended, stop)
    finally:
        node.close()
    status = _status(node)
    node.destroy_node()
    return status


@contextmanager
def _understood(arguments: Sequence[str]) -> Iterator[None]:
    """Refuse arguments that ROS does not understand, and files of parameters that do not exist or are invalid."""
    from rclpy.impl.implementation_singleton import rclpy_implementation

    for option, path in pairwise(arguments):
        if option == "--params-file" and not is_file(Path(path)):
            raise Refusal(f"--params-file {path}: there is no such file: give a ROS parameter file; dcrb config show prints one")
    try:
        yield
    except rclpy_implementation.UnknownROSArgsError as error:
        words = " ".join(ast.literal_eval(str(error)))
        raise Refusal(f"'{words}' follows --ros-args but is no argument of ROS: write options of the node before --ros-args") from None
    except rclpy_implementation.RCLInvalidROSArgsError as error:
        raise Refusal(SOURCE_LINE.sub("", str(error))) from None


def _status(node: BenchNode) -> int:
    if isinstance(node.failure, Refusal):
        raise node.failure
    if isinstance(node.failure, RecordingFailed):
        return 1  # logged when the recording ended
    if node.failure is not None:
        node.get_logger().fatal(f"the {node.purpose} stopped: {node.failure}")
        return 1
    return 0


def spin(node: Node, ended: Callable[[], bool], stop: threading.Event) -> None:
    """Serve callbacks until ``stop`` is set or ``ended`` returns true; a callback that fails is logged, and the node continues.

    With the environment variable DCRB_DEBUG=1 the failure is raised.
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
            except Exception as error:  # no message may end the node
                if os.environ.get("DCRB_DEBUG") == "1":
                    raise
                failures += 1
                _log_failure(node, error, failures)
                stop.wait(FAILURE_PAUSE)
    except ExternalShutdownException:
        stop.set()
    finally:
        executor.remove_node(node)


def _log_failure(node: Node, error: Exception, count: int) -> None:
    """Log the first failure of a callback, the second, the fourth and so on."""
    if count & (count - 1) == 0:
        node.get_logger().error(f"a callback failed ({count} so far, DCRB_DEBUG=1 shows where): {type(error).__name__}: {error}")


@contextmanager
def node_in(name: str, domain: int | None = None) -> Iterator[tuple[Node, Callable[[float], None]]]:
    """Yield a node in a ROS domain, by default that of the environment, and a function that serves its callbacks for a time [s]."""
    import rclpy
    from rclpy.context import Context
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.utilities import try_shutdown

    limit_discovery()
    context = Context()
    rclpy.init(context=context, domain_id=domain, args=[])
    node = rclpy.create_node(name, namespace=NAMESPACE, context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        yield node, lambda seconds: executor.spin_once(timeout_sec=seconds)
    finally:
        executor.shutdown()
        node.destroy_node()
        try_shutdown(context=context)


def stop_on_signals() -> threading.Event:
    """Return an event that is set by SIGINT, SIGTERM and SIGHUP, however often they arrive.

    An ignored SIGHUP stays ignored (``nohup``). Signals that the parent process blocked are delivered now.
    """
    stop = threading.Event()

    def handle(number: int, frame: FrameType | None) -> None:
        stop.set()

    restore_ignored_signals()
    handle_termination(handle)
    accept_termination()
    return stop
