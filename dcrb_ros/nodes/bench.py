"""The bench in one command: simulator and fault detector as processes, and an observer that shows a status line."""

from __future__ import annotations

import pickle
import shlex
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.joints import Joints, decode_joints
from dcrb_ros.messages.statuses import Status, decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, DIAGNOSIS, FEATURES, NAMESPACE, VIBRATION, Topic
from dcrb_ros.nodes.programs import WITH_PARENT
from dcrb_ros.nodes.publisher import subscribe
from dcrb_ros.nodes.ros import check_bench_discovery, check_ros, node_in, stop_on_signals
from dcrb_ros.runtime import terminal
from dcrb_ros.runtime.children import signals_blocked
from dcrb_ros.runtime.signals import STOPPED
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.text.files import expanded_path

VERDICT_TIMEOUT = 3.0
"""Wall time after the last block in which the last verdict must arrive [s]."""
SUBSCRIBER_TIMEOUT = 20.0
"""Wall time in which the other nodes must subscribe before the simulator is started [s]."""
EXIT_TIMEOUT = 10.0
"""Wall time in which a node must end after SIGINT [s]."""
SPIN_TIME = 0.05
"""Longest wait for a message between two checks of the processes [s]."""


def _with_values(status: Status, *keys: str) -> Status:
    """Return a status, or refuse it if one of the values ``keys`` is missing."""
    absent = [key for key in keys if key not in status.values]
    if absent:
        raise Refusal(f"the status '{status.name}' has no {', '.join(absent)}: it does not belong to this bench")
    return status


class Observer:
    """Keeps the last messages of the bench for the status line and the result."""

    simulator = "simulator"
    """Name of the node whose status is shown."""
    needs = "a turning shaft"
    """What the signal must have for a verdict."""

    def __init__(self) -> None:
        self.blocks = 0
        self.refused = 0
        """Invalid messages; they are ignored."""
        self.verdict: Status | None = None
        self.verdict_ns = 0
        self.bench: Status | None = None
        self.features: Joints | None = None

    def topics(self) -> Mapping[Topic, Callable[[bytes], None]]:
        """Return what takes the messages of each topic."""
        return {
            DIAGNOSIS: self._on_diagnosis,
            BENCH_DIAGNOSTICS: self._on_bench,
            FEATURES: self._on_features,
            VIBRATION: self._on_block,
        }

    def subscribe(self, node: Any) -> None:
        """Subscribe to the topics of the bench."""
        for topic, callback in self.topics().items():
            subscribe(node, topic, partial(self._receive, callback))

    def _receive(self, callback: Callable[[bytes], None], data: bytes) -> None:
        try:
            callback(data)
        except Refusal:
            self.refused += 1

    def _on_block(self, data: bytes) -> None:
        self.blocks += 1

    def _on_diagnosis(self, data: bytes) -> None:
        time_ns, statuses = decode_diagnostics(data)
        if not statuses:
            raise Refusal("a diagnosis without a status has no verdict")
        self.verdict = _with_values(statuses[0], "confidence", "reason", "BPFO [dB]", "BPFI [dB]")
        self.verdict_ns = time_ns

    def _on_bench(self, data: bytes) -> None:
        """Keep the status of the simulator; other nodes publish on the same topic."""
        for status in decode_diagnostics(data)[1]:
            if status.name == f"{NAMESPACE}/{self.simulator}":
                self.bench = _with_values(status, "real_time_factor", "late_blocks")

    def _on_features(self, data: bytes) -> None:
        joints = decode_joints(data)
        if not {"rms", "kurtosis"} <= set(joints.names[: len(joints.position)]):
            raise Refusal("a JointState without rms and kurtosis does not contain the features of the bench")
        self.features = joints

    def pace(self) -> list[str]:
        """Return the parts of the status line about the speed of the bench."""
        if self.bench is None:
            return []
        paused = ["paused"] if self.bench.values.get("model") == "paused" else []
        if not self.bench.values["real_time_factor"]:  # before the first block
            return paused
        return [*paused, f"{self.bench.values['real_time_factor']} x real time, {self.bench.values['late_blocks']} late"]

    def verdicts(self) -> list[str]:
        """Return the verdicts in words; none without a verdict."""
        if self.verdict is None or self.verdict.message == "waiting":
            return []
        return [f"verdict: {self.verdict.message} {self.evidence(self.verdict)}"]

    def evidence(self, status: Status) -> str:
        """Return confidence, time and reason of a verdict."""
        confidence, reason = status.values.get("confidence", "?"), status.values.get("reason", "")
        return f"(confidence {confidence}) at {self.verdict_ns * 1e-9:.2f} s: {reason}"

    def line(self) -> str:
        """Return the status line."""
        if self.features is None:
            return "waiting for the first block ..."
        values = dict(zip(self.features.names, self.features.position, strict=False))
        parts = [f"{self.features.stamp_ns * 1e-9:6.2f} s simulated", *self.pace()]
        parts.append(f"rms {values['rms']:7.1f} m/s^2, kurtosis {values['kurtosis']:5.1f}")
        if self.verdict is not None:
            levels = "  ".join(f"{name} {self.verdict.values[f'{name} [dB]']}" for name in ("BPFO", "BPFI"))
            parts.append(f"{levels} dB  ->  {self.verdict.message}")
        return "  |  ".join(parts)


