"""Signals of vehicles for an exam: simulated once and kept.

Vehicles that differ in paths and sensors only have the same bearings at the same loads. The motion of their outer rings is therefore
stepped once and mixed anew for each of them, which gives the same bits as a simulation of its own.
"""

from __future__ import annotations

import functools
import hashlib
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.exam.case import canonical
from dcrb_ros.exam.recording_cache import keep, kept_content
from dcrb_ros.exam.running_detector import BoxSamples
from dcrb_ros.exam.vehicle.exam_file import resolved
from dcrb_ros.measurement.sensor import Measurement, Sensor
from dcrb_ros.messages.vehicle import box_path
from dcrb_ros.recordings.manifest import model_fingerprint, software, vehicle_fingerprint
from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.simulation.block_queue import wrapped
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.vehicle.description import Box, Vehicle, described
from dcrb_ros.vehicle.file import vehicle_of
from dcrb_ros.vehicle.frame import FRAME
from dcrb_ros.vehicle.model import VehicleModel
from dcrb_ros.vehicle.simulation import VehicleSimulation

BLOCK = 1024
"""Samples of a block that a detector receives [-]."""
MOST_REMEMBERED = 20
"""Bearings whose motion is remembered [-]: four boxes, healthy and with three faults, and some; each second takes 5 MB."""
KINDS = ("acceleration", "shaft_angle", "temperatures")
"""Arrays of a signal by box."""
OF_SENSOR = ("sensor", "structure", "publishing", "tacho", "recording", "background")
"""Groups of a box's configuration on which the motion of its outer ring does not depend."""

Motion = list[tuple[Floats, Floats]]
"""Acceleration of an outer ring and angle of its shaft, frame by frame."""


@dataclass(frozen=True)
class VehicleSignal:
    """The waveforms of all boxes of a vehicle, as a detector receives them."""

    description: VehicleDescription
    acceleration: Mapping[str, Samples]
    """By box, shape (samples, 2) [m/s^2]."""
    shaft_angle: Mapping[str, Samples]
    """By box, shape (samples,) [rad]."""
    temperatures: Mapping[str, Floats] = field(default_factory=dict)
    """Time [s], temperature of the outer ring and of the air [deg C] of each reading, shape (readings, 3), by box with a network."""

    def readings(self, box: str, first: float, last: float) -> tuple[tuple[float, float, float], ...]:
        """Return the readings of a box from a time up to another one [s]."""
        rows = self.temperatures.get(box, np.zeros((0, 3)))
        return tuple((time, ring, air) for time, ring, air in rows.tolist() if first <= time < last)

    def pieces(self) -> Iterator[tuple[dict[str, BoxSamples], int, int]]:
        """Yield blocks of all boxes, with the index of their first sample and the one after their last."""
        samples, rate = max(map(len, self.shaft_angle.values())), self.description.sampling_rate
        for first in range(0, samples, BLOCK):
            last = min(first + BLOCK, samples)
            piece = {}
            for name, angle in self.shaft_angle.items():
                readings = self.readings(name, first / rate, last / rate)
                piece[name] = BoxSamples(first, self.acceleration[name][first:last], angle[first:last], readings)
            yield piece, first, last


class MotionMemory:
    """Motion of the outer rings of bearings that were stepped, the latest ones."""

    def __init__(self) -> None:
        self._motion: Callable[[str], Motion] = functools.lru_cache(MOST_REMEMBERED)(lambda key: [])

    def motion(self, vehicle: Vehicle, box: Box) -> Motion:
        """Return what is remembered of a bearing, to which more can be added."""
        return self._motion(hashlib.sha256(canonical(_on_which_motion_depends(vehicle, box)).encode()).hexdigest())


@functools.lru_cache(maxsize=1)
def _memory(duration: float) -> MotionMemory:
    """Return the motion that this process has stepped over a time [s]."""
    return MotionMemory()


