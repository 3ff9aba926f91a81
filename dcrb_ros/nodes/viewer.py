"""The viewer node: a running bench, live or replayed, in Rerun."""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.nodes.ros import own_arguments, running, spin
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.runtime.refusal import Refusal

if TYPE_CHECKING:
    import rerun as rr
    from rclpy.node import Node

    from dcrb_ros.messages.topics import Topic
    from dcrb_ros.viewer.live import LiveView

PERIOD = 0.2
"""Wall time between two batches [s]."""
MEEKNESS = 5
"""By how much the node yields the processor to the bench, as `nice` counts."""


class ViewerWire:
    """The wires between the topics and the view."""

    def __init__(self, node: Node, view: LiveView) -> None:
        from rclpy.clock import Clock
        from rclpy.clock_type import ClockType

        from dcrb_ros.viewer.live import SHOWN

        self._view = view
        for topic in SHOWN:
            node.create_subscription(message_class(topic), topic.name, self._taking(topic), qos(topic), raw=True)
        node.create_timer(PERIOD, view.flush, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _taking(self, topic: Topic) -> Callable[[Any], None]:
        return lambda data: self._view.take(topic, bytes(data))


@contextlib.contextmanager
def _target(save: Path | None, connect: str) -> Iterator[tuple[Callable[[int], rr.RecordingStream], Callable[[], bool]]]:
    """Yield what begins a Rerun recording for the number of a run, and what says whether the viewer was closed."""
    import rerun as rr

    from dcrb_ros.viewer.document import APPLICATION
    from dcrb_ros.viewer.window import window_to_fill

    def into_file(run: int) -> rr.RecordingStream:
        assert save is not None
        stream = rr.RecordingStream(APPLICATION)
        stream.save(save if run == 1 else save.with_stem(f"{save.stem}-{run}"))
        return stream

    def into_viewer(address: str) -> Callable[[int], rr.RecordingStream]:
        def begin(run: int) -> rr.RecordingStream:
            stream = rr.RecordingStream(APPLICATION)
            stream.connect_grpc(address)
            return stream

        return begin

    if save is not None:
        yield into_file, lambda: False
    elif connect:
        yield into_viewer(connect), lambda: False
    else:
        with window_to_fill() as (viewer, address):
            yield into_viewer(address), lambda: _closed(viewer)


def _closed(viewer: subprocess.Popen[bytes]) -> bool:
    return viewer.poll() is not None


def run(arguments: list[str]) -> int:
    """Run the node until a signal comes or the window is closed; return the exit status."""
    parser = argparse.ArgumentParser(prog="viewer", description="A running bench in Rerun.")
    parser.add_argument("--save", type=Path, default=None, help="write a Rerun file (.rrd) instead of opening a window")
    parser.add_argument("--connect", default="", help="show it in a viewer that runs, such as rerun+http://127.0.0.1:9876/proxy")
    options = own_arguments(parser, arguments)
    if options.save is not None and options.connect:
        raise Refusal(f"--save {options.save} and --connect {options.connect} exclude each other: give one of them")
    if options.save is not None:
        from dcrb_ros.viewer.show import checked_output

        checked_output(options.save, suffix=".rrd", option="--save")
    from dcrb_ros.viewer.live import LiveView

    os.nice(MEEKNESS)
    with running("viewer", arguments) as (node, told):
        if told.is_set():
            return 0
        with _target(options.save, options.connect) as (begin, closed):
            view = LiveView(begin, node.get_namespace(), node.get_logger().warning)
            ViewerWire(node, view)
            try:
                spin(node, closed, told)
            finally:
                view.close()
    return 0


def main() -> None:
    """Run the node as a program."""
    sys.exit(exit_status("viewer", lambda: run(sys.argv[1:])))


if __name__ == "__main__":
    main()
