"""The simulator node: a simulated bearing behind a live accelerometer topic."""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from rclpy.parameter import Parameter

from dcrb_ros.bearing.payload import body_names
from dcrb_ros.bearing.plausibility import whole_length
from dcrb_ros.bearing.runtime_change import altered
from dcrb_ros.core.announcement import announce_compilation
from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import (
    BENCH_DIAGNOSTICS,
    CLOCK,
    DETECTED,
    LOAD_COMMAND,
    SIMULATED,
    SPEED_COMMAND,
    VIBRATION,
    Message,
    Topic,
)
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.bench_status import BenchStatus
from dcrb_ros.nodes.clock import ClockPublisher
from dcrb_ros.nodes.engine import Engine, Progress, Sink
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.recording_switch import RecordingSwitch
from dcrb_ros.nodes.refusals import Refusals
from dcrb_ros.nodes.ros import installed, own_arguments, run_node
from dcrb_ros.nodes.services import Services
from dcrb_ros.nodes.simulation_interfaces import PACKAGE, SimulationInterfaces
from dcrb_ros.nodes.transforms import publish_transforms
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.recorder_thread import RecorderThread
from dcrb_ros.runtime.prefetch import prefetch
from dcrb_ros.schema.parameter_field import wrong_type
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.simulated_time import checked_duration
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, parameter_fields
from dcrb_ros.settings.parameters import COMMANDED
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import ScheduledChange, read_scenario_file, scheduled_changes, starting_configuration
from dcrb_ros.stream.events import TimedCommand

RUN_TIME = tuple(field.key for field in parameter_fields() if field.run_time and field.key not in COMMANDED)
"""Parameters that can be set while the node runs."""


class SimulationSource:
    """A simulation as a source of bundles."""

    def __init__(self, configuration: Configuration, scenario: Sequence[ScheduledChange], duration: float | None, gate: Gate) -> None:
        self._configuration, self._scenario, self._duration, self._gate = configuration, scenario, duration, gate

    def start(self) -> list[Message]:
        """Set up the bearing at simulated time 0."""
        self.simulation = Simulation(self._configuration, self._scenario)
        self._encoder = BlockEncoder(self._configuration, self.simulation.bodies)
        return self._encoder.start()

    def bundles(self) -> Generator[Bundle, None, None]:
        """Yield a bundle for each block."""
        # A block is prefetched only if it is not paced: otherwise commands would take effect one block later.
        with closing(prefetch(self.simulation.blocks(self._duration), lambda: self._gate.open)) as blocks:
            for block in blocks:
                # Encoded before the deadline, so that the bundle is sent at it.
                yield Bundle(block.stamp_ns, block.end_ns, tuple(self._encoder.encode(block)), block)


class FirstBlockLog:
    """A sink that logs how long the first block took."""

    def __init__(self, log: Callable[[str], object]) -> None:
        self._log, self._began = log, time.monotonic()

    def start(self, messages: Sequence[Message]) -> None:
        """Do nothing."""

    def write(self, bundle: Bundle) -> None:
        """Log the time of the first bundle."""
        if self._began:
            self._log(f"first block {time.monotonic() - self._began:.2f} s after the start")
            self._began = 0.0


