"""The simulation of a vehicle: boxes are stepped side by side, mixed with each other and the track, and sensed, on one clock."""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.core.layout.state import TARGET_SPEED, TARGET_X, TARGET_Y, State
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Operating
from dcrb_ros.simulation.drive import Drive
from dcrb_ros.simulation.loop import MAX_PENDING, ModelFailure, Simulation
from dcrb_ros.stream.block import Block
from dcrb_ros.vehicle.changes import RANGES, VehicleChanges, checked_command, sorted_changes
from dcrb_ros.vehicle.description import Vehicle
from dcrb_ros.vehicle.file import vehicle_of
from dcrb_ros.vehicle.heat import VehicleHeat
from dcrb_ros.vehicle.model import FRAME, Plan, TrackEvent, VehicleModel
from dcrb_ros.vehicle.scenario import PREFIX, VehicleScenario, vehicle_scenario

MEASURED = ("acceleration", "clean", "clipped", "range", "preview", "preview_ns")
"""What a block has from its accelerometer, whose cable may be swapped with that of another box."""
SENSED = 2
"""Frames that are sensed together, in a fifth less time than one by one [-]."""
ROUNDING = 1.0 + 1e-9
"""Factor on a ramp, which must reach its target within the frame."""


class GuidedDrive(Drive):
    """Speed and load of a bearing in a vehicle, along straight lines from frame to frame."""

    def __init__(self, configuration: Configuration) -> None:
        super().__init__(configuration)
        self.fluctuates = True
        self._frame = FRAME / configuration.step_rate
        self._load_ramp = 0.0
        self.speed = configuration.operating.speed
        """Speed at the end of the frame [rad/s]."""
        self.load = np.array([configuration.operating.lateral_load, -configuration.operating.load])
        """Force on the inner ring in X and Y at the end of the frame [N]."""

    def fluctuate(self, payload: Payload, state: State, operating: Operating, step: int) -> tuple[Payload, int]:
        """Set the targets at the start of a frame; return the payload with the ramps to them, and the step of the next frame."""
        since = step % FRAME
        if since == 0:
            change = max(abs(self.load[0] - state.load[0]), abs(self.load[1] - state.load[1]))
            turn = abs(self.speed - state.target[TARGET_SPEED])
            state.target[TARGET_SPEED] = self.speed
            state.target[TARGET_X], state.target[TARGET_Y] = self.load
            self._load_ramp = float(ROUNDING * change / self._frame)
            payload = payload._replace(speed_ramp=ROUNDING * turn / self._frame, load_ramp=self._load_ramp)
        return payload, step - since + FRAME

    def with_ramps(self, payload: Payload, operating: Operating, present: float) -> Payload:
        """Return a payload with the ramps of the present frame."""
        return payload._replace(speed_ramp=present, load_ramp=self._load_ramp)


@dataclass(frozen=True)
class VehicleTruth:
    """What happened to a vehicle during a block."""

    time_ns: int
    """Simulated time at the start [ns]."""
    speed: float
    """Speed of the vehicle at the start of the last frame [m/s]."""
    place: float
    """Place of the middle of the bogie on the track at the start of the last frame [m]."""
    load: Mapping[str, float]
    """Load of each box at the end of the last frame, downwards [N]."""
    parts: Mapping[str, tuple[float, float, float]]
    """Acceleration of each box by its own bearing, the others, and track and wheels, rms of both axes [m/s^2]."""
    creep: Mapping[str, float]
    """Share by which each wheelset turned faster than it rolled at the start of the last frame; below zero in a slide [-]."""
    events: tuple[TrackEvent, ...]
    """Joints, crossings and flats that wheels met, and slides that began or ended."""
    silent: tuple[str, ...]
    """Boxes whose model failed."""
    commanded: Mapping[str, float] = field(default_factory=dict)
    """The commands in effect at the start of the block, by the names of `RANGES`."""
    commands: tuple[tuple[str, Any], ...] = ()
    """Those, and the changes of wheels and slides by their keys, that were given since the block before."""


@dataclass(frozen=True)
class VehicleBlock:
    """A block of every box, and the truth about the vehicle."""

    boxes: Mapping[str, Block]
    truth: VehicleTruth
    end_ns: int
    """Simulated time of its end [ns]."""


class _Stepping(NamedTuple):
    """A frame that the bearings are stepping."""

    plan: Plan
    futures: Mapping[str, Future[tuple[Floats, Floats]]]
    """Acceleration and angle of each box."""