class RememberedBearing:
    """The simulation of a bearing that steps only frames that are not remembered; everything else is the simulation's."""

    def __init__(self, simulation: Simulation, motion: Motion) -> None:
        self._simulation, self._motion = simulation, motion
        self._live = not motion

    def __getattr__(self, name: str) -> Any:
        return getattr(self._simulation, name)

    def step_to(self, end: int) -> tuple[Floats, Floats]:
        """Return acceleration and angle of the frame that ends at step ``end``, as `Simulation.step_to` does."""
        if self._live:
            self._motion.append(self._simulation.step_to(end))
        return self._motion[end // FRAME - 1]


def simulated_signal(vehicle: Vehicle, duration: float, memory: MotionMemory, threads: int | None = None) -> VehicleSignal:
    """Return the signal of a vehicle over a time [s]; bearings whose remembered motion is too short are stepped again.

    Raises:
        ModelFailure: the model of a box failed.
    """
    remembered, frames = [memory.motion(vehicle, box) for box in vehicle.boxes], _frames(vehicle, duration)
    for motion in remembered:
        if len(motion) < frames:
            motion.clear()
    if any(box.configuration.thermal.law != "none" for box in vehicle.boxes):
        memory = MotionMemory()  # only bearings that are stepped become warm
    elif all(remembered) and not any(box.swapped_with for box in vehicle.boxes):
        return _mixed(vehicle, duration, [motion[:frames] for motion in remembered])
    simulation = VehicleSimulation(vehicle, threads=threads)
    for box in vehicle.boxes:
        bearing: Any = RememberedBearing(simulation.simulations[box.name], memory.motion(vehicle, box))
        simulation.simulations[box.name] = bearing
    pieces: dict[str, list[Block]] = {box.name: [] for box in vehicle.boxes}
    try:
        for block in simulation.blocks(duration):
            for name, box_block in block.boxes.items():
                pieces[name].append(box_block)
        if simulation.silent:
            raise ModelFailure("; ".join(simulation.silent.values()))
    except BaseException:
        for box in vehicle.boxes:
            memory.motion(vehicle, box).clear()  # a part of a motion would be taken for the whole
        raise
    return VehicleSignal(
        described(vehicle),
        {box_path(name): np.concatenate([block.acceleration for block in blocks]) for name, blocks in pieces.items()},
        {box_path(name): np.concatenate([block.shaft_angle for block in blocks]) for name, blocks in pieces.items()},
        {box_path(name): rows for name, blocks in pieces.items() if len(rows := _readings(blocks))},
    )


def _frames(vehicle: Vehicle, duration: float) -> int:
    """Return the frames after which every box has the samples of a time [s]; a clock that is slow needs more of them [-]."""
    count = round(duration * vehicle.boxes[0].configuration.sensor.sampling_rate)
    return -(-max(Sensor(box.configuration.measurement).steps(count) for box in vehicle.boxes) // FRAME)


def _readings(blocks: Sequence[Block]) -> Floats:
    """Return the readings of a box; see `VehicleSignal.temperatures`."""
    read = [(reading.time_ns * 1e-9, reading.outer_ring, reading.ambient) for block in blocks for reading in block.temperatures]
    return np.array(read, np.float64).reshape(-1, 3)


def _mixed(vehicle: Vehicle, duration: float, motions: Sequence[Motion]) -> VehicleSignal:
    """Return the signal of a vehicle whose bearings have all been stepped, mixed and sensed as `VehicleSimulation` does it."""
    model, rate = VehicleModel(vehicle), vehicle.boxes[0].configuration.sensor.sampling_rate
    sensors = [Sensor(box.configuration.measurement) for box in vehicle.boxes]
    measured: list[list[Measurement]] = [[] for _ in sensors]
    for frame in zip(*motions, strict=True):
        mixed, _ = model.mix(np.array([acceleration for acceleration, _ in frame]), model.plan())
        for j, (_, angle) in enumerate(frame):
            measured[j].append(sensors[j].measure(mixed[j], angle))
    count = round(duration * rate)
    names = [box_path(box.name) for box in vehicle.boxes]
    accelerations = [np.concatenate([part.measured for part in parts])[:count].astype(np.float32) for parts in measured]
    angles = [wrapped(np.concatenate([part.angle for part in parts])[:count]) for parts in measured]
    return VehicleSignal(described(vehicle), dict(zip(names, accelerations, strict=True)), dict(zip(names, angles, strict=True)))


def keep_signal(signal: VehicleSignal, path: Path) -> bytes:
    """Write a signal to a file, from which `kept_signal` reads it; return its content without the digest."""
    arrays: dict[str, Any] = {f"{kind}.{name}": values for kind in KINDS for name, values in getattr(signal, kind).items()}
    stream = io.BytesIO()
    np.savez(stream, description=np.array(signal.description.to_json()), **arrays)
    keep(path, stream.getvalue())
    return stream.getvalue()


def kept_signal(parameters: Mapping[str, Any], duration: float, folder: Path, *, threads: int | None = None) -> VehicleSignal:
    """Return the signal of a vehicle given by its parameters; simulate it if it is not in the folder, or not as it was written.

    The simulation has ``threads``, by default one for each core.
    """
    path = signal_path(parameters, duration, folder)
    content = kept_content(path, "the vehicle is simulated again")
    if content is None:
        signal = simulated_signal(vehicle_of(parameters, "the exam"), duration, _memory(duration), threads)
        content = keep_signal(signal, path)
    with np.load(io.BytesIO(content), allow_pickle=False) as kept:
        arrays: dict[str, dict[str, Any]] = {kind: {} for kind in KINDS}
        for name in sorted(kept.files):
            kind, dot, box = name.partition(".")
            if dot:
                arrays[kind][box] = kept[name]
        return VehicleSignal(VehicleDescription.from_json(str(kept["description"])), **arrays)


def signal_path(parameters: Mapping[str, Any], duration: float, folder: Path) -> Path:
    """Return the file of a vehicle's signal; its name is a hash of everything on which the samples depend."""
    about = canonical([dict(parameters), resolved([parameters]), duration, model_fingerprint(), vehicle_fingerprint(), software()])
    return folder / f"{hashlib.sha256(about.encode()).hexdigest()[:24]}.signal"


def _on_which_motion_depends(vehicle: Vehicle, box: Box) -> list[Any]:
    """Return what the motion of an outer ring depends on: the vehicle that loads the bearing, and the bearing."""
    groups = [part.model_dump() for part in (vehicle.journey, vehicle.body, vehicle.frame, vehicle.suspension, vehicle.track)]
    axles = [[axle.x, axle.radius, axle.creep, axle.slide, axle.gear.model_dump(), axle.motor.model_dump()] for axle in vehicle.axles]
    wheels = [[other.name, other.wheel.model_dump()] for other in vehicle.boxes]
    own = {key: value for key, value in box.configuration.model_dump().items() if key not in OF_SENSOR}
    return [groups, axles, wheels, box.name, own]
