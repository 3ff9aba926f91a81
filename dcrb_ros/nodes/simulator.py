"""The simulator node: the model in a thread of its own behind a live accelerometer topic."""

from __future__ import annotations

import argparse
import math
import os
import sys
import threading
import time
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dcrb_ros.bearing.runtime_change import altered
from dcrb_ros.messages.topics import (
    BENCH_DIAGNOSTICS,
    CLOCK,
    DETECTED,
    SIMULATED,
    Message,
    Topic,
)
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.nodes.recording_switch import Tape, free_path
from dcrb_ros.nodes.refusals import Refusals
from dcrb_ros.nodes.report import COMMANDS, Progress, Report
from dcrb_ros.nodes.ros import declare, own_arguments, running, spin
from dcrb_ros.nodes.services import Services
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.runtime.prefetch import prefetch
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.runtime.simulated_time import checked_duration
from dcrb_ros.runtime.threads import NamedThread
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, parameter_fields
from dcrb_ros.simulation.events import TimedCommand, commands_in
from dcrb_ros.simulation.scenario import read_scenario_file, scheduled_changes, starting_configuration

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from dcrb_ros.nodes.clock import Sink
    from dcrb_ros.nodes.parameters import ObedientNode
    from dcrb_ros.recordings.recorder_thread import QueuedRecorder
    from dcrb_ros.simulation.block import Block
    from dcrb_ros.simulation.loop import Simulation

LAST_BLOCK = 0.7
"""Wall time that the model gets to end its block once told to stop [s]; compiling takes longer and is not waited for."""
MODEL = "model"
"""Name of the model's thread."""
TARGETS = {"operating.speed": COMMANDS[0], "operating.load": COMMANDS[1], "operating.lateral_load": COMMANDS[1]}
"""Parameters that have a topic of their own to change them."""
RUN_TIME = tuple(field.key for field in parameter_fields() if field.run_time and field.key not in TARGETS)
"""Parameters that can be set while the node runs."""


def _content(kind: str, decode: Callable[[bytes], Any], data: bytes) -> Any:
    """Return what a message holds; a refusal names the topic ``kind``."""
    try:
        return decode(bytes(data))
    except Refusal as refusal:
        raise Refusal(f"{kind}: {refusal}") from None


