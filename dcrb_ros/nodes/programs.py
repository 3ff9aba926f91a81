"""The nodes as programs, for `ros2 run`, launch files and `python -m dcrb_ros.nodes`.

Importing a node takes up to a second, in which a termination signal ends the program at once; this module itself imports next to nothing
before the signals are handled. Until the node starts its work, a signal interrupts it; then one ends it in order (`dcrb_ros.nodes.ros`).
"""

from __future__ import annotations

import sys

from dcrb_ros.runtime.signals import accept_termination, end_at_once, leave_at_once, restore_ignored_signals

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, NoReturn

NAMES = ("simulator", "vehicle_simulator", "replayer", "fault_detector", "vehicle_detector", "hot_box_detector", "viewer")
WITH_PARENT = "--with-parent"
"""Option of `python -m dcrb_ros.nodes` that ends the node with its parent process."""


def main(name: str, arguments: list[str], *, with_parent: bool = False) -> NoReturn:
    """Run a node as a program, and exit.

    ``with_parent`` ends it with the process that holds the other end of its standard input, and that sends its parameters first.
    """
    restore_ignored_signals()
    end_at_once(0)
    accept_termination()
    from dcrb_ros.runtime.exit_status import exit_status
    from dcrb_ros.runtime.memory import collect_rarely, keep_freed_memory

    keep_freed_memory()
    collect_rarely()
    parameters = None
    if with_parent:
        from dcrb_ros.runtime.children import end_with_parent, received_from_parent

        parameters = received_from_parent()
        end_with_parent()
    leave_at_once(exit_status(name, lambda: run(name, arguments, **({} if parameters is None else {"parameters": parameters}))))


def run(name: str, arguments: list[str], **options: Any) -> int:
    """Run a node; return the exit status.

    Raises:
        Refusal: ROS is not installed, or the arguments or the node's parameters are invalid.
    """
    from importlib import import_module

    from dcrb_ros.nodes.ros import check_ros

    check_ros()  # before the import: rclpy ends the process if the middleware is missing
    status: int = import_module(f"dcrb_ros.nodes.{name}").run(arguments, **options)
    return status


def _program(name: str) -> Callable[[], NoReturn]:
    """Return the program of a node, which takes the arguments of the command line."""
    return lambda: main(name, sys.argv[1:])


simulator, vehicle_simulator, replayer, fault_detector, vehicle_detector, hot_box_detector, viewer = map(_program, NAMES)
"""The console scripts of the nodes."""
