"""The simulations of the validation, and the quantities kept from each."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.states import Account
from dcrb_ros.validation.report_row import ReportRow

JOINTS = ("revolute", "pocket")
BENCH = {"revolute": "paper", "pocket": "dry"}
"""The shipped configuration for each joint."""
OILED = "lubricated"
"""In place of the joint of a run of a lubricated bearing."""

PAPER_SPEED = 124.8
"""Shaft speed used in the paper's section 2.3.2 [rad/s]."""

SETTLED = 0.2
"""Time left out of all statistics at the start of a warm run [s]."""

QUARTER_STEP = "outer ring defect, quarter step"
"""Name of the runs whose step is a quarter of the default one."""

BROKEN_BAR = 15
"""Bar missing in both rows, between rollers 15 and 16."""

# Power-law contact and Coulomb friction, as in the independent multibody engine whose results `faults.py` compares with. These results
# were computed once; the program is not part of this repository.
POWER_LAW = (
    "contact.law=power",
    "contact.power_coefficient=3.449e9",
    "contact.power_exponent=1.0766",
    "contact.damping=4000.0",
    "contact.loss_time=0.0",
    "friction.kinetic_coefficient=0.05",
    "friction.static_coefficient=0.05",
    "operating.speed=125.664",
)


@dataclass(frozen=True)
class RunSpec:
    """The specification of a run: a shipped configuration, changed parameters and a duration."""

    name: str
    joint: str
    """Joint of the cage, or `OILED`."""
    bench: str
    """The shipped configuration."""
    duration: float
    """Simulated time that is kept [s]."""
    settings: tuple[str, ...]
    settling: float = 0.0
    """Simulated time before that [s]."""

    @property
    def key(self) -> tuple[str, str]:
        """Name and joint."""
        return self.name, self.joint

    @property
    def label(self) -> str:
        """Name and joint, for the report."""
        return f"{self.name}, {self.joint}"

    @property
    def command(self) -> str:
        """The command line that records this run in a folder named after it; of several values of a parameter the last one counts."""
        values = dict(setting.split("=", 1) for setting in self.settings)
        options = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
        folder = self.label.replace(",", "").replace(" ", "-")
        return shlex.join(["dcrb", "simulate", self.bench, "--duration", f"{self.settling + self.duration:g}", *options, "-o", folder])

    def configuration(self, changes: tuple[str, ...] = ()) -> Configuration:
        """Return the configuration, with further changes that count before the run's own."""
        return load_configuration(self.bench, (*changes, *self.settings))


def paper_spec(name: str, joint: str, duration: float, settings: tuple[str, ...] = (), state_rate: int = 2000) -> RunSpec:
    """Return the specification of a run [s] without noise at the paper's speed, whose states are kept at a rate [Hz]."""
    common = f"operating.speed={PAPER_SPEED}", f"publishing.state_rate={state_rate}", "sensor.noise_density=0.0"
    return RunSpec(name, joint, BENCH[joint], duration, (*common, *settings))


WIDTHS = (0.5, 1.0, 1.5, 2.0)
"""Widths of the outer-ring defect whose severity is compared [mm]."""


def run_specs() -> list[RunSpec]:
    """Return the specifications of all runs, the longest first."""
    specs = []
    for joint in reversed(JOINTS):
        bars = f"faults.broken_bars=row1/bar{BROKEN_BAR}, row2/bar{BROKEN_BAR}"
        specs += [
            paper_spec("healthy", joint, 6.0, state_rate=3000),
            paper_spec("cage fracture", joint, 6.0, (bars,), 3000),
            paper_spec("outer ring defect", joint, 3.0, ("faults.outer_1.width=0.002",), 5000),
            paper_spec("inner ring defect", joint, 3.0, ("faults.inner_1.width=0.002",), 5000),
            paper_spec(QUARTER_STEP, joint, 3.0, ("faults.outer_1.width=0.002", "simulation.step=2.44140625e-6"), 500),
        ]
        specs += [
            paper_spec("roller defect", joint, 4.0, ("faults.roller_1.width=0.002",), 500),
            paper_spec("rows staggered", joint, 1.2, ("faults.outer_1.width=0.002", "bearing.row_phase=0.5"), 100),
        ]
        specs += [paper_spec(f"outer ring defect {b:g} mm", joint, 1.2, (f"faults.outer_1.width={b * 1e-3:g}",), 100) for b in WIDTHS]
        specs += [paper_spec("cold start", joint, 3.0, ("operating.start=cold",))]
    specs += [
        paper_spec("power law, healthy", "revolute", 1.2, POWER_LAW),
        paper_spec("power law, outer ring defect", "revolute", 1.2, (*POWER_LAW, "faults.outer_1.width=0.002"), 5000),
    ]
    return specs


