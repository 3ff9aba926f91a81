"""Blocks: consecutive samples with the states and the ground truth of the same time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dcrb_ros.schema.arrays import Integers, Samples
from dcrb_ros.schema.simulated_time import nanoseconds
from dcrb_ros.stream.events import Event
from dcrb_ros.stream.states import Account, States, TemperatureReading


@dataclass(frozen=True)
class Truth:
    """Ground truth at one instant: operating point and faults."""

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
    event: Event | None = None
    """The event at this instant; none for the repetition at ``publishing.truth_rate``."""
    background: Mapping[str, float] = field(default_factory=dict)
    """Levels of the excitation of the axle box by other sources than the bearing, by key; they are not faults."""
    thermal: Mapping[str, float] = field(default_factory=dict)
    """Temperatures and heat of bearing and axle box, the time lapse, and how much lubricant is lost, by name with the unit; empty where
    the bearing has neither a thermal network nor faults that change it."""


@dataclass(frozen=True)
class Block:
    """Consecutive samples of the measured waveform and everything else simulated during that time."""

    index: int
    """Index of the first sample since the start; sample ``k`` is taken at ``k / rate``."""
    rate: int
    """Sampling rate [Hz]."""
    acceleration: Samples
    """Measured acceleration of the outer ring in X and Y, shape (samples, 2) [m/s^2]."""
    shaft_angle: Samples
    """Rotation of the inner ring at each sample, wrapped to [0, 2 pi), shape (samples,) [rad]."""
    clean: Samples
    """Acceleration of the outer ring after the anti-alias filter, without any other stage of the chain, shape (samples, 2) [m/s^2]."""
    clipped: int = 0
    """Samples beyond the sensor's range in this block."""
    range: float = 0.0
    """The sensor's range at the end of this block [m/s^2]; 0 if unknown."""
    preview: Samples = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    """Low-passed acceleration for viewers, shape (previews, 2) [m/s^2]."""
    preview_ns: tuple[int, ...] = ()
    """Simulated time of each preview sample [ns]."""
    lost: bool = False
    """Whether the waveform is not published: lost in transmission, or between two bursts."""
    states: tuple[States, ...] = ()
    truths: tuple[Truth, ...] = ()
    temperatures: tuple[TemperatureReading, ...] = ()
    """What the temperature sensors read, once per simulated second."""
    pulse_ns: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    """Time of each pulse of the tacho, shape (pulses,) [ns]."""
    pulse_number: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    """Number of each of these pulses since the start, shape (pulses,)."""
    energy: Account | None = None
    """The energy account at the end of the block; only for blocks with a truth, because it is expensive."""

    def __repr__(self) -> str:
        samples = len(self.acceleration)
        about = f"<Block: {samples} samples at {self.rate / 1e3:g} kHz from {self.index / self.rate:.4f} s, {len(self.states)} states"
        return about + (", lost>" if self.lost else ">")

    @property
    def stamp_ns(self) -> int:
        """Simulated time of the first sample [ns]."""
        return nanoseconds(self.index, self.rate)

    @property
    def end_ns(self) -> int:
        """Simulated time of the first sample after this block [ns]."""
        return nanoseconds(self.index + len(self.acceleration), self.rate)
