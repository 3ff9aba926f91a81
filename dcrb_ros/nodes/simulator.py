"""The simulator node: the model in a thread of its own behind a live accelerometer topic."""

from __future__ import annotations

import argparse
import math
import os
import sys
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

from dcrb_ros.configuration import Configuration
from dcrb_ros.guard import guarded
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.ros import changed, check_ros, create_node, declare, spin, stop_on_signals
from dcrb_ros.refusal import Refusal
from dcrb_ros.sinks.publisher import message_class, qos
from dcrb_ros.topics import BENCH_DIAGNOSTICS, DIAGNOSIS, FAULT_INDICATORS, ROLLER_CONTACTS, SIMULATED, VIBRATION_CLEAN, Message, Topic

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rclpy.node import Node

    from dcrb_ros.block import Block
    from dcrb_ros.simulation import Simulation
    from dcrb_ros.sinks.queued import QueuedRecorder

REPEAT_REFUSAL = 5.0
"""Wall time for which the same kind of refusal is not logged again [s]."""
LAST_BLOCK = 1.0
"""Wall time that the model gets to end its block once told to stop [s]; compiling takes longer and is not waited for."""
MODEL = "model"
"""Name of the model's thread."""
COMMANDS = ("command/speed", "command/load")


class Sink(Protocol):
    """Where messages go."""

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Take messages."""


def _content(kind: str, decode: Callable[[bytes], Any], data: bytes) -> Any:
    """Return what a message holds; a refusal names the topic ``kind``."""
    try:
        return decode(bytes(data))
    except Refusal as refusal:
        raise Refusal(f"{kind}: {refusal}") from None


class Simulator:
    """The wires between the simulation's thread and ROS."""

    def __init__(self, node: Node, configuration: Configuration, duration: float | None) -> None:
        from dcrb_ros.messages import BlockEncoder
        from dcrb_ros.sinks.publisher import Publisher

        self.node, self.configuration, self._duration = node, configuration, duration
        self.stop = threading.Event()
        self.failure: Exception | None = None
        self._began = time.monotonic()
        self._pacer = Pacer(configuration.time_scale, time.monotonic)
        self._simulation = self._start_model()
        self._recorder = self._start_recorder()
        self._recorder_state = "recording" if self._recorder else "off"
        self._encoder = BlockEncoder(configuration, self._simulation.layout)
        asked = {VIBRATION_CLEAN: configuration.publishing.clean, ROLLER_CONTACTS: configuration.publishing.contacts}
        topics = [topic for topic in SIMULATED if asked.get(topic, True)]
        self._publisher: Sink = Publisher(node, [*topics, BENCH_DIAGNOSTICS])
        self._refused: dict[str, int] = {}
        self._logged: dict[str, float] = {}
        self._simulated_ns = 0
        self._residual = 0.0
        self._reached = self._factor = 0.0
        self._measured_at = time.monotonic()
        self._blocks = 0
        self._subscribe()
        self._thread = threading.Thread(target=self._run, name=MODEL, daemon=True)

    def _start_model(self) -> Simulation:
        from dcrb_ros.core import compiled

        if not compiled():
            self.node.get_logger().info("compiling the kernels (once, about half a minute) ...")
        from dcrb_ros.simulation import Simulation

        return Simulation(self.configuration)

    def _start_recorder(self) -> QueuedRecorder | None:
        asked = self.configuration.recording
        if not asked.path:
            return None
        from dcrb_ros.sinks.queued import QueuedRecorder
        from dcrb_ros.sinks.recorder import Recorder

        recorder = Recorder(asked.path, self.configuration, self._simulation.layout, namespace=self.node.get_namespace())
        return QueuedRecorder(recorder, asked.queue)

    def _subscribe(self) -> None:
        from geometry_msgs.msg import Wrench
        from std_msgs.msg import Float64

        from dcrb_ros.messages import decode_diagnostics, decode_joints

        node = self.node
        # Raw, because the middleware's own decoder drops malformed bytes without a word.
        node.create_subscription(Float64, "command/speed", self._on_speed, 10, raw=True)
        node.create_subscription(Wrench, "command/load", self._on_load, 10, raw=True)
        node.create_timer(1.0, self._report)
        node.add_on_set_parameters_callback(self._on_parameters)
        if self._recorder is not None:
            self._listen(DIAGNOSIS, lambda data: decode_diagnostics(data)[0])
            self._listen(FAULT_INDICATORS, lambda data: decode_joints(data).stamp_ns)

    def _listen(self, topic: Topic, stamp: Callable[[bytes], int]) -> None:
        """Record what the detector says; ``stamp`` decodes a message and returns its stamp [ns]."""
        callback = self._on_detected(topic, stamp)
        self.node.create_subscription(message_class(topic), topic.name, callback, qos(topic), raw=True)

    def start(self) -> None:
        """Start the model's thread."""
        self._publisher.write_messages(self._encoder.start())
        self._thread.start()

    def ended(self) -> bool:
        """Return whether the model's thread has come to its end."""
        return not self._thread.is_alive()

    def close(self) -> None:
        """Stop the model and finish the recording; a model that still compiles is left behind, it says nothing any more."""
        self.stop.set()
        if self._thread.ident is not None:
            self._thread.join(LAST_BLOCK)
        self._record(None)

    def _run(self) -> None:
        try:
            for block in self._simulation.blocks(self._duration):
                # Encoded before the wait: a block goes out at its deadline, and the first one's preparations do not count.
                messages = self._encoder.encode(block)
                if self.stop.wait(self._pacer.until(block.stamp_ns * 1e-9, block.end_ns * 1e-9)):
                    return
                self._emit(block, messages)
        except Exception as error:  # the thread's end must reach the main thread, whatever it is
            self.failure = error

    def _emit(self, block: Block, messages: list[Message]) -> None:
        self._publisher.write_messages(messages)
        self._record(messages)
        self._blocks += 1
        self._simulated_ns = block.end_ns
        if block.states:
            self._residual = block.states[-1].energy.residual
        if self._blocks == 1:
            self.node.get_logger().info(f"first block {time.monotonic() - self._began:.2f} s after the start")

    def _record(self, messages: Iterable[Message] | None) -> None:
        """Record messages, or finish the recording; a failure ends the recording and leaves the topics alive."""
        from dcrb_ros.sinks.recorder import RecordingFailed

        if self._recorder is None:
            return
        try:
            if messages is None:
                self._recorder.close()
            else:
                self._recorder.write_messages(messages)
        except RecordingFailed as error:
            self._recorder_state = str(error)
            self.node.get_logger().error(str(error))

    def _on_detected(self, topic: Topic, stamp: Callable[[bytes], int]) -> Callable[[bytes], None]:
        def record(data: bytes) -> None:
            with self._refusing(topic.name):
                time_ns = _content(topic.name, stamp, data)
                self._check_time(topic, time_ns)
                self._record([Message(topic, time_ns, bytes(data))])

        return record

    def _check_time(self, topic: Topic, time_ns: int) -> None:
        """Refuse a time [ns] that the detector cannot have heard of.

        The detector may answer a block before the model's thread has noted that it is out: hence one block more.
        """
        block_ns = math.ceil(self.configuration.publishing.block_size * 1e9 / self.configuration.sensor.sampling_rate)
        latest = self._simulated_ns + block_ns
        if not 0 <= time_ns <= latest:
            raise Refusal(
                f"{topic.name} at {time_ns * 1e-9:g} s is not recorded: its stamp must be within 0 .. {latest * 1e-9:g} s of simulated time"
            )

    def _on_speed(self, data: bytes) -> None:
        from dcrb_ros.messages import decode_float

        with self._refusing("command/speed"):
            self._simulation.command_speed(_content("command/speed", decode_float, data))

    def _on_load(self, data: bytes) -> None:
        from dcrb_ros.messages import decode_wrench

        with self._refusing("command/load"):
            self._simulation.command_load(*_content("command/load", decode_wrench, data))

    @contextmanager
    def _refusing(self, kind: str) -> Iterator[None]:
        """Count a refusal, and log it once in a while."""
        try:
            yield
        except Refusal as refusal:
            self._refused[kind] = self._refused.get(kind, 0) + 1
            now = time.monotonic()
            if now - self._logged.get(kind, -REPEAT_REFUSAL) >= REPEAT_REFUSAL:
                self._logged[kind] = now
                self.node.get_logger().warning(str(refusal))

    def _on_parameters(self, parameters: Any) -> Any:
        from rcl_interfaces.msg import SetParametersResult

        try:
            self.configuration = changed(self.configuration, {parameter.name: parameter.value for parameter in parameters})
        except Refusal as refusal:
            return SetParametersResult(successful=False, reason=str(refusal))
        self._pacer.scale = self.configuration.time_scale
        return SetParametersResult(successful=True)

    def _report(self) -> None:
        """Publish the state of the bench on /diagnostics."""
        from dcrb_ros.messages import ERROR, OK, WARN, Status, encode_diagnostics

        now = time.monotonic()
        time_ns = self._simulated_ns
        simulated = time_ns * 1e-9
        self._factor = (simulated - self._reached) / (now - self._measured_at)
        self._reached, self._measured_at = simulated, now
        failed = self._recorder_state not in ("off", "recording")
        level = ERROR if failed else WARN if self._pacer.lag > 0.1 else OK
        values = {
            "time_scale": f"{self._pacer.scale:g}",
            "real_time_factor": f"{self._factor:.3f}",
            "simulated [s]": f"{simulated:.3f}",
            "lag [s]": f"{self._pacer.lag:.4f}",
            "late_blocks": str(self._pacer.late),
            "blocks": str(self._blocks),
            "rejected_commands": str(sum(count for kind, count in self._refused.items() if kind in COMMANDS)),
            "rejected_messages": str(sum(count for kind, count in self._refused.items() if kind not in COMMANDS)),
            "recorder": self._recorder_state,
            "energy_residual [J]": f"{self._residual:.4g}",
            "model": "failed" if self.failure else "running",
        }
        words = self._recorder_state if failed else "behind real time" if level == WARN else "running"
        status = Status(f"{self.node.get_fully_qualified_name()}", level, words, values)
        self._publisher.write_messages([Message(BENCH_DIAGNOSTICS, time_ns, encode_diagnostics(time_ns, [status]))])


def run(arguments: list[str]) -> int:
    """Run the node until its duration is over or a signal comes; return the exit status."""
    parser = argparse.ArgumentParser(prog="simulator", description="The simulated bearing as a ROS 2 node.")
    parser.add_argument("--duration", type=float, default=None, help="simulated time after which the node ends [s]")
    check_ros()
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import remove_ros_args, try_shutdown

    options = parser.parse_args(remove_ros_args(["simulator", *arguments])[1:])
    told = stop_on_signals()
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    node = create_node("simulator")
    try:
        simulator = Simulator(node, declare(node, Configuration, run_time=("time_scale",)), options.duration)
        try:
            simulator.start()
            spin(node, simulator.ended, told)
        finally:
            simulator.close()
        if simulator.failure is not None:
            node.get_logger().fatal(f"the bench stopped: {simulator.failure}")
            return 1
        return 0
    finally:
        node.destroy_node()
        try_shutdown()


def main() -> None:
    """Run the node as a program."""
    status = guarded("simulator", lambda: run(sys.argv[1:]))
    if any(thread.name == MODEL for thread in threading.enumerate()):
        # A compilation cannot be interrupted, and the interpreter must not be taken down under it.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    sys.exit(status)


if __name__ == "__main__":
    main()