@contextmanager
def node_process(name: str, arguments: Sequence[str], parameters: Any = None) -> Iterator[subprocess.Popen[bytes]]:
    """Run a node as a process, with checked parameters if they are given, which need no second check.

    The process is ended in any case: it also ends with this process, by the pipe to its standard input.
    """
    with signals_blocked():
        command = [sys.executable, "-m", "dcrb_ros.nodes", WITH_PARENT, name, *arguments]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, bufsize=0, start_new_session=True)
    assert process.stdin is not None
    try:
        with suppress(BrokenPipeError):  # the node ended during its start
            process.stdin.write(pickle.dumps(parameters))
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(EXIT_TIMEOUT)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        process.stdin.close()


@dataclass(frozen=True)
class Bench:
    """The nodes of a bench, and their observer."""

    about: str
    """Name and parts."""
    waiting_for: Callable[[int], Any]
    """Returns the parameters with which the simulator waits for a number of subscribers to the waveform."""
    detector: tuple[str, Group]
    """Name and parameters."""
    viewer: tuple[str, Sequence[str]] | None
    """Name and arguments; None for none."""
    first: Topic
    """The topic to which detector, viewer and observer subscribe when they start."""
    observer: Observer
    """Keeps what is shown."""


def bearing_bench(name: str, configuration: Configuration, detector_parameters: DetectorParameters, *, shown: bool = False) -> Bench:
    """Return the bench of a bearing; with ``shown`` Rerun shows it, whose failure does not stop the bench."""
    return Bench(
        f"'{name}': simulator and fault detector",
        lambda listeners: _waiting_for(configuration, listeners),
        ("fault_detector", detector_parameters),
        ("viewer", []) if shown else None,
        VIBRATION,
        Observer(),
    )


def run(bench: Bench, configuration: Configuration, duration: float, scenario: Path | None = None) -> int:
    """Run the nodes of a bench for ``duration`` of simulated time [s], show a status line, and print the verdicts; return the exit status.

    The ``configuration`` gives time scale and recording. The simulator plays a ``scenario``, if one is given.
    """
    console = terminal.console(stderr=True)
    check_ros()
    check_bench_discovery()
    stop = stop_on_signals()
    console.print(f"bench {bench.about} as ROS 2 nodes in {NAMESPACE}, {duration:g} s at time scale {configuration.time_scale:g}")
    arguments = ["--duration", repr(duration), *(["--scenario", str(scenario)] if scenario else [])]
    with ExitStack() as stack:
        node, spin = stack.enter_context(node_in("bench"))
        bench.observer.subscribe(node)
        detector = stack.enter_context(node_process(bench.detector[0], [], bench.detector[1]))
        subscribers = [detector, *([stack.enter_context(node_process(*bench.viewer))] if bench.viewer else [])]
        # The simulator is started last, so that the others do not slow it down by their start.
        _await_subscribers(node, spin, bench.first, subscribers, stop)
        if stop.is_set():
            console.print("stopped before the simulator was started")
            return STOPPED
        # Its first block waits until they have discovered it.
        with node_process(bench.observer.simulator, arguments, bench.waiting_for(1 + _running(subscribers))) as process:
            status = _watch(bench.observer, spin, process, detector, duration, stop, console)
    status = status or _exit_status(process.returncode)  # a stopped simulator may have failed to write its recording
    return _conclude(bench.observer, "" if status else configuration.recording.path, console, status)