class _Stepped(NamedTuple):
    """A frame that all bearings have stepped."""

    plan: Plan
    ring: Floats
    """Acceleration of the outer rings, shape (boxes, `FRAME`, 2) [m/s^2]."""
    angles: Mapping[str, Floats]
    """Angle of the shaft in each box that has not failed [rad]."""


class _Mixed(NamedTuple):
    """A frame with the motion of all boxes."""

    motion: Floats
    """Acceleration of the boxes, shape (boxes, `FRAME`, 2) [m/s^2]."""
    angles: Mapping[str, Floats]
    """Angle of the shaft in each box that has not failed [rad]."""


def simulation_of(parameters: Mapping[str, Any], source: str, tree: Any = None, scenario: str = "scenario") -> VehicleSimulation:
    """Return the simulation of a vehicle.

    Args:
        parameters: those of `dcrb_ros.vehicle.scenario.starting_parameters`.
        source: the vehicle's name in error messages.
        tree: a scenario as parsed from YAML; None for a run without changes.
        scenario: the scenario's name in error messages.

    Raises:
        Refusal: a parameter or a change of the scenario is invalid.
    """
    vehicle = vehicle_of(parameters, source)
    return VehicleSimulation(vehicle, None if tree is None else vehicle_scenario(tree, vehicle, scenario))


