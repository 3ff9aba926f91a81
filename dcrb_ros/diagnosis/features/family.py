"""What a family of features takes and gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.schema.arrays import Floats


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of equal length of one axis of a signal, and what several families need of them."""

    acceleration: Floats
    """Shape (windows, samples), without their means [m/s^2]."""
    turns: Floats
    """Turns of the shaft since the beginning of the window, rising, shape (windows, samples) [-]."""
    rate: int
    """Sampling rate [Hz]."""
    orders: Orders
    """Characteristic orders of the bearing."""
    shared: dict[str, object] = field(default_factory=dict)
    """Results that a family leaves for the next ones, by name."""

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of windows and of samples of each."""
        windows, samples = self.acceleration.shape
        return int(windows), int(samples)

    @cached_property
    def spectrum(self) -> Floats:
        """One-sided power of each line, whose sum is the mean square, shape (windows, lines) [(m/s^2)^2]; with a Hann window."""
        samples = self.shape[1]
        taper = np.hanning(samples + 1)[:-1]
        power = np.abs(np.fft.rfft(self.acceleration * taper, axis=1)) ** 2 * (2.0 / (samples * float(taper @ taper)))
        power[:, 0] *= 0.5
        return np.asarray(power, np.float64)

    @cached_property
    def shaft_frequency(self) -> Floats:
        """Mean frequency of the shaft, shape (windows,) [Hz]."""
        return np.asarray((self.turns[:, -1] - self.turns[:, 0]) * (self.rate / (self.shape[1] - 1)), np.float64)


class FeatureFamily(NamedTuple):
    """Features that are computed together."""

    name: str
    names: Callable[[int], tuple[str, ...]]
    """Names of the features at a sampling rate [Hz]."""
    compute: Callable[[Windows], Floats]
    """Returns the features of windows, shape (windows, features)."""


FAULTS = ("BPFO", "BPFI", "2BSF", "FTF")
"""Fundamentals of the faults: a roller defect strikes both raceways, at twice BSF."""

SLIP = 0.02
"""Largest departure of a fault's lines from their kinematic order [-]."""


def fault_orders(orders: Orders) -> dict[str, float]:
    """Return the fundamental order of each of `FAULTS` [-]."""
    return {"BPFO": orders.bpfo, "BPFI": orders.bpfi, "2BSF": 2.0 * orders.bsf, "FTF": orders.ftf}
