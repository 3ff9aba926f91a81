"""The nodes as programs, for `ros2 run`, launch files and `python -m dcrb_ros.nodes`.

Importing a node takes up to a second. Termination signals are blocked until it can end orderly (`dcrb_ros.nodes.ros.stop_on_signals`), so
this module itself imports next to nothing before they are.
"""

from __future__ import annotations

import importlib
import signal
import sys
import threading
from typing import Any, NoReturn

from dcrb_ros.runtime.signals import TERMINATION

MODEL_THREAD = "model"
"""Name of the thread that runs the simulation."""
NAMES = ("simulator", "replayer", "fault_detector", "viewer")


def main(name: str, arguments: list[str]) -> NoReturn:
    """Run a node as a program, and exit."""
    if hasattr(signal, "pthread_sigmask"):  # where it does not exist there is no ROS either, which the node reports
        signal.pthread_sigmask(signal.SIG_BLOCK, TERMINATION)
    from dcrb_ros.runtime.exit_status import exit_status

    status = exit_status(name, lambda: run(name, arguments))
    if any(thread.name == MODEL_THREAD for thread in threading.enumerate()):
        # A compilation cannot be interrupted, and the interpreter must not be shut down during it.
        _exit_at_once(status)
    sys.exit(status)


def run(name: str, arguments: list[str], **options: Any) -> int:
    """Run a node; return the exit status.

    Raises:
        Refusal: ROS is not installed, or the arguments or the node's parameters are invalid.
    """
    from dcrb_ros.nodes.ros import check_ros

    check_ros()  # before the import: rclpy ends the process if the middleware is missing
    status: int = importlib.import_module(f"dcrb_ros.nodes.{name}").run(arguments, **options)
    return status


def _exit_at_once(status: int) -> NoReturn:
    import os

    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def simulator() -> None:
    """Simulate a bearing."""
    main("simulator", sys.argv[1:])


def replayer() -> None:
    """Replay a recording."""
    main("replayer", sys.argv[1:])


def fault_detector() -> None:
    """Run the fault detector."""
    main("fault_detector", sys.argv[1:])


def viewer() -> None:
    """Show the bench in Rerun."""
    main("viewer", sys.argv[1:])
