"""The simulation of a vehicle: boxes are stepped side by side, mixed with each other and the track, and sensed, on one clock."""

from __future__ import annotations

import itertools
import os
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.schema.arguments import of_type, optional
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import changed
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Block
from dcrb_ros.vehicle.block import VehicleBlock, VehicleTruth
from dcrb_ros.vehicle.description import Box, Vehicle
from dcrb_ros.vehicle.file import vehicle_of
from dcrb_ros.vehicle.frame import FRAME, Plan, TrackEvent
from dcrb_ros.vehicle.guided_drive import GuidedDrive, GuidedSimulation
from dcrb_ros.vehicle.heat import VehicleHeat
from dcrb_ros.vehicle.model import VehicleModel
from dcrb_ros.vehicle.requests import VehicleRequests
from dcrb_ros.vehicle.scenario import VehicleScenario, vehicle_scenario

MEASURED = ("acceleration", "clean", "clipped", "range", "preview", "preview_ns")
"""What a block has from its accelerometer, whose cable may be swapped with that of another box."""


MOST_TOGETHER = 16
"""Frames that a bearing steps before it waits for the others, at most: an interrupted run ends after them."""


class _Planned(NamedTuple):
    """A frame that the bearings are to step."""

    plan: Plan
    wind: float
    """[N]"""
    brake: float
    """[m/s^2]"""


class _Stepped(NamedTuple):
    """A frame that all bearings have stepped."""

    plan: Plan
    ring: Floats
    """Acceleration of the outer rings, shape (boxes, `FRAME`, 2) [m/s^2]."""
    angles: Mapping[str, Floats]
    """Angle of the shaft in each box that has not failed [rad]."""


class _Stretch:
    """What one bearing did over some frames."""

    def __init__(self) -> None:
        self.motions = list[tuple[Floats, Floats]]()
        """Acceleration of the outer ring and angle of the shaft in each frame before a failure, as `Simulation.step_to` returns them."""
        self.failure: ModelFailure | None = None
        """Why the other frames are missing."""


def simulation_of(
    parameters: Mapping[str, Any],
    source: str,
    tree: Any = None,
    scenario: str = "scenario",
    *,
    recorded: Mapping[str, Configuration] | None = None,
) -> VehicleSimulation:
    """Return the simulation of a vehicle.

    Args:
        parameters: those of `dcrb_ros.vehicle.scenario.starting_parameters`.
        source: the vehicle's name in error messages.
        tree: a scenario as parsed from YAML; None for a run without changes.
        scenario: the scenario's name in error messages.
        recorded: the configurations of the boxes in a recording, which replace their benches; see `dcrb_ros.vehicle.file.vehicle_of`.

    Raises:
        Refusal: a parameter or a change of the scenario is invalid.
    """
    vehicle = vehicle_of(parameters, source, recorded)
    return VehicleSimulation(vehicle, None if tree is None else vehicle_scenario(tree, vehicle, scenario))


def _loaded(box: Box, x: float, y: float) -> Configuration:
    """Return the configuration of a box that starts with a force on its inner ring in X and Y [N]."""
    return changed(box.configuration, {"operating.lateral_load": x, "operating.load": -y}, box.name)