class Simulator:
    """The wires between the simulation's thread and ROS."""

    def __init__(
        self, node: ObedientNode, configuration: Configuration, duration: float | None, story: Mapping[str, Any] | None = None
    ) -> None:
        from dcrb_ros.messages.encoder import BlockEncoder
        from dcrb_ros.nodes.clock import ClockHand
        from dcrb_ros.nodes.publisher import Publisher

        self.node, self.configuration, self._duration, self._story = node, configuration, duration, story
        self._commands: list[TimedCommand] = []
        self.failure: Exception | None = None
        self._began = time.monotonic()
        self._pacer = Pacer(configuration.time_scale, time.monotonic)
        self.gate = Gate(self._pacer, time.monotonic)
        self.refusals = Refusals(node.get_logger().warning)
        self._simulation = self._start_model()
        self.progress = Progress()
        self.tape = Tape(node.get_logger().error)
        if configuration.recording.path:
            self._series = Path(configuration.recording.path)
            self._start_recording(self._series)
        self._encoder = BlockEncoder(configuration, self._simulation.bodies)
        topics = [topic for topic in SIMULATED if topic.enabled(configuration)]
        self._publisher: Sink = Publisher(node, [*topics, BENCH_DIAGNOSTICS, *([CLOCK] if configuration.publishing.clock else [])])
        self._clock = ClockHand(self._publisher, asked=configuration.publishing.clock)
        self._report = Report(self._pacer, self.gate, self.tape, self.refusals)
        self._subscribe()
        self._thread = NamedThread(MODEL, self._run)

    def _start_model(self) -> Simulation:
        from dcrb_ros.core import compiled

        if not compiled():
            self.node.get_logger().info("compiling the kernels (once, about half a minute) ...")
        from dcrb_ros.simulation.loop import Simulation

        return Simulation(self.configuration, scheduled_changes(self._story, self.configuration, "scenario") if self._story else ())

    def record_on(self, wanted: Path) -> Path:
        """Begin a recording, unless one runs, at ``wanted`` or the next free name after it; return its folder."""
        self._series = wanted
        return self._start_recording(free_path(wanted))

    def _start_recording(self, path: Path) -> Path:
        """Begin a recording with the next block, unless one runs; return the folder of the one that runs."""
        from dcrb_ros.recordings.recorder import Recorder
        from dcrb_ros.recordings.recorder_thread import QueuedRecorder

        def make() -> QueuedRecorder:
            recorder = Recorder(
                path,
                self.configuration,
                self._simulation.bodies,
                namespace=self.node.get_namespace(),
                scenario=self._story,
                commands=self._commands,
                start_ns=self.progress.simulated_ns,
            )
            return QueuedRecorder(recorder, self.configuration.recording.queue)

        return self.tape.start(make)

    def _subscribe(self) -> None:
        from geometry_msgs.msg import Wrench
        from rclpy.clock import Clock
        from rclpy.clock_type import ClockType
        from std_msgs.msg import Float64

        node = self.node
        # Raw, because the middleware's own decoder drops malformed bytes without a word.
        node.create_subscription(Float64, "command/speed", self._on_speed, 10, raw=True)
        node.create_subscription(Wrench, "command/load", self._on_load, 10, raw=True)
        for topic in DETECTED:
            if topic.recorded:
                self._listen(topic)
        Services(self)
        # Wall time, whatever use_sim_time says: the report must come while the simulated time stands.
        node.create_timer(1.0, self._publish_report, clock=Clock(clock_type=ClockType.STEADY_TIME))
        node.obey = self._on_parameters

    def _listen(self, topic: Topic) -> None:
        """Record a topic of the detector."""
        callback = self._on_detected(topic)
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
        self.gate.close()
        if self._thread.ident is not None:
            self._thread.join(LAST_BLOCK)
        self.tape.stop()

    def _run(self) -> None:
        try:
            while not self._play():
                if self.gate.closed:
                    return
                self._begin_anew()
        except Exception as error:  # the thread's end must reach the main thread, whatever it is
            self.failure = error

    def _play(self) -> bool:
        """Send the simulation's blocks; return false if they were cut short by a reset or the node's end."""
        with closing(prefetch(self._simulation.blocks(self._duration), self._hurried)) as blocks:
            for block in blocks:
                # Encoded before the wait: a block goes out at its deadline, and the first one's preparations do not count.
                messages = self._encoder.encode(block)
                if not self.gate.send(block.stamp_ns * 1e-9, block.end_ns * 1e-9, lambda b=block, m=messages: self._emit(b, m)):  # type: ignore[misc]
                    return False
        return True

    def _hurried(self) -> bool:
        """Return whether the next block is made while the last one is sent; at a time scale, commands would wait for a block more."""
        return self._pacer.scale == 0.0 and not self.gate.paused

    def _begin_anew(self) -> None:
        """Put the bearing, the simulated time and the scenario back to the start; a running recording goes on in the next folder."""
        from dcrb_ros.messages.encoder import BlockEncoder

        finished = self.tape.stop()
        self._simulation = self._start_model()
        self._encoder = BlockEncoder(self.configuration, self._simulation.bodies)
        self.progress.simulated_ns = self.progress.blocks = 0
        self._commands.clear()
        if finished is not None:
            try:
                path = self.record_on(self._series)
                self.node.get_logger().info(f"reset: {finished} is finished, {path} records from the start")
            except Refusal as refusal:
                self.tape.fail(f"no recording since the reset: {refusal}")
        self._publisher.write_messages(self._encoder.start())
        self.gate.begun_anew()

    def _emit(self, block: Block, messages: list[Message]) -> None:
        self.progress.simulated_ns = block.end_ns
        self._clock.tick(block.end_ns)
        self._publisher.write_messages(messages)
        self.tape.write_messages(messages)
        self._commands += commands_in(block.truths)
        self.progress.blocks += 1
        if block.energy is not None:
            self.progress.residual = block.energy.residual
        if self._began:
            self.node.get_logger().info(f"first block {time.monotonic() - self._began:.2f} s after the start")
            self._began = 0.0

    def _on_detected(self, topic: Topic) -> Callable[[bytes], None]:
        def record(data: bytes) -> None:
            if self.tape.path is None:
                return
            with self.refusals.of(topic.name):
                time_ns = _content(topic.name, topic.stamp, data)
                self._check_time(topic, time_ns)
                self.tape.write_messages([Message(topic, time_ns, bytes(data))])

        return record

    def _check_time(self, topic: Topic, time_ns: int) -> None:
        """Refuse a time [ns] that the detector cannot have heard of.

        The detector may answer a block before the model's thread has noted that it is out: hence one block more.
        """
        block_ns = math.ceil(self.configuration.publishing.block_size * 1e9 / self.configuration.sensor.sampling_rate)
        latest = self.progress.simulated_ns + block_ns
        if not 0 <= time_ns <= latest:
            raise Refusal(
                f"{topic.name} at {time_ns * 1e-9:g} s is not recorded: its stamp must be within 0 .. {latest * 1e-9:g} s of simulated time"
            )

    def _on_speed(self, data: bytes) -> None:
        from dcrb_ros.messages.plain import decode_float

        with self.refusals.of("command/speed"):
            self._simulation.command_speed(_content("command/speed", decode_float, data))

    def _on_load(self, data: bytes) -> None:
        from dcrb_ros.messages.plain import decode_wrench

        with self.refusals.of("command/load"):
            self._simulation.command_load(*_content("command/load", decode_wrench, data))

    def _on_parameters(self, changes: dict[str, Any]) -> None:
        """Carry out a change of parameters or refuse it, with the reason."""
        with self.refusals.counted("parameters"):
            for key in changes:
                if key in TARGETS:
                    raise Refusal(f"parameters: {key} changes by the topic {TARGETS[key]}; its parameter says what the bench began with")
            altered(self._simulation.configuration, changes)
            of_the_model = {key: value for key, value in changes.items() if key != "time_scale"}
            if of_the_model:
                self._simulation.change(of_the_model)
            if "time_scale" in changes:
                self.gate.rescale(changes["time_scale"])

    def show_parameters(self) -> None:
        """Let the node's parameters say how the bench is now, which a reset or a scenario may have changed."""
        from rclpy.parameter import Parameter

        if self._simulation.awaited:
            return
        present = flatten(self._simulation.configuration.model_dump())
        keys = [key for key in RUN_TIME if key != "time_scale" and self.node.get_parameter(key).value != present[key]]
        if keys:
            self.node.set_parameters([Parameter(key, value=present[key]) for key in keys])

    def _publish_report(self) -> None:
        """Publish the state of the bench on /diagnostics; the standing time of a paused bench is told again with it."""
        from dcrb_ros.messages.statuses import encode_diagnostics

        status = self._report.status(self.node.get_fully_qualified_name(), self.progress, failed=self.failure is not None)
        time_ns = self.progress.simulated_ns
        self._publisher.write_messages([Message(BENCH_DIAGNOSTICS, time_ns, encode_diagnostics(time_ns, [status]))])
        self._clock.tick(self.progress.simulated_ns, 0.0)
        self.show_parameters()


