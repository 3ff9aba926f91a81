"""The program that runs a detector written in Python for the exam, in a process of its own.

The exam sends what a detector may know: characteristic orders, sampling rate, description of the bearing, blocks and temperatures. Neither
the scenario nor the expected verdict enters this process, and its standard output is not that of the exam.
"""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, TypeAlias, TypeVar

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.exam.packets import receive_packet, send_packet
from dcrb_ros.exam.plugin import load_plugin
from dcrb_ros.exam.running_detector import (
    BoxSamples,
    DetectorBlock,
    RunningDetector,
    RunningVehicleDetector,
    checked_output,
)
from dcrb_ros.runtime.memory import keep_freed_memory
from dcrb_ros.schema.printable import shortened
from dcrb_ros.schema.refusal import LONGEST, Refusal
from dcrb_ros.stream.vehicle_description import VehicleDescription

READY, NOTHING, MESSAGE, VERDICT, STATUSES, REFUSED, FAILED, LEFTOVER = b"+", b"-", b"m", b"v", b"s", b"r", b"f", b"l"
"""First bytes of the answers: done, no diagnosis, a message on `diagnosis`, a verdict, verdicts and scores by status in JSON, a refusal, a
failure, done with threads left."""
THREAD_PATIENCE = 2.0
"""Time in which the threads of a detector must end after its last block [s]."""


Imported = TypeVar("Imported")


class Begin(NamedTuple):
    """Request for a new detector."""

    orders: Orders
    rate: int
    """Sampling rate [Hz]."""
    bearing: bytes
    """The bearing, pickled apart, since most detectors do not need it; None if it is unknown."""


class BeginVehicle(NamedTuple):
    """Request for a new detector of a vehicle."""

    description: str
    """The `VehicleDescription` in JSON."""


VehiclePiece: TypeAlias = dict[str, BoxSamples]
"""Blocks of all boxes."""
Request: TypeAlias = Begin | DetectorBlock | BeginVehicle | VehiclePiece
Running: TypeAlias = RunningDetector | RunningVehicleDetector


def main() -> None:
    """Serve the socket, the class and the memory [bytes] in the arguments until the exam closes the socket or the detector fails."""
    channel = connected()
    factory = imported(channel, load_plugin)
    if factory is None:
        return
    send_packet(channel, READY)
    with contextlib.suppress(OSError):  # the exam has ended
        while _scenario(channel, factory):
            pass
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)  # whatever threads are left


def connected() -> socket.socket:
    """Return the socket in the arguments, after this process has been prepared for a detector with the memory in them."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    channel = socket.socket(fileno=int(sys.argv[1]))
    channel.set_inheritable(False)
    keep_freed_memory()
    _limit_memory(int(sys.argv[3]))
    return channel


def imported(channel: socket.socket, load: Callable[[str], Imported]) -> Imported | None:
    """Return what ``load`` gives for the name in the arguments; None after sending the reason why it cannot be imported."""
    try:
        return load(sys.argv[2])
    except Refusal as refusal:
        answer = _reason(REFUSED, refusal)
    except BaseException as error:  # such as KeyboardInterrupt
        answer = REFUSED + f"--python {sys.argv[2]} cannot be imported: {type(error).__name__}".encode()
    send_packet(channel, answer)
    return None


def _scenario(channel: socket.socket, factory: Any) -> bool:
    """Run a detector on the blocks of a scenario; return whether this process can run another one."""
    detector: Running | None = None
    before = set(threading.enumerate())
    while (packet := receive_packet(channel)) is not None:
        request: Request | None = pickle.loads(packet)
        if request is None:
            del detector
            answer = _threads_left(before)
            send_packet(channel, answer)
            return answer == READY
        try:
            if isinstance(request, (Begin, BeginVehicle)):
                detector, answer = _made(factory, request), READY
            else:
                assert detector is not None
                answer = _answer(detector, request)
        except Refusal as refusal:
            answer = _reason(REFUSED, refusal)
        except BaseException as error:  # whatever the detector raises
            answer = _reason(FAILED, error)
        send_packet(channel, answer)
        if answer[:1] in (REFUSED, FAILED):
            return False
    return False


def _reason(kind: bytes, error: BaseException) -> bytes:
    """Return the answer for an exception, whose text may have any length."""
    return kind + shortened(str(error) or type(error).__name__, LONGEST).encode(errors="replace")


def _made(factory: Any, begin: Begin | BeginVehicle) -> Running:
    if isinstance(begin, BeginVehicle):
        return RunningVehicleDetector(factory, VehicleDescription.from_json(begin.description))
    return RunningDetector(factory, begin.orders, begin.rate, partial(pickle.loads, begin.bearing))


def _answer(detector: Running, block: DetectorBlock | VehiclePiece) -> bytes:
    if isinstance(detector, RunningVehicleDetector):
        assert isinstance(block, dict)
        statuses = detector.take(block)
        return NOTHING if statuses is None else STATUSES + json.dumps(statuses).encode()
    assert isinstance(block, DetectorBlock)
    output = checked_output(detector.take(block))
    if output is None:
        return NOTHING
    if isinstance(output, str):
        return VERDICT + output.encode()
    from dcrb_ros.messages.topics.diagnosis import encode_diagnosis  # a second, which most detectors do not need

    try:
        return MESSAGE + encode_diagnosis(output)
    except Exception as error:
        raise RuntimeError(f"update returned a diagnosis with an invalid value: {error}") from error


def _threads_left(before: set[threading.Thread]) -> bytes:
    """Return the answer to the end of a scenario: threads that keep a program from ending are a failure."""
    deadline = time.monotonic() + THREAD_PATIENCE
    started = [thread for thread in threading.enumerate() if thread not in before]
    for thread in started:
        if not thread.daemon:
            thread.join(max(0.0, deadline - time.monotonic()))
    endless = [thread.name for thread in started if thread.is_alive() and not thread.daemon]
    if endless:
        return FAILED + f"{len(endless)} threads still run {THREAD_PATIENCE:g} s after the last block ({', '.join(endless)})".encode()
    return LEFTOVER if any(thread.is_alive() for thread in started) else READY


def _limit_memory(size: int) -> None:
    """Limit the memory that this process can write to [bytes], where the system has such a limit."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        resource.setrlimit(resource.RLIMIT_DATA, (size if most == resource.RLIM_INFINITY else min(size, most), most))
