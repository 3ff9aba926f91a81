"""The simulation of a vehicle of a sweep: once for all its boxes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.schema.verdicts import BEARING_FAULTS
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.stream.block import Block, Truth
from dcrb_ros.vehicle.file import vehicle_of
from dcrb_ros.vehicle.simulation import VehicleSimulation


@dataclass(frozen=True)
class Ride:
    """The blocks of all boxes of a vehicle."""

    before: Mapping[str, list[Truth]]
    """Ground truth of the time that is not recorded, by box."""
    blocks: Mapping[str, list[Block]]
    """Recorded blocks, by box."""
    configurations: Mapping[str, Configuration]
    """By box."""

    @property
    def damaged(self) -> str:
        """The boxes with a damaged bearing at the end, and their faults."""
        truths = {
            name: [*self.before[name], *(truth for block in blocks for truth in block.truths)] for name, blocks in self.blocks.items()
        }
        faults = {name: class_of(of_box[-1].faults) for name, of_box in truths.items()}
        return ", ".join(f"{name} {fault}" for name, fault in faults.items() if fault in BEARING_FAULTS)


def ride(parameters: Mapping[str, Any], settle: float, duration: float) -> Ride:
    """Return the simulation of a vehicle over a time [s], after ``settle`` [s] that is not recorded.

    Raises:
        Refusal: a parameter is invalid.
        ModelFailure: the model of a box failed.
    """
    vehicle = vehicle_of(parameters, "run")
    simulation = VehicleSimulation(vehicle, threads=1)
    before: dict[str, list[Truth]] = {name: [] for name in simulation.simulations}
    for name, block in _boxes(simulation, settle):  # the samples before the recorded time are not kept
        before[name] += block.truths
    recorded: dict[str, list[Block]] = {name: [] for name in simulation.simulations}
    for name, block in _boxes(simulation, duration):
        recorded[name].append(block)
    if simulation.silent:
        raise ModelFailure("; ".join(simulation.silent.values()))
    return Ride(before, recorded, {name: box.configuration for name, box in simulation.simulations.items()})


def _boxes(simulation: VehicleSimulation, duration: float) -> Iterator[tuple[str, Block]]:
    """Yield the blocks over a time [s], each with the name of its box."""
    for block in simulation.blocks(duration):
        yield from block.boxes.items()
