"""The bench in one command: both nodes as processes of their own, and an observer with a status line."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.joints import Joints, decode_joints
from dcrb_ros.messages.statuses import Status, decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, DIAGNOSIS, FEATURES, NAMESPACE, VIBRATION, Topic
from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.nodes.ros import check_ros, limit_discovery, signals_blocked, stop_on_signals
from dcrb_ros.runtime.exit_status import STOPPED
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.schema.fields import Group
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import to_yaml

LAST_WORDS = 3.0
"""Wall time that the detector gets for its last verdict after the last block [s]."""
LISTENER_START = 20.0
"""Wall time that the detector gets to come up [s]."""
CHILD_END = 10.0
"""Wall time that a node gets to end after SIGINT [s]."""


def _with_values(status: Status, *keys: str) -> Status:
    """Return a status that has the values ``keys``; refuse any other."""
    absent = [key for key in keys if key not in status.values]
    if absent:
        raise Refusal(f"the status '{status.name}' has no {', '.join(absent)}: it is not of this bench")
    return status


class Observer:
    """What the bench has said so far."""

    def __init__(self) -> None:
        self.blocks = 0
        self.refused = 0
        """Messages that were not understood; they are left aside."""
        self.verdict: Status | None = None
        self.verdict_ns = 0
        self.bench: Status | None = None
        self.features: Joints | None = None

    def subscribe(self, node: Any) -> None:
        """Listen to the bench's topics."""

        def listen(topic: Topic, callback: Any) -> None:
            def heard(data: bytes) -> None:
                try:
                    callback(bytes(data))
                except Refusal:
                    self.refused += 1

            node.create_subscription(message_class(topic), topic.resolved(NAMESPACE), heard, qos(topic), raw=True)

        listen(DIAGNOSIS, self._on_diagnosis)
        listen(BENCH_DIAGNOSTICS, self._on_bench)
        listen(FEATURES, self._on_features)
        listen(VIBRATION, self._on_block)

    def _on_block(self, data: bytes) -> None:
        self.blocks += 1

    def _on_diagnosis(self, data: bytes) -> None:
        time_ns, statuses = decode_diagnostics(data)
        if not statuses:
            raise Refusal("a diagnosis without a status is no verdict")
        self.verdict = _with_values(statuses[0], "confidence", "reason", "BPFO [dB]", "BPFI [dB]")
        self.verdict_ns = time_ns

    def _on_bench(self, data: bytes) -> None:
        """Take the simulator's status; others may report on the same topic."""
        for status in decode_diagnostics(data)[1]:
            if status.name == f"{NAMESPACE}/simulator":
                self.bench = _with_values(status, "real_time_factor", "late_blocks")

    def _on_features(self, data: bytes) -> None:
        joints = decode_joints(data)
        if not {"rms", "kurtosis"} <= set(joints.names[: len(joints.position)]):
            raise Refusal("a JointState without rms and kurtosis has no features of the bench")
        self.features = joints

    def line(self) -> str:
        """Return the status line."""
        if self.features is None:
            return "waiting for the first block ..."
        values = dict(zip(self.features.names, self.features.position, strict=False))
        words = [f"{self.features.stamp_ns * 1e-9:6.2f} s simulated"]
        if self.bench is not None:
            if self.bench.values.get("model") == "paused":
                words.append("paused")
            words.append(f"{self.bench.values['real_time_factor']} x real time, {self.bench.values['late_blocks']} late")
        words.append(f"rms {values['rms']:7.1f} m/s^2, kurtosis {values['kurtosis']:5.1f}")
        if self.verdict is not None:
            levels = "  ".join(f"{name} {self.verdict.values[f'{name} [dB]']}" for name in ("BPFO", "BPFI"))
            words.append(f"{levels} dB  ->  {self.verdict.message}")
        return "  |  ".join(words)


