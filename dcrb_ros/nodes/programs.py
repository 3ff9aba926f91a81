"""The nodes as programs, for `ros2 run` and launch files.

A node takes up to a second to import. What asks it to end meanwhile is kept back until it can, in order and without a traceback
(`dcrb_ros.nodes.ros.stop_on_signals`); so this module imports next to nothing itself.
"""

from __future__ import annotations

import importlib
import signal

from dcrb_ros.runtime.signals import TERMINATION


def _run(node: str) -> None:
    if hasattr(signal, "pthread_sigmask"):  # elsewhere the node itself will say that there is no ROS
        signal.pthread_sigmask(signal.SIG_BLOCK, TERMINATION)
    importlib.import_module(f"dcrb_ros.nodes.{node}").main()


def simulator() -> None:
    """Run the bench."""
    _run("simulator")


def replayer() -> None:
    """Play a recording."""
    _run("replayer")


def fault_detector() -> None:
    """Run the shipped detector."""
    _run("fault_detector")


def viewer() -> None:
    """Show the bench in Rerun."""
    _run("viewer")
