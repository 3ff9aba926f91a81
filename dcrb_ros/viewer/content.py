"""What the viewer shows of a recording, as arrays over time."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.bearing.states import BodyNames
from dcrb_ros.runtime.arrays import Floats, Samples
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.simulation.block import Truth

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.detector import Diagnosis

Times = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Subject:
    """What the messages are about."""

    title: str
    bearing: Bearing
    """Of the bench; of imported data it means nothing."""
    orders: Orders
    rate: int
    """Sampling rate [Hz]."""
    imported: bool = False
    """Whether these are data from elsewhere."""

    @property
    def bodies(self) -> BodyNames:
        """Rows and rollers."""
        return BodyNames(self.bearing.rows, self.bearing.rollers_per_row)


@dataclass(frozen=True)
class Waveform:
    """The measured waveform, every sample of it."""

    time_ns: Times
    acceleration: Samples
    """Acceleration in X and Y, shape (samples, 2) [m/s^2]."""
    shaft_angle: Samples
    """Rotation of the inner ring, wrapped to a turn [rad]."""
    rate: int
    """Sampling rate [Hz]."""


@dataclass(frozen=True)
class Motion:
    """The bodies over time; arrays of shape (times, names)."""

    time_ns: Times
    azimuth: Floats
    """Azimuth of rollers and first pockets, rotation of the inner ring [rad]."""
    speed: Floats
    """Spin of rollers, rotation of cages and inner ring [rad/s]."""
    force: Floats
    """Normal force at the inner raceway [N]."""


@dataclass(frozen=True)
class Series:
    """Named numbers over time, as a JointState topic carries them; values of shape (times, names)."""

    time_ns: Times
    names: tuple[str, ...]
    values: Floats


@dataclass(frozen=True)
class Verdict:
    """What the detector said at one time."""

    time_ns: int
    name: str
    """The verdict: healthy, outer_ring, inner_ring ..."""
    level: int
    """0 OK, 1 warning, 2 error, as in diagnostic_msgs."""
    evidence: Mapping[str, str]


@dataclass(frozen=True)
class Judgement:
    """What fault detectors say of the waveform."""

    indicators: Series | None
    """Levels at the fault orders [dB], as recorded or else by the detector with its default parameters."""
    verdicts: tuple[Verdict, ...]
    """As recorded, or else by that detector."""
    diagnoses: tuple[Diagnosis, ...]
    """What that detector says, with its spectra."""


@dataclass(frozen=True)
class Content:
    """All that is shown of one recording."""

    title: str
    bearing: Bearing
    """Of the bench; of imported data it means nothing."""
    orders: Orders
    bodies: BodyNames
    waveform: Waveform
    judging: Future[Judgement]
    """What the detectors say, as soon as it is known: finding it out takes as long as all the rest."""
    motion: Motion | None = None
    truths: tuple[Truth, ...] = ()
    features: Series | None = None
    imported: bool = False
    """Whether these are data from elsewhere."""

    @property
    def judgement(self) -> Judgement:
        """What the detectors say; waits until it is known."""
        return self.judging.result()

    @property
    def start_ns(self) -> int:
        """Simulated time of the first sample [ns]."""
        return int(self.waveform.time_ns[0])

    @property
    def end_ns(self) -> int:
        """Simulated time of the last sample [ns]."""
        return int(self.waveform.time_ns[-1])