def _exit_status(returncode: int) -> int:
    """Return the exit status of a stopped simulator; 1 if it did not end in time and was killed, 0 if the signal came before its start."""
    return 1 if returncode == -signal.SIGKILL else max(returncode, 0)


def _ended(name: str, returncode: int) -> str:
    """Return a sentence about the end of a process, which is negative if a signal has killed it."""
    if returncode >= 0:
        return f"the {name} ended with status {returncode}"
    return f"the {name} was killed by signal {-returncode} ({signal.strsignal(-returncode)})"


def _waiting_for(configuration: Configuration, listeners: int) -> Configuration:
    """Return a configuration with which the simulator waits for at least so many subscribers to the waveform."""
    publishing = configuration.publishing
    publishing = publishing.model_copy(update={"listeners": max(publishing.listeners, listeners)})
    return configuration.model_copy(update={"publishing": publishing})


def _running(processes: Sequence[subprocess.Popen[bytes]]) -> int:
    return sum(process.poll() is None for process in processes)


def _await_subscribers(
    node: Any, spin: Callable[[float], None], first: Topic, processes: Sequence[subprocess.Popen[bytes]], stop: threading.Event
) -> None:
    """Wait until the observer and every running process have subscribed, at most `SUBSCRIBER_TIMEOUT`."""
    topic, deadline = first.resolved(NAMESPACE), time.monotonic() + SUBSCRIBER_TIMEOUT
    while not stop.is_set() and time.monotonic() < deadline:
        if node.count_subscribers(topic) > _running(processes):
            return
        spin(SPIN_TIME)


def _watch(
    observer: Observer,
    spin: Callable[[float], None],
    simulator: subprocess.Popen[bytes],
    detector: subprocess.Popen[bytes],
    duration: float,
    stop: threading.Event,
    console: Console,
) -> int:
    """Show the status line until the simulator ends; return the status of a node that failed, or 0."""
    end_ns, deadline, shown = round((duration - 1.0) * 1e9), None, 0.0
    with console.status("starting ...") as status:
        while not stop.is_set():
            spin(SPIN_TIME)
            now = time.monotonic()
            if console.is_terminal:
                status.update(observer.line())
            elif now - shown > 1.0 and observer.features is not None:
                console.print(observer.line(), highlight=False, soft_wrap=True)
                shown = now
            if detector.poll() is not None:
                console.print(_ended("fault detector", detector.returncode))
                return 1
            if simulator.poll() is None:
                continue
            if simulator.returncode < 0:
                console.print(_ended("simulator", simulator.returncode))
                return 1
            if simulator.returncode > 0:  # it has said why
                return simulator.returncode
            deadline = deadline or now + VERDICT_TIMEOUT
            if now > deadline or observer.verdict_ns >= end_ns:
                return 0
    return 0


def _conclude(observer: Observer, recorded: str, console: Console, status: int) -> int:
    """Print verdicts, recording and how to open it; return the ``status`` of a node that failed, or 1 if there is no verdict."""
    path = expanded_path(recorded)
    if recorded and path.exists():  # a recording without a block is removed
        print(f"recording: {path}")
        print(f"open it with: {shlex.join(('dcrb', 'view', str(path)))}   or: {shlex.join(('rerun', str(path / f'{path.name}_0.mcap')))}")
    if observer.refused:
        console.print(f"{observer.refused} invalid messages on the topics of the bench were ignored")
    verdicts = observer.verdicts()
    if verdicts:
        print("\n".join(verdicts))
    elif not status:
        console.print(f"no verdict after {observer.blocks} blocks: the detector needs a few seconds of signal with {observer.needs}")
    return status or int(not verdicts)
