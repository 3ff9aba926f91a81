"""Simulated runs that several tests share."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.payload import body_names
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.states import States

PAPER_SPEED = 124.8  # rad/s, printed in Fan et al. 2025, section 2.3.2


@dataclass(frozen=True)
class Run:
    """A simulated run with its blocks joined."""

    configuration: Configuration
    blocks: list[Block]

    @property
    def clean(self) -> npt.NDArray[np.float64]:
        """Acceleration before noise, shape (samples, 2) [m/s^2]."""
        return np.concatenate([block.clean for block in self.blocks]).astype(np.float64)

    @property
    def states(self) -> list[States]:
        """States in the order of time."""
        return [states for block in self.blocks for states in block.states]

    def series(self, field: str) -> npt.NDArray[np.float64]:
        """Return a field of the states, shape (times, bodies)."""
        return np.array([getattr(states, field) for states in self.states])


@functools.cache
def _simulated(duration: float, fault: str, width: float, speed: float, start: str, state_rate: int) -> Run:
    groups: dict[str, Any] = {
        "operating": {"speed": speed, "start": start},
        "publishing": {"state_rate": state_rate},
        "sensor": {"noise_density": 0.0},
    }
    if fault:
        groups["faults"] = {fault: {"width": width}}
    configuration = Configuration.model_validate(groups)
    return Run(configuration, list(Simulation(configuration).blocks(duration)))


def simulated(
    duration: float, *, fault: str = "", width: float = 0.002, speed: float = PAPER_SPEED, start: str = "warm", state_rate: int = 1000
) -> Run:
    """Return a noiseless run; runs with the same arguments are simulated once."""
    return _simulated(duration, fault, width, speed, start, state_rate)


def record(path: Path, configuration: Configuration, blocks: Iterable[Block]) -> Path:
    """Write the blocks of a bench to a recording, and return its path."""
    with Recorder(path, configuration, body_names(configuration)) as recorder:
        for block in blocks:
            recorder.write(block)
    return path
