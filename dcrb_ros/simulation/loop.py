"""The simulation loop: step the model, sample the sensor, yield blocks. No ROS, no files."""

from __future__ import annotations

import copy
import dataclasses
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from dcrb_ros.bearing.axle_heat import ALONE, BoxTemperatures, Surroundings
from dcrb_ros.bearing.energy import account, stored_energy
from dcrb_ros.bearing.observation import observe
from dcrb_ros.bearing.payload import body_names, build_payload, initial_state
from dcrb_ros.bearing.runtime_change import altered, refitted
from dcrb_ros.core.compilation import compile_ahead
from dcrb_ros.core.layout.state import copy_of
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.measurement.sensor import Sensor
from dcrb_ros.schema.arguments import keyed, of_type, optional
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.simulated_time import nanoseconds, next_tick
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import COMMANDED
from dcrb_ros.simulation.block_queue import BlockQueue
from dcrb_ros.simulation.drive import Drive, commanded
from dcrb_ros.simulation.failure import check_domain
from dcrb_ros.simulation.heating import Heating
from dcrb_ros.simulation.pending import PendingCommands
from dcrb_ros.simulation.present_truth import PresentTruth
from dcrb_ros.simulation.scenario import ScheduledChange, checked_changes
from dcrb_ros.simulation.toothed_wheel import toothed_wheel_of
from dcrb_ros.simulation.transmission import Transmission
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.events import BlockLost, Command, Event, LoadCommand, ParameterChange, Refused, ScenarioEvent, SpeedCommand, Start
from dcrb_ros.stream.states import Account, BodyNames, States