def run(arguments: list[str]) -> int:
    """Run the node until its duration is over or a signal comes; return the exit status."""
    parser = argparse.ArgumentParser(prog="simulator", description="The simulated bearing as a ROS 2 node.")
    parser.add_argument("--duration", type=float, default=None, help="simulated time after which the node ends [s]")
    parser.add_argument("--scenario", type=Path, default=None, help="timeline of speed, load, faults and sensor in simulated time (YAML)")
    options = own_arguments(parser, arguments)
    duration = None if options.duration is None else checked_duration(options.duration)
    with running("simulator", arguments) as (node, told):
        story = read_scenario_file(options.scenario) if options.scenario else None
        source = str(options.scenario)
        configuration = declare(node, Configuration, run_time=RUN_TIME, begun=lambda c: starting_configuration(story, c, source))
        if story is not None:
            scheduled_changes(story, configuration, str(options.scenario))
        if told.is_set():
            return 0
        simulator = Simulator(node, configuration, duration, story)
        try:
            simulator.start()
            spin(node, simulator.ended, told)
        finally:
            simulator.close()
        if simulator.failure is not None:
            node.get_logger().fatal(f"the bench stopped: {simulator.failure}")
            return 1
        return 0


def main() -> None:
    """Run the node as a program."""
    status = exit_status("simulator", lambda: run(sys.argv[1:]))
    if any(thread.name == MODEL for thread in threading.enumerate()):
        # A compilation cannot be interrupted, and the interpreter must not be taken down under it.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    sys.exit(status)


if __name__ == "__main__":
    main()
