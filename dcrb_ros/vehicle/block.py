"""What a vehicle yields: a block of every box, and the truth about the vehicle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from dcrb_ros.stream.block import Block
from dcrb_ros.vehicle.frame import TrackEvent


@dataclass(frozen=True)
class VehicleTruth:
    """What happened to a vehicle during a block."""

    time_ns: int
    """Simulated time at the start [ns]."""
    speed: float
    """Speed of the vehicle at the start of the last frame [m/s]."""
    place: float
    """Place of the middle of the bogie on the track at the start of the last frame [m]."""
    load: Mapping[str, float]
    """Load of each box at the end of the last frame, downwards [N]."""
    parts: Mapping[str, tuple[float, float, float]]
    """Acceleration of each box by its own bearing, the others, and track and wheels, rms of both axes [m/s^2]."""
    creep: Mapping[str, float]
    """Share by which each wheelset turned faster than it rolled at the start of the last frame; below zero in a slide [-]."""
    events: tuple[TrackEvent, ...]
    """Joints, crossings and flats that wheels met, and slides that began or ended."""
    silent: Mapping[str, str]
    """Boxes that are silent, and why: their model failed, or their sensor is swapped with that of a box whose model failed."""
    commanded: Mapping[str, float] = field(default_factory=dict)
    """The commands given before the first frame that was planned for the block, by the names of `RANGES`."""
    commands: tuple[tuple[str, Any], ...] = ()
    """Those, and the changes of wheels and slides by their keys, that were given since the block before."""
    curvature: float = 0.0
    """The one commanded last, which the track has from the end of the frame after the last one on [1/m]."""


@dataclass(frozen=True)
class VehicleBlock:
    """A block of every box, and the truth about the vehicle."""

    boxes: Mapping[str, Block]
    truth: VehicleTruth
    end_ns: int
    """Simulated time of its end [ns]."""
