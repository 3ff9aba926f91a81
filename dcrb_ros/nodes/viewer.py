"""The viewer node: a running bench, live or replayed, in Rerun."""

from __future__ import annotations

import argparse
import os
import re
import socket
import sys
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from urllib.parse import urlsplit

import rerun as rr

from dcrb_ros.messages.topics import VIBRATION
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.ros import own_arguments, run_node
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.viewer.document import APPLICATION
from dcrb_ros.viewer.live import SHOWN, LiveView
from dcrb_ros.viewer.show import checked_output
from dcrb_ros.viewer.vehicle_content import shown_topics
from dcrb_ros.viewer.vehicle_live import VehicleLiveView
from dcrb_ros.viewer.window import ViewerFailure, window_to_fill

FLUSH_PERIOD = 0.2
"""Wall time between two batches of data sent to Rerun [s]."""
VIEWER_PORT = 9876
"""Port of a viewer that was started without one."""
FORM = re.compile(r"rerun(\+https?)?://[^\s/]+/proxy")
"""Form of the address of a viewer."""
CONNECT_TIMEOUT = 5.0
"""Wall time within which a viewer must accept a connection [s]."""
NICENESS = 5
"""Increment of the process's niceness, so that the bench has priority."""


class ViewerNode(BenchNode):
    """Shows the messages of the bench in a Rerun window, in a running viewer or in a file."""

    def __init__(self, save: Path | None = None, connect: str = "", *, vehicle: bool = False) -> None:
        """Show in the file ``save``, the viewer at the address ``connect``, or a window that is opened; a bench or a ``vehicle``.

        Raises:
            Refusal: a parameter is given, other than those of every ROS node.
        """
        super().__init__("viewer")
        self.declare(Group)
        self._save, self._address, self._vehicle = save, connect, vehicle
        self._file: Path | None = None
        self._shown: set[str] = set()
        self._resources = ExitStack()
        self._viewer_closed = lambda: False

    def start(self) -> None:
        """Open the window, if one is to be shown, and subscribe."""
        if self._save is None and not self._address:
            viewer, self._address = self._resources.enter_context(window_to_fill())
            self._viewer_closed = lambda: viewer.poll() is not None
        kind = VehicleLiveView if self._vehicle else LiveView
        view = kind(self._stream, self.get_namespace(), self.get_logger().warning)
        self._resources.callback(view.close)
        if isinstance(view, VehicleLiveView):
            self.subscribe(VEHICLE_DESCRIPTION, partial(self._describe, view))
            self.log_wait(VEHICLE_DESCRIPTION)
        else:
            # The waveform last: a bench counts the subscribers to it before it sends a block.
            for topic in sorted(SHOWN, key=lambda topic: topic is VIBRATION):
                self.subscribe(topic, partial(view.take, topic))
            self.log_wait(VIBRATION)
        self.repeat(FLUSH_PERIOD, view.flush)

    def _describe(self, view: VehicleLiveView, data: bytes) -> None:
        """Show a vehicle, and subscribe to the topics of boxes that are new."""
        view.take(VEHICLE_DESCRIPTION, data)
        names = [box.name for box in view.description.boxes] if view.description is not None else []
        # The first box last: the simulator counts the subscribers to its waveform before it sends a block.
        for topic in reversed(shown_topics(names)):
            if topic != VEHICLE_DESCRIPTION and topic.name not in self._shown:
                self._shown.add(topic.name)
                self.subscribe(topic, partial(view.take, topic))

    def _stream(self, run: int) -> rr.RecordingStream:
        """Return the Rerun recording of a run; a new run begins after a reset, in a file of its own that did not exist."""
        stream = rr.RecordingStream(APPLICATION)
        if self._save is None:
            stream.connect_grpc(self._address)
            return stream
        path, number = self._save, run
        while run > 1 and (path == self._save or path.exists()):
            path, number = self._save.with_stem(f"{self._save.stem}-{number}"), number + 1
        self._file = path
        stream.save(path)
        return stream

    @property
    def ended(self) -> bool:
        """Whether the window was closed."""
        return self._viewer_closed()

    def close(self) -> None:
        """Send the remaining data.

        Raises:
            ViewerFailure: the file could not be written to its end.
        """
        try:
            self._resources.close()
        except RuntimeError as error:
            if self._file is None or isinstance(error, ViewerFailure):
                raise
            # Rerun writes in a thread of its own, whose error it only logs.
            remedy = "free some space or give another file"
            raise ViewerFailure(f"{self._file} is incomplete, it cannot be written ({error}): {remedy}") from None


def _check_address(address: str) -> None:
    """Check that a viewer listens at an address; Rerun itself would try forever.

    Raises:
        Refusal: the address is invalid, or nothing listens there.
    """
    try:
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port or VIEWER_PORT
    except ValueError:
        host, port = None, 0
    if host is None or not FORM.fullmatch(address):
        raise Refusal(f"--connect {address} is not the address of a viewer: write one such as rerun+http://127.0.0.1:{VIEWER_PORT}/proxy")
    try:
        with socket.create_connection((host, port), timeout=CONNECT_TIMEOUT):
            pass
    except OSError as error:
        raise Refusal(f"--connect {address}: no viewer answers at {host}:{port} ({error}): start one, or correct the address") from None


def run(arguments: list[str]) -> int:
    """Run the node until a termination signal arrives or the window is closed; return the exit status."""
    parser = argparse.ArgumentParser(prog="viewer", description="A running bench in Rerun.")
    parser.add_argument("--save", type=Path, default=None, help="write a Rerun file (.rrd) instead of opening a window")
    parser.add_argument("--vehicle", action="store_true", help="show the axle boxes of a vehicle")
    parser.add_argument("--connect", default="", help="address of a running viewer, such as rerun+http://127.0.0.1:9876/proxy")
    options = own_arguments(parser, arguments)
    if options.save is not None and options.connect:
        raise Refusal(f"--save {options.save} and --connect {options.connect} exclude each other: give one of them")
    if options.save is not None:
        checked_output(options.save, suffix=".rrd", option="--save")
    if options.connect:
        _check_address(options.connect)
    os.nice(NICENESS)
    return run_node(lambda: ViewerNode(options.save, options.connect, vehicle=options.vehicle), arguments)


if __name__ == "__main__":
    main("viewer", sys.argv[1:])