class SimulatorNode(BenchNode):
    """Publishes and records the simulation; accepts commands, parameters and service calls."""

    purpose = "bench"

    def __init__(self, duration: float | None = None, scenario: Path | None = None, parameters: Configuration | None = None) -> None:
        """Prepare ``duration`` of simulated time [s], endless without one, with a ``scenario`` if one is given.

        The ``parameters`` are by default those given to the node by ROS.

        Raises:
            Refusal: the parameters or the scenario are invalid.
        """
        super().__init__("simulator")
        self._scenario, name = (read_scenario_file(scenario) if scenario else None), str(scenario)
        self.configuration = self.declare(
            Configuration, run_time=RUN_TIME, adjust=lambda given: starting_configuration(self._scenario, parameters or given, name)
        )
        changes = scheduled_changes(self._scenario, self.configuration, name) if scenario else []
        publishing, log = self.configuration.publishing, self.get_logger()
        gate = Gate(Pacer(self.configuration.time_scale, time.monotonic), time.monotonic)
        topics = [topic for topic in SIMULATED if topic.enabled(self.configuration)]
        self._publisher = Publisher(self, [*topics, BENCH_DIAGNOSTICS, *([CLOCK] if publishing.clock else [])])
        self._clock_publisher = ClockPublisher(self._publisher.write_messages) if publishing.clock else None
        self.progress, self.refusals = Progress(), Refusals(log.warning)
        path = self.configuration.recording.path
        self.recording = RecordingSwitch(self._recorder, log, Path(path).absolute() if path else None)
        clock = [self._clock_publisher] if self._clock_publisher else []
        sinks: list[Sink] = [self.progress, *clock, self._publisher, self.recording, FirstBlockLog(log.info)]
        self._source = SimulationSource(self.configuration, changes, duration, gate)
        self.engine = Engine("model", self._source, sinks, gate)
        self._answers = self.follow_detector()
        self._status = BenchStatus(self.engine, self.progress, self.recording, self.refusals)

    def start(self) -> None:
        """Start the simulation and the configured recording."""
        announce_compilation(self.get_logger().info)
        self.engine.prepare()
        self.subscribe(SPEED_COMMAND, self._on_speed)
        self.subscribe(LOAD_COMMAND, self._on_load)
        for topic in DETECTED:
            if topic.recorded:
                self._record_detected(topic)
        publish_transforms(self, self.configuration)
        services = Services(self)
        if installed(PACKAGE):
            SimulationInterfaces(self, services)
        self._others = self.watch_publishers(VIBRATION, *([CLOCK] if self.configuration.publishing.clock else []))
        self.repeat(1.0, self._publish_status)
        publishing = self.configuration.publishing
        if publishing.listeners:
            self.start_with_subscribers(self._publisher, publishing.listeners, publishing.wait, self.engine.start)
        else:
            self.engine.start()

    @property
    def ended(self) -> bool:
        """Whether the duration is over and the detector has answered, or the simulation has failed or was asked to quit."""
        stopped = self.engine.failure is not None or self.engine.gate.closed
        return self.engine.ended and (stopped or self._answers.complete(self.progress.time_ns))

    @property
    def failure(self) -> Exception | None:
        """The exception that ended the simulation, if one did."""
        return self.engine.failure

    def close(self) -> None:
        """Stop the simulation and finish the recording."""
        self.engine.close()
        self.recording.stop()

    def _recorder(self, path: Path, *, commands: Sequence[TimedCommand], start_ns: int) -> RecorderThread:
        configuration = self.configuration
        recorder = Recorder(
            path,
            configuration,
            body_names(configuration),
            namespace=self.get_namespace(),
            scenario=self._scenario,
            commands=commands,
            start_ns=start_ns,
        )
        return RecorderThread(recorder, configuration.recording.queue)

    def _record_detected(self, topic: Topic) -> None:
        """Record the detector's messages on a topic."""

        def record(data: bytes) -> None:
            if self.recording.path is None:
                return
            with self.refusals.suppressed(topic.name):
                time_ns = _decoded(topic.name, topic.stamp, data)
                self._check_stamp(topic, time_ns)
                self.recording.write_messages([Message(topic, time_ns, data)])

        self.subscribe(topic, record)

    def _check_stamp(self, topic: Topic, time_ns: int) -> None:
        """Refuse a stamp [ns] outside the signal published so far.

        The detector may answer a block before the engine's thread has counted it, hence one block of tolerance.
        """
        block_ns = math.ceil(self.configuration.publishing.block_size * 1e9 / self.configuration.sensor.sampling_rate)
        latest = self.progress.time_ns + block_ns
        if not 0 <= time_ns <= latest:
            raise Refusal(
                f"{topic.name} at {time_ns * 1e-9:g} s is not recorded: its stamp must be within 0 .. {latest * 1e-9:g} s of simulated time"
            )

    def _on_speed(self, data: bytes) -> None:
        with self.refusals.suppressed(SPEED_COMMAND.name):
            self._source.simulation.command_speed(_decoded(SPEED_COMMAND.name, SPEED_COMMAND.decoded, data))

    def _on_load(self, data: bytes) -> None:
        with self.refusals.suppressed(LOAD_COMMAND.name):
            self._source.simulation.command_load(*_decoded(LOAD_COMMAND.name, LOAD_COMMAND.decoded, data))

    def on_parameters(self, changes: dict[str, Any]) -> None:
        """Apply a requested change of parameters, or refuse it."""
        with self.refusals.counted("parameters"):
            for key in changes:
                if key in COMMANDED and not wrong_type(self._fields[key], changes[key]):
                    raise Refusal(f"parameters: {key} changes by the topic {COMMANDED[key]}; the parameter is its value at the start")
            after = altered(self._source.simulation.configuration, changes)
            for sentence in sorted({*whole_length(after)} - {*whole_length(self._source.simulation.configuration)}):
                self.get_logger().info(sentence)
            self._source.simulation.change({key: value for key, value in changes.items() if key != "time_scale"})
            if "time_scale" in changes:
                self.engine.gate.rescale(changes["time_scale"])

    def update_parameters(self) -> None:
        """Set the node's parameters to the present configuration, which a reset or a scenario may have changed."""
        if self._source.simulation.has_pending:
            return
        present = flatten(self._source.simulation.configuration.model_dump())
        keys = [key for key in RUN_TIME if key != "time_scale" and self.get_parameter(key).value != present[key]]
        if keys:
            self.set_parameters([Parameter(key, value=present[key]) for key in keys])

    def _publish_status(self) -> None:
        """Publish the status on /diagnostics, and the time of a paused simulation again on /clock."""
        time_ns = self.progress.time_ns  # read once: another block may come at any time
        status = self._status.status(self.get_fully_qualified_name(), time_ns, self._others.names)
        self._publisher.write_messages([self.diagnostics(status, time_ns, self.configuration.publishing.frame)])
        if self._clock_publisher is not None:
            self._clock_publisher.repeat(time_ns)
        self.update_parameters()


def _decoded(topic: str, decode: Callable[[bytes], Any], data: bytes) -> Any:
    """Return the content of a message; a refusal names the topic."""
    try:
        return decode(bytes(data))
    except Refusal as refusal:
        raise Refusal(f"{topic}: {refusal}") from None


def run(arguments: list[str], parameters: Configuration | None = None) -> int:
    """Run the node until its duration is over or a termination signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog="simulator", description="The simulated bearing as a ROS 2 node.")
    parser.add_argument("--duration", type=float, default=None, help="simulated time after which the node ends [s]")
    parser.add_argument("--scenario", type=Path, default=None, help="timeline of speed, load, faults and sensor in simulated time (YAML)")
    options = own_arguments(parser, arguments)
    duration = None if options.duration is None else checked_duration(options.duration)
    return run_node(lambda: SimulatorNode(duration, options.scenario, parameters), arguments)


if __name__ == "__main__":
    main("simulator", sys.argv[1:])