@contextmanager
def node_process(name: str, arguments: Sequence[str], environment: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    """Run a node as a process; whatever happens, it is ended."""
    command = [sys.executable, "-m", "dcrb_ros.nodes", name, *arguments]
    with signals_blocked():
        process = subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(CHILD_END)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def run(
    name: str,
    configuration: Configuration,
    detecting: DetectorParameters,
    duration: float,
    scenario: Path | None = None,
    *,
    shown: bool = False,
) -> int:
    """Run the bench for ``duration`` [s] of simulated time, through a scenario if there is one; return the exit status.

    With ``shown`` Rerun shows it meanwhile; where it cannot, the bench runs all the same.
    """
    check_ros()
    told = stop_on_signals()
    limit_discovery()
    environment = dict(os.environ)
    console = Console(stderr=True)
    with tempfile.TemporaryDirectory(prefix="dcrb-") as folder:
        ros, ros_of_detector = (_in_file(Path(folder) / f"{i}.yaml", group) for i, group in enumerate((configuration, detecting)))
        console.print(
            f"bench '{name}': simulator and fault detector as ROS 2 nodes in {NAMESPACE}, "
            f"{duration:g} s at time scale {configuration.time_scale:g}"
        )
        arguments = ["--duration", repr(duration), *(["--scenario", str(scenario)] if scenario else []), *ros]
        observer = Observer()
        with ExitStack() as stack:
            node = stack.enter_context(_observing(observer))
            detector = stack.enter_context(node_process("fault_detector", ros_of_detector, environment))
            listeners = [detector, *([stack.enter_context(node_process("viewer", [], environment))] if shown else [])]
            # The simulator waits for its listeners, so that they get the first block and do not start up beside it.
            _await_listeners(node, listeners, told)
            if told.is_set():
                console.print("stopped before the simulator was started")
                return STOPPED
            with node_process("simulator", arguments, environment) as simulator:
                failed = _watch(observer, node, simulator, detector, duration, told, console)
    return failed or _conclude(observer, configuration, console)


def _in_file(path: Path, parameters: Group) -> list[str]:
    """Write parameters into a file; return the arguments with which a node reads it."""
    path.write_text(to_yaml(parameters), encoding="utf-8")
    return ["--ros-args", "--params-file", str(path)]


@contextmanager
def _observing(observer: Observer) -> Iterator[Any]:
    """Yield a node through which the observer listens."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import try_shutdown

    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("bench", namespace=NAMESPACE)
    observer.subscribe(node)
    try:
        yield node
    finally:
        node.destroy_node()
        try_shutdown()


def _await_listeners(node: Any, listeners: Sequence[subprocess.Popen[bytes]], told: threading.Event) -> None:
    """Wait until those of the listeners that have not ended listen beside the observer, or have had their time."""
    import rclpy

    topic, patience = VIBRATION.resolved(NAMESPACE), time.monotonic() + LISTENER_START
    while not told.is_set() and time.monotonic() < patience:
        if node.count_subscribers(topic) > sum(listener.poll() is None for listener in listeners):
            return
        rclpy.spin_once(node, timeout_sec=0.05)


def _watch(
    observer: Observer,
    node: Any,
    simulator: subprocess.Popen[bytes],
    detector: subprocess.Popen[bytes],
    duration: float,
    told: threading.Event,
    console: Console,
) -> int:
    """Show the status line until the simulator ends; return the status of a node that failed, or 0."""
    import rclpy

    end_ns, patience, shown = round((duration - 1.0) * 1e9), None, 0.0
    with console.status("starting ...") as status:
        while not told.is_set():
            rclpy.spin_once(node, timeout_sec=0.05)
            now = time.monotonic()
            if console.is_terminal:
                status.update(observer.line())
            elif now - shown > 1.0 and observer.features is not None:
                console.print(observer.line(), highlight=False, soft_wrap=True)
                shown = now
            if detector.poll() is not None:
                console.print(f"the fault detector ended with status {detector.returncode}")
                return 1
            if simulator.poll() is None:
                continue
            if simulator.returncode != 0:
                return simulator.returncode if simulator.returncode > 0 else 1  # below zero it was killed by a signal
            patience = patience or now + LAST_WORDS
            if now > patience or observer.verdict_ns >= end_ns:
                return 0
    return 0


def _conclude(observer: Observer, configuration: Configuration, console: Console) -> int:
    """Print verdict, recording and what to do next; return 1 where there is no verdict."""
    if configuration.recording.path:
        path = Path(configuration.recording.path)
        print(f"recording: {path}")
        print(f"open it with: dcrb view {path}   or: rerun {path / (path.name + '_0.mcap')}")
    if observer.refused:
        console.print(f"{observer.refused} messages on the bench's topics were not understood and left aside")
    if observer.verdict is None or observer.verdict.message == "waiting":
        console.print(f"no verdict after {observer.blocks} blocks: the detector needs a few seconds of a turning shaft")
        return 1
    values = observer.verdict.values
    print(
        f"verdict: {observer.verdict.message} (confidence {values['confidence']}) at {observer.verdict_ns * 1e-9:.2f} s: {values['reason']}"
    )
    return 0