class VehicleSimulation:
    """Simulates the bearings of a vehicle and yields a block of each, with equal stamps.

    Every frame of `FRAME` steps has three phases. First the vehicle's model gives loads and speeds. Then each bearing is stepped, on its
    thread. Last, the motion of every box is mixed in a fixed order and sensed, while the bearings step the next frame. The samples depend
    on the vehicle and on the simulated times of commands only, not on threads or on the size of blocks.

    Examples
    --------
    >>> from dcrb_ros.vehicle.file import read_vehicle
    >>> from dcrb_ros.vehicle.simulation import VehicleSimulation
    >>> simulation = VehicleSimulation(read_vehicle("bogie"))
    >>> for block in simulation.blocks(0.1):
    ...     levels = {name: box.acceleration.std() for name, box in block.boxes.items()}
    """

    def __init__(self, vehicle: Vehicle, scenario: VehicleScenario | None = None, *, threads: int | None = None) -> None:
        """Set up the vehicle at simulated time 0.

        Parameters
        ----------
        vehicle
            The vehicle at the start of the scenario.
        scenario
            What changes during the run, see `dcrb_ros.vehicle.scenario.vehicle_scenario`.
        threads
            Threads that step the bearings; as many as the machine has processors by default. They change no sample.

        Raises
        ------
        Refusal
            A parameter of the vehicle is invalid.
        """
        self.vehicle = vehicle
        self._model = VehicleModel(vehicle)
        self.scenario = scenario or VehicleScenario({}, ())
        """What changes during the run."""
        self._wheels = {box.name: box.wheel for box in vehicle.boxes}
        self._commanded = {name: float(getattr(vehicle.journey, name)) for name in RANGES}
        self._scheduled = deque(self.scenario.settings)
        self._planned = 0
        self._upcoming = self._plan_next()
        self._drives = [GuidedDrive(box.configuration) for box in vehicle.boxes]
        self._heat = VehicleHeat(vehicle)
        self.simulations = {
            box.name: Simulation(
                box.configuration,
                self.scenario.boxes.get(box.name, ()),
                drive=drive,
                surroundings=self._heat.at_start(box, vehicle.journey.wind),
            )
            for box, drive in zip(vehicle.boxes, self._drives, strict=True)
        }
        """The simulation of each box."""
        self._threads = min(threads or os.cpu_count() or 1, len(vehicle.boxes))
        self._steps = self._samples = 0
        self._silent: dict[str, str] = {}
        self._pending: deque[tuple[str, Any]] = deque()
        self._lock = threading.Lock()
        self._plan: Plan
        self._parts: Floats

    @property
    def time_ns(self) -> int:
        """Simulated time reached by the blocks [ns]."""
        return round(self._samples * 1_000_000_000 / self.vehicle.boxes[0].configuration.sensor.sampling_rate)

    def command(self, **commands: float) -> None:
        """Command speed_kmh, curvature, cant, wind or brake from the third frame of the next block on; the speed follows a ramp.

        Any thread may call it.

        Raises
        ------
        Refusal
            A command is unknown or out of range; nothing is changed.
        """
        for name, value in commands.items():
            checked_command(name, value, end="; the previous command remains in effect")
        with self._lock:
            self._check_room()
            self._pending.extend((name, float(value)) for name, value in commands.items())

    def _apply_commands(self) -> tuple[tuple[str, Any], ...]:
        """Give the pending commands and changes to the model, and return them."""
        with self._lock:  # `worn` must find a change either pending or in effect
            commands = tuple(self._pending)
            self._pending.clear()
            for name, value in commands:
                self._give(name, value)
        return commands

    def _give(self, name: str, value: Any) -> None:
        """Give the model a command, the ramp of the speed, or a change of a wheel or a slide."""
        if name in RANGES:
            self._commanded[name] = value
        if name == "speed_kmh":
            self._model.targets["speed"] = value / 3.6
        elif name in self._model.targets:
            self._model.targets[name] = value
        else:
            self._apply(sorted_changes(self.vehicle, self._wheels, {name: value}))

    def change(self, changes: Mapping[str, Any]) -> None:
        """Change parameters of boxes from the next block on, such as ``{"axle_1.left.faults.outer_1.width": 0.002}``.

        Wheels (``axle_1.left.wheel.flat``) and slides (``axle_2.slide``, the share by which a wheelset turns slower than it rolls) change
        with the third frame of the next block.

        Raises
        ------
        Refusal
            A key names no box or wheelset, belongs to the vehicle or cannot change, or a box refuses the change; nothing is changed.
        """
        asked = sorted_changes(self.vehicle, self._wheels, changes)
        model = {key: value for key, value in changes.items() if sorted_changes(self.vehicle, self._wheels, {key: value}).of_model}
        with self._lock:
            if model:
                self._check_room()
            for name, changed in asked.boxes.items():
                self.simulations[name].check_change(changed)
            for name, changed in asked.boxes.items():
                self.simulations[name].change(changed)
            self._pending.extend(model.items())

    def _check_room(self) -> None:
        """Refuse requests to the model while too many are waiting."""
        if len(self._pending) >= MAX_PENDING:
            raise Refusal(f"{MAX_PENDING} commands are already waiting for the next block; send this one again once the bench runs")

    def _apply(self, changes: VehicleChanges) -> None:
        """Give the model changes of wheels and slides."""
        for name, wheel in changes.wheels.items():
            self._wheels[name] = wheel
            self._model.wear(self._names.index(name), wheel)
        for name, slide in changes.slides.items():
            self._model.slides[[axle.name for axle in self.vehicle.axles].index(name)] = slide

    def blocks(self, duration: float | None = None) -> Iterator[VehicleBlock]:
        """Yield blocks until ``duration`` [s] of samples is reached, endlessly without one.

        Raises
        ------
        Refusal
            The duration is not a finite number, or negative.
        ModelFailure
            The model of a box failed, and ``vehicle.on_failure`` is stop.
        """
        if duration is not None and finite_number("duration =", duration, "s") < 0.0:
            raise Refusal(f"duration = {duration:g} s is negative: give the simulated time that the blocks cover")
        first = self.vehicle.boxes[0].configuration
        rate, size = first.sensor.sampling_rate, first.publishing.block_size
        last = None if duration is None else self._samples + round(duration * rate)
        with ThreadPoolExecutor(self._threads) as pool:
            while last is None or self._samples < last:
                yield self._block(pool, size if last is None else min(size, last - self._samples))

    def _block(self, pool: ThreadPoolExecutor, size: int) -> VehicleBlock:
        began, events, parts = self.time_ns, list[TrackEvent](), list[Floats]()
        commands = self._apply_commands()
        for simulation in self._running.values():
            simulation.prepare(size)
        end = max(simulation.steps_of(size) for simulation in self._running.values())
        # While one frame is mixed and sensed, the bearings step the next one of the block.
        stepping = self._begin_frame(pool) if self._steps < end else None
        mixed: list[_Mixed] = []
        while stepping is not None:
            stepped = self._collected(stepping)
            stepping = self._begin_frame(pool) if self._steps < end else None
            self._plan = stepped.plan
            events += stepped.plan.events
            motion, levels = self._model.mix(stepped.ring, stepped.plan)
            parts.append(levels)
            mixed.append(_Mixed(motion, stepped.angles))
            if len(mixed) == SENSED or stepping is None:
                self._sense(mixed)
                mixed = []
        if parts:  # a short block may lie within the last frame
            self._parts = np.sqrt(np.mean(np.square(parts), axis=0))
        present, level = self._plan, self._parts
        boxes = self._connected({name: simulation.cut(size) for name, simulation in self._running.items()})
        self._samples += size
        names = [box.name for box in self.vehicle.boxes]
        truth = VehicleTruth(
            began,
            present.speed,
            present.place,
            {name: -float(present.load[j, 1]) for j, name in enumerate(names)},
            {name: (float(level[j, 0]), float(level[j, 1]), float(level[j, 2])) for j, name in enumerate(names)},
            {axle.name: float(present.creep[p]) for p, axle in enumerate(self.vehicle.axles)},
            tuple(events),
            tuple(self._silent),
            dict(self._commanded),
            commands,
        )
        return VehicleBlock(boxes, truth, self.time_ns)

    def _connected(self, boxes: Mapping[str, Block]) -> dict[str, Block]:
        """Return the blocks with the waveforms of swapped accelerometers; a box that is swapped with a silent one is silent, too.

        Raises:
            ModelFailure: no box is left.
        """
        connected = {}
        for box in self.vehicle.boxes:
            if box.name not in boxes or (box.swapped_with and box.swapped_with not in boxes):
                continue
            block, other = boxes[box.name], boxes[box.swapped_with or box.name]
            connected[box.name] = replace(block, **{name: getattr(other, name) for name in MEASURED})
        if not connected:
            raise ModelFailure(f"every box has failed, or is swapped with one that has: {'; '.join(self._silent.values())}")
        return connected

    def worn(self) -> dict[str, Any]:
        """Return the parameters of wheels and the slides by their keys, as `change` takes them; those that are pending are left out."""
        with self._lock:
            pending = {key for key, _ in self._pending}
            wheels = {f"{name}.wheel.{key}": value for name, wheel in self._wheels.items() for key, value in wheel.model_dump().items()}
            slides = {f"{axle.name}.slide": float(self._model.slides[p]) for p, axle in enumerate(self.vehicle.axles)}
        return {key: value for key, value in (wheels | slides).items() if key not in pending}

    @property
    def silent(self) -> Mapping[str, str]:
        """Boxes whose model failed, and why."""
        return dict(self._silent)

    @property
    def _running(self) -> dict[str, Simulation]:
        """Boxes whose model has not failed."""
        running = {name: simulation for name, simulation in self.simulations.items() if name not in self._silent}
        if not running:
            raise ModelFailure(f"the models of all boxes failed: {'; '.join(self._silent.values())}")
        return running

    def _begin_frame(self, pool: ThreadPoolExecutor) -> _Stepping:
        """Let the bearings step the planned frame, and plan the next one meanwhile."""
        plan = self._upcoming
        around = self._heat.surroundings(plan.speed, self._commanded["wind"], self._commanded["brake"], self.simulations)
        for name, surroundings in around.items():
            self.simulations[name].surround(surroundings)
        for box, drive, load in zip(self.vehicle.boxes, self._drives, plan.load, strict=True):
            drive.speed, drive.load = float(plan.shaft_speed[box.axle]), load
        self._steps += FRAME
        futures = {name: pool.submit(simulation.step_to, self._steps) for name, simulation in self._running.items()}
        self._upcoming = self._plan_next()
        return _Stepping(plan, futures)

    def _plan_next(self) -> Plan:
        """Return the plan of the next frame; the scenario's settings of that frame act from its end on."""
        while self._scheduled and self._scheduled[0].frame <= self._planned:
            setting = self._scheduled.popleft()
            self._give(setting.key.removeprefix(PREFIX), setting.value)
        self._planned += 1
        return self._model.plan()

    def _collected(self, stepping: _Stepping) -> _Stepped:
        """Wait until all bearings have stepped their frame, and return their motion.

        Raises:
            ModelFailure: the model of a box failed, and ``vehicle.on_failure`` is stop.
        """
        ring, angles = np.zeros((len(self.vehicle.boxes), FRAME, 2)), {}
        for j, name in enumerate(self._names):
            if name not in stepping.futures:
                continue
            try:
                ring[j], angles[name] = stepping.futures[name].result()
            except ModelFailure as failure:
                if self.vehicle.journey.on_failure == "stop":
                    raise ModelFailure(f"{name}: {failure}") from None
                self._silent[name] = f"{name}: {failure}"
        return _Stepped(stepping.plan, ring, angles)

    def _sense(self, frames: Sequence[_Mixed]) -> None:
        """Measure some consecutive frames in every box that has not failed in them."""
        for j, name in enumerate(self._names):
            present = [frame for frame in frames if name in frame.angles]
            if present:
                motion, angle = ([frame.motion[j] for frame in present], [frame.angles[name] for frame in present])
                self.simulations[name].sense(np.concatenate(motion), np.concatenate(angle))

    @property
    def _names(self) -> list[str]:
        return [box.name for box in self.vehicle.boxes]
