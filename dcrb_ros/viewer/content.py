"""The content of a recording as the viewer shows it: arrays over time."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.schema.verdicts import title_of
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.stream.block import Truth
from dcrb_ros.stream.states import BodyNames

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from dcrb_ros.diagnosis.detector import Diagnosis

Times = npt.NDArray[np.int64]
OverTime = TypeVar("OverTime", bound="DataclassInstance")


def joined(before: OverTime | None, after: OverTime, *names: str, last: int = 0) -> OverTime:
    """Return two consecutive parts as one, whose arrays ``names`` are over time; of these, the ``last`` entries, or all if it is 0."""
    if before is None:
        return after
    arrays: dict[str, Any] = {name: np.concatenate([getattr(before, name), getattr(after, name)])[-last:] for name in names}
    return replace(after, **arrays)


@dataclass(frozen=True)
class BenchInfo:
    """The bench or the measurement from which the messages come."""

    title: str
    bearing: Bearing
    """Bearing of the bench; without meaning for imported data."""
    orders: Orders
    rate: int
    """Sampling rate [Hz]."""
    imported: bool = False
    """Whether the data were measured elsewhere and imported."""
    pulses_per_turn: int = 0
    """Pulses of the tacho per turn of the shaft; 0 without a tacho."""

    @property
    def bodies(self) -> BodyNames:
        """Rows and rollers."""
        return BodyNames(self.bearing.rows, self.bearing.rollers_per_row)


@dataclass(frozen=True)
class TimedWaveform:
    """All samples of the measured waveform."""

    time_ns: Times
    acceleration: Samples
    """Acceleration in X and Y, shape (samples, 2) [m/s^2]."""
    shaft_angle: Samples
    """Rotation of the inner ring within one turn, shape (samples,) [rad]."""
    rate: int
    """Sampling rate [Hz]."""


@dataclass(frozen=True)
class Motion:
    """The states of the bodies over time; arrays of shape (times, bodies)."""

    time_ns: Times
    azimuth: Floats
    """Azimuth of rollers and first pockets, rotation of the inner ring [rad]."""
    speed: Floats
    """Spin of rollers, rotation speed of cages and inner ring [rad/s]."""
    force: Floats
    """Normal force at the inner raceway [N]."""


@dataclass(frozen=True)
class Series:
    """Named numbers over time, as published in JointState messages; values of shape (times, names)."""

    time_ns: Times
    names: tuple[str, ...]
    values: Floats


@dataclass(frozen=True)
class Verdict:
    """A verdict of the detector at one time."""

    time_ns: int
    name: str
    """Verdict, such as healthy or outer_ring."""
    level: int
    """0 for OK, 1 for a warning, 2 for an error, as in diagnostic_msgs."""
    evidence: Mapping[str, str]
    scores: Mapping[str, float] = field(default_factory=dict)
    """Evidence for a fault of each component relative to its threshold [dB]."""

    @property
    def title(self) -> str:
        """The verdict in words."""
        return title_of(self.name, self.scores)


@dataclass(frozen=True)
class DetectorOutput:
    """The output of fault detectors for the waveform."""

    indicators: Series | None
    """Levels at the fault orders [dB]: as recorded, otherwise of the shipped detector with its default parameters."""
    verdicts: tuple[Verdict, ...]
    """As recorded, otherwise of the shipped detector."""
    diagnoses: tuple[Diagnosis, ...]
    """Diagnoses of the shipped detector, with its spectra."""


@dataclass(frozen=True, kw_only=True)
class Content(BenchInfo):
    """Everything shown of one recording."""

    waveform: TimedWaveform
    pending_output: Future[DetectorOutput]
    """Output of the detectors, computed in the background since it takes as long as everything else."""
    motion: Motion | None = None
    truths: tuple[Truth, ...] = ()
    features: Series | None = None
    lubrication: Series | None = None
    """Films, traction and friction, by the names of `dcrb_ros.messages.topics.lubrication_state`."""
    tacho: Series | None = None
    """Speed of the shaft from pulse to pulse of the tacho [rad/s]."""

    @property
    def detector_output(self) -> DetectorOutput:
        """Output of the detectors; waits until it is available."""
        return self.pending_output.result()

    @property
    def start_ns(self) -> int:
        """Simulated time of the first sample [ns]."""
        return int(self.waveform.time_ns[0])

    @property
    def end_ns(self) -> int:
        """Simulated time of the last sample [ns]."""
        return int(self.waveform.time_ns[-1])