class Simulation:
    """Simulates a bearing from its steady state and yields blocks of samples.

    Commands and changes may be given from any thread. They take effect at the first step of the next block, and the ground truth contains
    them with that time. The changes of a scenario take effect at their own steps, independent of the blocks.
    The samples depend only on the configuration, the scenario and the simulated times of the commands.

    Examples
    --------
    >>> import dcrb_ros
    >>> simulation = dcrb_ros.Simulation(dcrb_ros.load_configuration("healthy"))
    >>> for block in simulation.blocks(0.05):
    ...     rms = block.acceleration.std(axis=0)  # in X and Y [m/s^2]
    >>> simulation.command_speed(150.0)  # takes effect at the next block
    >>> next(simulation.blocks())
    <Block: 1024 samples at 51.2 kHz from 0.0500 s, 2 states>
    """

    def __init__(
        self,
        configuration: Configuration,
        scenario: Iterable[ScheduledChange] = (),
        *,
        waveform_only: bool = False,
        drive: Drive | None = None,
        surroundings: Surroundings = ALONE,
    ) -> None:
        """Set up the bearing at simulated time 0.

        Parameters
        ----------
        configuration
            The bench.
        scenario
            Changes in the order of time, see `dcrb_ros.simulation.scenario`.
        waveform_only
            Leave out states, preview and energy; samples and ground truth are the same.
        drive
            Drive and load of the shaft; those of the configuration by default.
        surroundings
            Heat that a vehicle adds to the box, and its cooling, at the start.

        Raises
        ------
        Refusal
            The configuration or the scenario is of another type.
        """
        if not isinstance(configuration, Configuration):
            raise Refusal(f"{configuration!r} is not a Configuration: give dcrb_ros.load_configuration('healthy') or another one")
        of_type(bool)("waveform_only", waveform_only)
        optional(of_type(Drive))("drive", drive)
        of_type(Surroundings)("surroundings", surroundings)
        self._waveform_only = waveform_only
        self.configuration = configuration
        """The present configuration, with the changes that have taken effect, but not the commands of speed and load."""
        self._scheduled = deque(checked_changes(scenario))
        self._truth = PresentTruth(configuration)
        self.bodies: BodyNames = body_names(configuration)
        self._heating = Heating(configuration, surroundings)
        self._assembled = configuration.operating
        self._payload = self._heating.begin(configuration, build_payload(configuration))
        self._state = initial_state(configuration, self._payload)
        self._work = workspace(self._payload)
        self._stored = stored_energy(self._payload, self._state)
        self._drive = drive or Drive(configuration)
        self._sensor = Sensor(configuration.measurement)
        self._tacho = toothed_wheel_of(configuration)
        self._transmission = Transmission(configuration)
        self._lost = False
        self._steps = 0
        self._observed: States | None = None
        self._pending = PendingCommands()
        self._queue = BlockQueue(configuration.sensor.sampling_rate, configuration.publishing.preview_rate, preview=not waveform_only)
        self._read_temperatures()
        self._note(Start())

    @property
    def time_ns(self) -> int:
        """Simulated time reached by the model [ns]; the next command takes effect here."""
        return nanoseconds(self._steps, self.configuration.step_rate)

    @property
    def temperatures(self) -> BoxTemperatures | None:
        """Temperatures of the bearing and its box; None without a thermal network."""
        return self._heating.box

    @property
    def energy(self) -> Account:
        """The energy account up to `time_ns`; valid between two blocks."""
        return account(self._payload, self._state, self._stored)

    def command_speed(self, speed: float) -> None:
        """Set the target speed [rad/s], approached with the configured ramp from the next block on.

        Raises
        ------
        Refusal
            The speed is out of range, or too many commands are pending.
        """
        topic = COMMANDED["operating.speed"]
        value = commanded(topic, "speed", speed, "rad/s")
        altered(self.configuration, {"operating.speed": value}, topic)
        self._pending.add(SpeedCommand(value))

    def command_load(self, x: float, y: float) -> None:
        """Set the target force on the inner ring in X and Y [N], approached with the configured ramp from the next block on.

        Raises
        ------
        Refusal
            The force is out of range or too large for the bearing, or too many commands are pending.
        """
        topic = COMMANDED["operating.load"]
        force = commanded(f"{topic} force.x", "lateral_load", x, "N"), commanded(f"{topic} force.y", "load", y, "N")
        altered(self.configuration, {"operating.lateral_load": force[0], "operating.load": -force[1]}, topic)
        self._pending.add(LoadCommand(*force))

    def change(self, changes: Mapping[str, Any]) -> None:
        """Change parameters from the next block on: dotted keys and values, such as ``{"faults.outer_1.width": 0.002}``.

        Raises
        ------
        Refusal
            A parameter is unknown or fixed, a value is invalid, or the values contradict each other; nothing is changed.
        """
        # The ground truth contains the values as Python prints them.
        changes = {key: value.item() if isinstance(value, np.generic) else value for key, value in keyed("changes", changes).items()}
        if changes:
            self._pending.add_change(changes, self._altered)

    def check_change(self, changes: Mapping[str, Any]) -> Configuration:
        """Check a change as `change` does, and change nothing.

        Returns
        -------
        Configuration
            The configuration after the pending changes and this one.

        Raises
        ------
        Refusal
            `change` would refuse it.
        """
        return self._pending.check_change(keyed("changes", changes), self._altered)

    def _altered(self, changes: Mapping[str, Any], configuration: Configuration | None = None) -> Configuration:
        """Return a configuration, by default the present one, with some changes, or refuse them."""
        return altered(configuration or self.configuration, changes)

    def fork(self) -> Simulation:
        """Return an independent copy that continues from the present state; without further commands both yield the same samples.

        Raises
        ------
        ValueError
            Commands or changes are pending.
        """
        with self._pending.lock:
            if self._pending.commands:
                raise ValueError(f"{len(self._pending.commands)} commands wait for the next block; fork after it")
            # Constants are shared; the views in the state and the lock cannot be copied like the rest.
            copies = (self._state, copy_of(self._state)), (self._work, workspace(self._payload)), (self._pending, PendingCommands())
            shared = (self._payload, self._payload), (self.configuration, self.configuration)
            return copy.deepcopy(self, {id(part): other for part, other in (*copies, *shared)})

    @property
    def has_pending(self) -> bool:
        """Whether commands or changes are pending; while they are being applied, the call waits."""
        with self._pending.lock:
            return bool(self._pending.commands)

    def blocks(self, duration: float | None = None) -> Iterator[Block]:
        """Yield blocks until ``duration`` [s] of samples is reached, endlessly without one.

        The last block may be shorter, so that the duration is exact.

        Raises
        ------
        Refusal
            The duration is not a finite number, or negative.
        """
        if duration is not None and finite_number("duration =", duration, "s") < 0.0:
            raise Refusal(f"duration = {duration:g} s is negative: give the simulated time that the blocks cover")
        return self._blocks(duration)

    def _blocks(self, duration: float | None) -> Iterator[Block]:
        rate, size = self.configuration.sensor.sampling_rate, self.configuration.publishing.block_size
        last = None if duration is None else self._queue.samples + round(duration * rate)
        while last is None or self._queue.samples < last:
            samples = size if last is None else min(size, last - self._queue.samples)
            self.prepare(samples)
            self.sense(*self.step_to(self.steps_of(samples)))
            yield self.cut(samples)

    def surround(self, surroundings: Surroundings) -> None:
        """Heat and cool the box as a vehicle does, from the next step of the thermal network on; not while `step_to` runs."""
        self._heating.surroundings = surroundings

    def prepare(self, size: int) -> None:
        """Begin a block of ``size`` samples: compile the kernels before the first one, and apply the pending commands."""
        first = self._queue.samples
        if first == 0:
            compile_ahead(self._payload, self._state, self._work)
        self._pending.apply(self._apply)
        self._lost = self._transmission.next_is_lost()
        if self._lost:
            self._note(BlockLost(first, first + size - 1))

    def steps_of(self, size: int) -> int:
        """Return the step to which the model must advance for the next ``size`` samples."""
        return self._sensor.steps(self._queue.samples + size)

    def cut(self, size: int) -> Block:
        """Return the next ``size`` samples, which have been sensed, as the block that `prepare` began."""
        unpublished = self._lost or self._transmission.between_bursts(self._queue.samples)
        block = self._queue.cut(size, lost=unpublished, sensor_range=self.configuration.sensor.range)
        return dataclasses.replace(block, energy=self.energy) if block.truths and not self._waveform_only else block

    def _apply(self, command: Command) -> None:
        """Apply a command and note it."""
        event: Event = command
        match command:
            case SpeedCommand(speed):
                self._drive.command_speed(self._state, speed)
            case LoadCommand(x, y):
                self._drive.command_load(self._state, x, y)
            case ParameterChange(changes):
                event = self._alter(changes, command)
        self._note(event)

    def _apply_scheduled(self) -> None:
        """Apply the scenario's changes of this step."""
        while self._scheduled and self._scheduled[0].step <= self._steps:
            scheduled = self._scheduled.popleft()
            with self._pending.lock:
                event = self._alter(scheduled.changes, scheduled.event or ScenarioEvent(scheduled.changes))
                self._pending.rebase(self._altered)
            if scheduled.event is not None or isinstance(event, Refused):
                self._note(event)

    def _alter(self, changes: Mapping[str, Any], request: ParameterChange | ScenarioEvent) -> Event:
        """Apply changes of parameters from this step on; return the request, or its refusal."""
        try:
            after = self._altered(changes)
        except Refusal as refusal:  # it conflicts with a change that came in between
            return Refused(request, str(refusal))
        before, self.configuration, present = self.configuration, after, self._payload.speed_ramp
        if after.faults.damaging != before.faults.damaging:
            self._payload = self._heating.refit(after, refitted(after, self._assembled, self._payload, self._state), self._state)
            self._work = workspace(self._payload)
        self._truth.change(after, self._steps / after.step_rate)
        self._payload = self._drive.with_ramps(self._payload, after.operating, present)
        if after.measurement.parameters != before.measurement.parameters:
            self._sensor.change(after.measurement.parameters, -(-self._steps // after.steps_per_sample))
        self._drive.command_changed(self._state, after.operating, changes)
        return request

    def step_to(self, end: int) -> tuple[Floats, Floats]:
        """Step the model to step ``end``, stopping at every time of a state, a truth or a scheduled change.

        Returns
        -------
        acceleration, angle
            Acceleration of the outer ring, means over each step, shape (steps, 2) [m/s^2], and the angle of the shaft at the start of
            each, shape (steps,) [rad].
        """
        motion: list[tuple[Floats, Floats]] = [(np.empty((0, 2)), np.empty(0))]
        while self._steps < end:
            self._apply_scheduled()
            publishing, rate = self.configuration.publishing, self.configuration.step_rate
            state_due = end if self._waveform_only else next_tick(self._steps, publishing.state_rate, rate)
            truth_due = next_tick(self._steps, publishing.truth_rate, rate)
            change_due = self._scheduled[0].step if self._scheduled else end
            value_due = end
            if self._drive.fluctuates:
                self._payload, value_due = self._drive.fluctuate(self._payload, self._state, self.configuration.operating, self._steps)
            heat_due = self._heating.next(self._steps) if self._heating.active(self.configuration) else -1
            count = min(end, state_due, truth_due, change_due, value_due, heat_due if heat_due > 0 else end) - self._steps
            acceleration, angles = np.empty((count, 2)), np.empty(count)
            advance(self._payload, self._state, self._work, acceleration, angles)
            self._steps += count
            check_domain(self.time_ns, acceleration, self._state, self._payload.roller_radius)
            motion.append((acceleration, angles))
            if self._steps == heat_due:
                self._heat()
            if self._steps == state_due and not self._waveform_only:
                self._observed = observe(self._payload, self._state, self.time_ns, self._observed, self._heating.present)
                self._queue.states.append(self._observed)
            if self._steps == truth_due:
                self._note(None)
        accelerations, shaft = zip(*motion, strict=True)
        return np.concatenate(accelerations), np.concatenate(shaft)

    def sense(self, acceleration: Floats, angle: Floats) -> None:
        """Measure the acceleration at the sensor's place over the steps that `step_to` returned, and the angle of the shaft."""
        if not len(angle):
            return
        self._queue.measured.append(self._sensor.measure(acceleration, angle))
        if self._tacho is not None:
            self._queue.add_pulses(self._tacho.pulses(angle))

    def _heat(self) -> None:
        """Step heat and lubricant, and fit the bearing to them."""
        self._payload, work = self._heating.update(self.configuration, self._payload, self._state, self._steps)
        self._stored += work
        self._read_temperatures()

    def _read_temperatures(self) -> None:
        """Append a reading of the temperature sensors where one is due."""
        reading = self._heating.reading(self.configuration, self._steps, self.time_ns)
        if reading is not None:
            self._queue.temperatures.append(reading)

    def _note(self, event: Event | None) -> None:
        """Append the ground truth of this instant."""
        self._queue.truths.append(self._truth.at(self.time_ns, self._state, self._heating.truth(self.configuration), event))