@dataclass(frozen=True)
class PaperRun:
    """The results of a run.

    Shapes are (times, rollers) unless stated otherwise; rollers are columns, row of the bearing by row.
    """

    spec: RunSpec
    configuration: Configuration
    acceleration: Floats
    """Vertical acceleration of the outer ring before noise, shape (samples,) [m/s^2]."""
    shaft_angle: Samples
    """Shaft angle within one turn, shape (samples,) [rad]."""
    time: Floats
    """Times of the states, shape (times,) [s]."""
    azimuth: Samples
    """Azimuth of the rollers from the load line [rad]."""
    spin: Samples
    """Absolute spin of the rollers [rad/s]."""
    relative_spin: Samples
    """Spin of the rollers relative to the cage [rad/s]."""
    inner_force: Samples
    """Normal force at the inner raceway [N]."""
    outer_force: Samples
    """Normal force at the outer raceway [N]."""
    slip: Samples
    """Slip at the inner raceway [m/s]."""
    friction: Samples
    """Friction force at the inner raceway [N]."""
    torque: Samples
    """Friction torque of both raceways [N m]."""
    bar_force: Samples
    """Normal force between a roller and its bar, positive at the bar ahead [N]."""
    cage_offset: Floats
    """Distance of the cages' centres from the outer ring's, shape (times, rows) [m]."""
    cage_speed: Floats
    """Rotation speed of the cages, shape (times, rows) [rad/s]."""
    inner_ring_force: Floats
    """Total vertical force of the rollers on the inner ring, shape (times,) [N]."""
    energy: Account
    """Energy account over the whole run."""

    @property
    def rate(self) -> int:
        """Sampling rate [Hz]."""
        return self.configuration.sensor.sampling_rate

    @property
    def settled(self) -> npt.NDArray[np.bool_]:
        """Mask of the states that enter statistics, shape (times,)."""
        return self.time >= SETTLED

    @property
    def steady_acceleration(self) -> Floats:
        """Vertical acceleration without the start of the run, shape (samples,) [m/s^2]."""
        return self.acceleration[round(SETTLED * self.rate) :]

    @property
    def mean_cage_speed(self) -> float:
        """Mean cage speed [rad/s]."""
        return float(self.cage_speed[self.settled].mean())

    @property
    def cage_frequency(self) -> float:
        """Mean cage frequency [Hz]."""
        return self.mean_cage_speed / (2.0 * np.pi)

    @property
    def shaft_frequency(self) -> float:
        """Shaft frequency [Hz]."""
        return self.configuration.operating.speed / (2.0 * np.pi)

    @property
    def rollers_per_row(self) -> int:
        """Rollers in a row [-]."""
        return self.configuration.bearing.rollers_per_row

    def columns(self, roller: int) -> list[int]:
        """Return the columns of the rollers with a number, one per row."""
        return [row * self.rollers_per_row + roller - 1 for row in range(self.configuration.bearing.rows)]

    def row(self, quantity: str, paper: str, found: str, accepted: str, holds: bool) -> ReportRow:
        """Return the comparison of a quantity of this run; see `ReportRow`."""
        return ReportRow(quantity, self.spec.joint, paper, found, accepted, holds)


PaperRuns = Mapping[tuple[str, str], PaperRun]
"""Runs by name and joint."""


def simulate(spec: RunSpec) -> PaperRun:
    """Simulate a run and return its results."""
    configuration = spec.configuration()
    rows, count = configuration.bearing.rows, configuration.bearing.rows * configuration.bearing.rollers_per_row
    simulation = Simulation(configuration)
    blocks = list(simulation.blocks(spec.duration))
    states = [states for block in blocks for states in block.states]

    fields = ("azimuth", "relative_speed", "inner_force", "outer_force", "slip", "friction", "torque", "bar_force")
    series = {field: np.array([getattr(state, field) for state in states], np.float32)[:, :count] for field in fields}
    relative_spin, speed = series.pop("relative_speed"), np.array([state.speed for state in states])
    return PaperRun(
        spec=spec,
        configuration=configuration,
        acceleration=np.concatenate([block.clean[:, 1] for block in blocks]).astype(np.float64),
        shaft_angle=np.concatenate([block.shaft_angle for block in blocks]),
        time=np.array([state.time_ns for state in states]) * 1e-9,
        spin=speed[:, :count].astype(np.float32),
        relative_spin=relative_spin,
        **series,
        cage_offset=np.array([np.hypot(*state.cage_offset.T) for state in states]),
        cage_speed=speed[:, count : count + rows],
        inner_ring_force=np.array([state.inner_ring_force[1] for state in states]),
        energy=simulation.energy,
    )
