"""Waveforms of many configurations, simulated in parallel processes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from dcrb_ros.runtime.arrays import Samples
from dcrb_ros.runtime.processes import cores, in_processes
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation


class Waveform(NamedTuple):
    """Waveform measured by the sensor of one bearing."""

    acceleration: Samples
    """Measured acceleration of the outer ring in X and Y, shape (samples, 2) [m/s^2]."""
    shaft_angle: Samples
    """Rotation of the inner ring at each sample, wrapped to [0, 2 pi), shape (samples,) [rad]."""


def waveform(configuration: Configuration, duration: float) -> Waveform:
    """Return the waveform of a bearing from its settled start over ``duration`` [s].

    Raises:
        ModelFailure: the model leaves its domain.
    """
    blocks = list(Simulation(configuration, waveform_only=True).blocks(duration))
    return Waveform(np.concatenate([block.acceleration for block in blocks]), np.concatenate([block.shaft_angle for block in blocks]))


def simulate_batch(
    configurations: Sequence[Configuration], duration: float, *, workers: int | None = None
) -> Iterator[tuple[int, Waveform]]:
    """Yield the index in ``configurations`` and the waveform of each bearing, in the order of completion.

    Each worker is a process; by default there is one per core. The samples equal those of `waveform` for any number of workers.

    Raises:
        ModelFailure: one of the models leaves its domain; the others are stopped.
    """
    calls = {index: partial(waveform, configuration, duration) for index, configuration in enumerate(configurations)}
    return in_processes(calls, min(workers or cores(), max(len(calls), 1)))
