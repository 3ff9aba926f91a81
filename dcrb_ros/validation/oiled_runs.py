"""The simulations of lubricated bearings for the validation, and the quantities kept from each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.states import Account, LubricationState
from dcrb_ros.validation.runs import OILED, RunSpec

HEALTHY, SPALL = "healthy", "outer_ring_defect"
"""Shipped configurations of a lubricated bearing, healthy and with a spall of 2 mm."""
SETTLING = 0.2
"""Simulated time before anything is kept [s]."""
SPREADS = (
    "roller_spread",
    "clearance_spread",
    "row_spread",
    "run_out",
    "pocket_spread",
    "pocket_clearance_spread",
    "cage_unbalance",
    "waviness",
    "waviness_spread",
    "short_waves",
    "roundness",
)
STEADY = ("operating.speed_fluctuation=0", "operating.speed_ripple=0")
"""A shaft at constant speed."""
EVEN = (*(f"surfaces.{name}=0" for name in SPREADS), *STEADY)
"""A bearing as drawn, on surfaces without waviness."""
WAVES = (*(setting for setting in EVEN if not setting.startswith("surfaces.waviness=")), "housing.axle_mass=0")
"""A bearing with the waviness of ground raceways alone, 0.1 um, whose inner ring carries no axle."""


def oiled_spec(name: str, duration: float, settings: tuple[str, ...] = (), *, bench: str = HEALTHY, settling: float = SETTLING) -> RunSpec:
    """Return the specification of a run [s] of a lubricated bearing without noise."""
    return RunSpec(name, OILED, bench, duration, ("sensor.noise_density=0", *settings), settling)


@dataclass(frozen=True)
class OiledRun:
    """The results of a run after its first part."""

    spec: RunSpec
    configuration: Configuration
    acceleration: Floats
    """Of the outer ring in X and Y without noise, shape (samples, 2) [m/s^2]."""
    behind_box: Floats
    """The same at the sensor, behind the modes of the axle box, if the run has modes."""
    states: tuple[LubricationState, ...]
    """Films and losses."""
    change: Account
    """Change of the energy account."""
    bar_force: Floats
    """Of rollers, shape (times, rollers) [N]."""
    inner_force: Floats
    """Of rollers, shape (times, rollers) [N]."""
    cage_speed: Floats
    """Shape (times, rows) [rad/s]."""

    @property
    def power(self) -> Floats:
        """Mean power of both rows by source, shape (sources,) [W]."""
        first, last = self.states[0].friction_loss, self.states[-1].friction_loss
        times = len(self.states) - 1
        return np.asarray((last - first).sum(axis=0) / (times / self.configuration.publishing.state_rate))

    @property
    def drive_power(self) -> float:
        """Power of the shaft [W]."""
        return self.change.drive / self.spec.duration

    @property
    def rms(self) -> Floats:
        """Root mean square in X and Y, shape (2,) [m/s^2]."""
        return np.asarray(self.acceleration.std(axis=0))


OiledRuns = Mapping[str, OiledRun]
"""Runs by name."""


def oiled_specs() -> list[RunSpec]:
    """Return the specifications of all runs of lubricated bearings."""
    return [
        oiled_spec("healthy", 2.0),
        oiled_spec("spall", 1.5, ("structure.modes=6",), bench=SPALL),
        oiled_spec("steady", 1.0, STEADY),
        oiled_spec("light load", 0.8, (*STEADY, "operating.load=5000.0")),
        oiled_spec("thin layer", 0.5, (*STEADY, "lubrication.layer=1e-6")),
        oiled_spec("cold start", 0.02, (*STEADY, "operating.start=cold", "publishing.state_rate=3000"), settling=0.0),
        oiled_spec("waves", 0.5, (*WAVES, "housing.box_mass=0")),
        oiled_spec("waves with box", 0.5, WAVES),
    ]


def simulate_oiled(spec: RunSpec, changes: tuple[str, ...] = ()) -> OiledRun:
    """Simulate a run, with further changes of its parameters, and return its results."""
    configuration = spec.configuration(changes)
    simulation = Simulation(configuration)
    if spec.settling > 0.0:
        list(simulation.blocks(spec.settling))
    before = simulation.energy
    blocks = list(simulation.blocks(spec.duration))
    after, states = simulation.energy, [states for block in blocks for states in block.states]
    oils = tuple(state.lubrication for state in states if state.lubrication is not None)
    rollers = configuration.bearing.rows * configuration.bearing.rollers_per_row
    return OiledRun(
        spec=spec,
        configuration=configuration,
        acceleration=np.concatenate([block.clean for block in blocks]).astype(np.float64),
        behind_box=np.concatenate([block.acceleration for block in blocks]).astype(np.float64),
        states=oils,
        change=Account(**{name: getattr(after, name) - getattr(before, name) for name in Account.__dataclass_fields__}),
        bar_force=np.array([state.bar_force[:rollers] for state in states]),
        inner_force=np.array([state.inner_force[:rollers] for state in states]),
        cage_speed=np.array([state.speed[rollers : rollers + configuration.bearing.rows] for state in states]),
    )