class VehicleSimulation:
    """Simulates the bearings of a vehicle and yields a block of each, with equal stamps.

    Every frame of `FRAME` steps has three phases. First the vehicle's model gives loads and speeds. Then each bearing is stepped, on its
    thread. Last, the motion of every box is mixed in a fixed order and sensed. Each phase takes all frames of a block in turn, which takes
    less time than phases that alternate; the first frame is stepped while the others are planned. Bearings wait for each other after every
    frame only if they heat each other. The samples depend on the vehicle and on the simulated times of commands only, not on threads or on
    the size of blocks.

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
            The vehicle is of another type, one of its parameters is invalid, or ``threads`` is below 1.
        """
        of_type(Vehicle)("vehicle", vehicle)
        optional(of_type(int))("threads", threads)
        if threads is not None and threads < 1:
            raise Refusal(f"threads = {threads} is below 1: give the number of threads that step the bearings, or None for all processors")
        self.vehicle = vehicle
        self._model = VehicleModel(vehicle)
        self.scenario = scenario or VehicleScenario({}, ())
        """What changes during the run."""
        self._requests = VehicleRequests(vehicle, self._model, self.scenario.settings)
        starting = [_loaded(box, *load) for box, load in zip(vehicle.boxes, self._model.load().tolist(), strict=True)]
        self._upcoming = self._plan_next()
        self._drives = [GuidedDrive(configuration) for configuration in starting]
        self._heat = VehicleHeat(vehicle)
        self.simulations: dict[str, Simulation] = {
            box.name: GuidedSimulation(
                configuration,
                self.scenario.boxes.get(box.name, ()),
                drive=drive,
                surroundings=self._heat.at_start(box, vehicle.journey.wind),
            )
            for box, configuration, drive in zip(vehicle.boxes, starting, self._drives, strict=True)
        }
        """The simulation of each box, which refuses what belongs to the vehicle."""
        self._threads = min(threads or os.cpu_count() or 1, len(vehicle.boxes))
        self._steps = self._samples = 0
        self._failed: dict[str, str] = {}
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
            A command is unknown or out of range, or leaves a box without load, now or with a later setting of the scenario; nothing is
            changed.
        """
        self._requests.command(commands)

    def change(self, changes: Mapping[str, Any]) -> None:
        """Change parameters of boxes from the next block on, such as ``{"axle_1.left.faults.outer_1.width": 0.002}``.

        Wheels (``axle_1.left.wheel.flat``) and slides (``axle_2.slide``, the share by which a wheelset turns slower than it rolls) change
        with the third frame of the next block.

        Raises
        ------
        Refusal
            A key names no box or wheelset, belongs to the vehicle or cannot change, or a box has failed or refuses the change; nothing is
            changed.
        """
        self._requests.change(changes, {name: box for name, box in self.simulations.items() if name not in self._failed})

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
        return self._blocks(duration)

    def _blocks(self, duration: float | None) -> Iterator[VehicleBlock]:
        first = self.vehicle.boxes[0].configuration
        rate, size = first.sensor.sampling_rate, first.publishing.block_size
        last = None if duration is None else self._samples + round(duration * rate)
        with ThreadPoolExecutor(self._threads) as pool:
            while last is None or self._samples < last:
                yield self._block(pool, size if last is None else min(size, last - self._samples))

    def _block(self, pool: ThreadPoolExecutor, size: int) -> VehicleBlock:
        began, events = self.time_ns, list[TrackEvent]()
        commands = self._requests.apply()
        commanded = dict(self._requests.commanded)
        for simulation in self._running.values():
            simulation.prepare(size)
        frames = self._step(pool, max(simulation.steps_of(size) for simulation in self._running.values()))
        if frames:  # a short block may lie within the last frame
            motions, parts = zip(*(self._model.mix(frame.ring, frame.plan) for frame in frames), strict=True)
            self._sense(pool, frames, motions)
            self._plan, self._parts = frames[-1].plan, np.sqrt(np.mean(np.square(parts), axis=0))
            events += itertools.chain.from_iterable(frame.plan.events for frame in frames)
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
            dict.fromkeys(self._failed, "its model failed") | self._swapped,
            commanded,
            commands,
            self._requests.commanded["curvature"],
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
            connected[box.name] = block if other is block else replace(block, **{name: getattr(other, name) for name in MEASURED})
        if not connected:
            raise ModelFailure(f"every box has failed, or is swapped with one that has: {'; '.join(self._failed.values())}")
        return connected

    def worn(self) -> dict[str, Any]:
        """Return the parameters of wheels and the slides by their keys, as `change` takes them; those that are pending are left out."""
        return self._requests.worn()

    @property
    def silent(self) -> Mapping[str, str]:
        """Boxes that are silent, and why: their model failed, or their sensor is swapped with that of a box whose model failed."""
        return self._failed | {name: f"{name}: {reason}" for name, reason in self._swapped.items()}

    @property
    def _swapped(self) -> dict[str, str]:
        """Boxes that are silent although their model runs, and why."""
        silent = (box for box in self.vehicle.boxes if box.swapped_with in self._failed and box.name not in self._failed)
        return {box.name: f"its sensor is swapped with that of {box.swapped_with}" for box in silent}

    @property
    def _running(self) -> dict[str, Simulation]:
        """Boxes whose model has not failed."""
        running = {name: simulation for name, simulation in self.simulations.items() if name not in self._failed}
        if not running:
            raise ModelFailure(f"the models of all boxes failed: {'; '.join(self._failed.values())}")
        return running

    def _step(self, pool: ThreadPoolExecutor, end: int) -> list[_Stepped]:
        """Let the bearings step frames until they reach step ``end``, and return these frames."""
        frames = [Future[_Planned]() for _ in range(self._steps, end, FRAME)]
        most = 1 if any(simulation.temperatures for simulation in self._running.values()) else MOST_TOGETHER
        stepped = list[_Stepped]()
        for first in range(0, len(frames), most):
            if first == 0:
                frames[0].set_result(self._commanded(self._upcoming))
            together = frames[first : first + most]
            stretches, workers = self._begin(pool, together)
            if first == 0:  # the bearings step the first frame meanwhile
                self._plan_others(frames)
            for worker in workers:
                worker.result()
            stepped += self._joined(together, stretches)
        return stepped

    def _plan_others(self, frames: Sequence[Future[_Planned]]) -> None:
        """Plan all frames but the first, and that after them."""
        try:
            for frame in frames[1:]:
                frame.set_result(self._commanded(self._plan_next()))
            self._upcoming = self._plan_next()
        except BaseException:
            for frame in frames:
                frame.cancel()  # a bearing that waits for it ends
            raise

    def _commanded(self, plan: Plan) -> _Planned:
        """Return a frame with the commands that are in effect at present."""
        return _Planned(plan, self._requests.commanded["wind"], self._requests.commanded["brake"])

    def _begin(self, pool: ThreadPoolExecutor, frames: Sequence[Future[_Planned]]) -> tuple[dict[str, _Stretch], list[Future[None]]]:
        """Let the bearings step some frames, of which the first is planned; return what they write, and the threads' work."""
        (plan, wind, brake), running, begin = frames[0].result(), self._running, self._steps
        for name, surroundings in self._heat.surroundings(plan.speed, wind, brake, running).items():
            running[name].surround(surroundings)
        stretches = {name: _Stretch() for name in running}
        waiting = deque(j for j, name in enumerate(self._names) if name in running)

        def work() -> None:
            """Step the bearing that waits longest by a frame, until none is waiting: so all threads end at nearly the same time."""
            while waiting:
                try:
                    j = waiting.popleft()
                except IndexError:  # another thread took it
                    return
                box, drive = self.vehicle.boxes[j], self._drives[j]
                stretch = stretches[box.name]
                plan = frames[len(stretch.motions)].result().plan
                drive.speed, drive.load = float(plan.shaft_speed[box.axle]), plan.load[j]
                try:
                    stretch.motions.append(running[box.name].step_to(begin + (len(stretch.motions) + 1) * FRAME))
                except ModelFailure as failure:
                    stretch.failure = failure
                    continue
                if len(stretch.motions) < len(frames):
                    waiting.append(j)

        self._steps += len(frames) * FRAME
        return stretches, [pool.submit(work) for _ in range(min(self._threads, len(waiting)))]

    def _plan_next(self) -> Plan:
        """Return the plan of the next frame; the scenario's settings of that frame act from its end on."""
        self._requests.begin_frame()
        return self._model.plan()

    def _joined(self, frames: Sequence[Future[_Planned]], stretches: Mapping[str, _Stretch]) -> list[_Stepped]:
        """Return the motion of all bearings in some frames.

        Raises:
            ModelFailure: the model of a box failed, and ``vehicle.on_failure`` is stop.
        """
        stepped = list[_Stepped]()
        for n, frame in enumerate(frames):
            ring, angles = np.zeros((len(self.vehicle.boxes), FRAME, 2)), {}
            for j, name in enumerate(self._names):
                if name not in stretches or name in self._failed:
                    continue
                stretch = stretches[name]
                if n < len(stretch.motions):
                    ring[j], angles[name] = stretch.motions[n]
                    continue
                if self.vehicle.journey.on_failure == "stop":
                    raise ModelFailure(f"{name}: {stretch.failure}")
                self._failed[name] = f"{name}: {stretch.failure}"
            stepped.append(_Stepped(frame.result().plan, ring, angles))
        return stepped

    def _sense(self, pool: ThreadPoolExecutor, frames: Sequence[_Stepped], motions: Sequence[Floats]) -> None:
        """Measure the ``motions`` in consecutive frames, each of shape (boxes, `FRAME`, 2), in every box that has not failed in them."""

        def sense(j: int, name: str) -> None:
            present = [(motion[j], frame.angles[name]) for frame, motion in zip(frames, motions, strict=True) if name in frame.angles]
            if present:
                motion, angle = zip(*present, strict=True)
                self.simulations[name].sense(np.concatenate(motion), np.concatenate(angle))

        deque(pool.map(sense, range(len(self._names)), self._names), maxlen=0)

    @property
    def _names(self) -> list[str]:
        return [box.name for box in self.vehicle.boxes]
