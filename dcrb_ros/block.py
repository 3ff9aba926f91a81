"""What flows from a source to the sinks: blocks of samples with the states and the truth that belong to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Samples = npt.NDArray[np.float32]
LONGEST_BLOCK = 4.29
"""Longest block [s]: messages tell the time of a sample after the block's stamp in nanoseconds of 32 bits."""


def nanoseconds(count: int, rate: int) -> int:
    """Return the simulated time [ns] of tick ``count`` of a clock of ``rate`` ticks a second [Hz], rounded down."""
    return count * 1_000_000_000 // rate


@dataclass(frozen=True)
class Layout:
    """Rows and rollers of the bearing, and the body names that follow from them."""

    rows: int
    rollers_per_row: int

    @property
    def names(self) -> list[str]:
        """Body names in the order of `States`: row by row the rollers, then the cages, then the inner ring."""
        rollers = [f"row{row + 1}/roller{i + 1:02d}" for row in range(self.rows) for i in range(self.rollers_per_row)]
        return [*rollers, *(f"cage{row + 1}" for row in range(self.rows)), "inner_ring"]


@dataclass(frozen=True)
class Account:
    """Energy since the start [J]."""

    drive: float
    """Work of the shaft."""
    load: float
    """Work of the load on the inner ring."""
    friction: float
    """Lost in friction."""
    loss: float
    """Lost in normal contacts."""
    housing: float
    """Lost in the housing's damper."""
    notch: float
    """Taken by the notch law: it has depth, but no tangential force at the edge that would do the work."""
    stored: float
    """Gained in motion, contacts, housing and height."""

    @property
    def residual(self) -> float:
        """What does not add up [J]: the error of the integration."""
        return self.drive + self.load - self.friction - self.loss - self.housing - self.notch - self.stored


@dataclass(frozen=True)
class States:
    """The bodies at one instant; arrays of one entry per name of `Layout.names`."""

    time_ns: int
    """Simulated time [ns]."""
    azimuth: Floats
    """Azimuth from the load line (-Y), counter-clockwise, of rollers and of each cage's first pocket;
    rotation angle of the inner ring [rad]. All wrapped to (-pi, pi]."""
    speed: Floats
    """Absolute spin of rollers, rotation of cages and inner ring [rad/s]."""
    inner_force: Floats
    """Normal force between roller and inner raceway [N]; zero for cages, the sum of magnitudes for the inner ring."""
    outer_force: Floats
    """Normal force between roller and outer raceway [N]; zero for cages and the inner ring."""
    slip: Floats
    """Slip at the inner raceway [m/s]; zero for cages and the inner ring."""
    friction: Floats
    """Friction force at the inner raceway [N]; zero for cages and the inner ring."""
    torque: Floats
    """Friction torque of both raceways on a roller [N m]; zero for cages and the inner ring."""
    relative_speed: Floats
    """Spin of rollers against their cage [rad/s]; zero for cages and the inner ring."""
    bar_force: Floats
    """Normal force between a roller and its bar, positive at the bar ahead [N]; of a cage, the force of its land."""
    cage_offset: Floats
    """Centre of each cage from the outer ring's, shape (rows, 2) [m]."""
    inner_ring_force: tuple[float, float]
    """Total force of the rollers on the inner ring in X and Y [N]."""


@dataclass(frozen=True)
class Truth:
    """Ground truth at one instant: what a detector should have found."""

    time_ns: int
    """Simulated time [ns]."""
    speed: float
    """Speed of the inner ring [rad/s]."""
    load: tuple[float, float]
    """Force on the inner ring in X and Y [N]."""
    frequencies: Mapping[str, float]
    """FTF, BPFO, BPFI, BSF at the present speed [Hz]."""
    faults: Mapping[str, Mapping[str, Any]]
    """Every fault present, by its configuration key (``outer_1``) or its kind (``sensor.stuck``): its fields and ``onset`` [s]."""
    changed: str = ""
    """Why it was sent out of turn (``command/speed 130.0 rad/s``); empty for the 10 Hz repetition."""
    background: Mapping[str, float] = field(default_factory=dict)
    """Levels of what shakes the axle box besides the bearing, by key; they are no faults."""


@dataclass(frozen=True)
class Block:
    """A stretch of the measured waveform and everything simulated meanwhile."""

    index: int
    """Index of the first sample since the start; sample ``k`` is taken at ``k / rate``."""
    rate: int
    """Sampling rate [Hz]."""
    acceleration: Samples
    """Measured acceleration of the outer ring in X and Y, shape (samples, 2) [m/s^2]."""
    shaft_angle: Samples
    """Rotation of the inner ring at each sample, wrapped to [0, 2 pi), shape (samples,) [rad]."""
    clean: Samples
    """Acceleration before noise, clipping and ADC, shape (samples, 2) [m/s^2]."""
    clipped: int = 0
    """Samples beyond the sensor's range in this block."""
    range: float = 0.0
    """The sensor's range at the end of this block [m/s^2]; 0 where it is not known."""
    preview: Samples = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    """Low-passed acceleration for viewers, shape (previews, 2) [m/s^2]."""
    preview_ns: tuple[int, ...] = ()
    """Simulated time of each preview sample [ns]."""
    lost: bool = False
    """Whether its waveform is not published: lost on its way, or between two bursts."""
    states: tuple[States, ...] = ()
    truths: tuple[Truth, ...] = ()
    energy: Account | None = None
    """The energy account at the end of a block with a truth in it; it is worked out no more often."""

    @property
    def stamp_ns(self) -> int:
        """Simulated time of the first sample [ns]."""
        return nanoseconds(self.index, self.rate)

    @property
    def end_ns(self) -> int:
        """Simulated time of the first sample after this block [ns]."""
        return nanoseconds(self.index + len(self.acceleration), self.rate)
