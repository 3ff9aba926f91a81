"""The simulator node: a simulated bearing behind a live accelerometer topic."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.parameter import Parameter

from dcrb_ros.bearing.payload import body_names
from dcrb_ros.bearing.plausibility import implausible_notches
from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import DETECTED, LOAD_COMMAND, SENSOR, SIMULATED, SPEED_COMMAND, TRANSFORMS, VIBRATION, Message, Topic
from dcrb_ros.messages.topics.transforms import encode_transforms
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.parameters import changed_by_topic
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.ros import own_arguments, run_node
from dcrb_ros.nodes.simulating import SimulatingNode, decoded_by
from dcrb_ros.recordings.recorder import Recorder, check_topics
from dcrb_ros.runtime.prefetch import prefetch
from dcrb_ros.schema.parameter_field import wrong_type
from dcrb_ros.schema.simulated_time import checked_duration
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, parameter_fields
from dcrb_ros.settings.parameters import COMMANDED
from dcrb_ros.simulation.ground_truth import commands_in
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import ScheduledChange, scenario_of_run, scheduled_changes, starting_configuration

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
                messages = tuple(self._encoder.encode(block))
                yield Bundle(block.stamp_ns, block.end_ns, messages, block, tuple(commands_in(block.truths)))


class SimulatorNode(SimulatingNode):
    """Publishes and records the simulation; accepts commands, parameters and service calls."""

    _source: SimulationSource

    def __init__(self, duration: float | None = None, scenario: Path | None = None, parameters: Configuration | None = None) -> None:
        """Prepare ``duration`` of simulated time [s], endless without one, with a ``scenario`` if one is given.

        The ``parameters`` are by default those given to the node by ROS.

        Raises:
            Refusal: the parameters or the scenario are invalid.
        """
        super().__init__("simulator")
        tree, name = scenario_of_run(scenario, duration), str(scenario)
        configuration = self.declare(
            Configuration, run_time=RUN_TIME, adjust=lambda given: starting_configuration(tree, parameters or given, name)
        )
        check_topics(configuration, detector=True)  # also without a recording, as the service may start one later
        changes = scheduled_changes(tree, configuration, name) if scenario else []
        topics = [topic for topic in SIMULATED if topic.enabled(configuration)]
        begin, answers = partial(SimulationSource, configuration, changes, duration), self.follow_detector()
        recorder = partial(Recorder, configuration=configuration, bodies=body_names(configuration), scenario=tree)
        self.assemble(configuration, begin, topics, recorder, waveform=VIBRATION, description=SENSOR, answers=answers)

    def receive(self) -> None:
        """Subscribe to commands and to the detector, and publish the place of the sensor."""
        for topic in (SPEED_COMMAND, LOAD_COMMAND):
            self.subscribe(topic, partial(self._on_command, topic))
        for topic in DETECTED:
            if topic.recorded:
                self.record_detected(topic)
        # Latched, so that once is enough.
        Publisher(self, [TRANSFORMS]).write_messages([Message(TRANSFORMS, 0, encode_transforms(self.configuration))])

    def _on_command(self, topic: Topic, data: bytes) -> None:
        with self.refusals.suppressed(topic.name):
            self.refuse_untimely(topic.name)
            value, simulation = decoded_by(topic.name, topic.decoded, data), self._source.simulation
            simulation.command_speed(value) if topic is SPEED_COMMAND else simulation.command_load(*value)

    def check_parameter(self, key: str, value: Any) -> None:
        """Refuse a parameter that a command changes, unless its value has another type."""
        if key in COMMANDED and not wrong_type(self._fields[key], value):
            raise changed_by_topic(key, COMMANDED[key])

    def change(self, changes: Mapping[str, Any]) -> None:
        """Change parameters of the bearing, and say what is implausible about faults that were not so before."""
        simulation = self._source.simulation
        before, after = simulation.check_change({}), simulation.check_change(changes)
        for sentence in sorted({*implausible_notches(after)} - {*implausible_notches(before)}):
            self.get_logger().info(sentence)
        simulation.change(changes)

    def update_parameters(self) -> None:
        """Set the node's parameters to the present configuration, which a reset or a scenario may have changed."""
        if self._source.simulation.has_pending:
            return
        present = flatten(self._source.simulation.configuration.model_dump())
        keys = [key for key in RUN_TIME if key != "time_scale" and self.get_parameter(key).value != present[key]]
        if keys:
            self.set_parameters([Parameter(key, value=present[key]) for key in keys])


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
