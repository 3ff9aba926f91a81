"""What flows from a source to the sinks: blocks of samples with the states and the truth that belong to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dcrb_ros.bearing.states import Account, States
from dcrb_ros.runtime.arrays import Samples
from dcrb_ros.runtime.timestamps import nanoseconds


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
