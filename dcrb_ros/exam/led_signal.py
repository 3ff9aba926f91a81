"""A recording with known truth after a healthy one of the same machine, from which a detector learns what healthy is."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Generic, TypeVar

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.schema.arrays import Floats

LEAD = 5.0
"""Longest part of a healthy recording before the one under evaluation [s]."""
PIECE = 0.05
"""Length of a block [s]."""
SAME_BEARING = 1e-3
"""Largest relative difference between the orders of one bearing in two rows of the table [-]."""


@dataclass(frozen=True, kw_only=True)
class JudgedRecording(ABC):
    """A recording of one axis with known truth at a constant speed, measured or simulated, as a table describes it."""

    name: str
    rig: str
    machine: str
    """Physical rig: a rig that is recorded in two ways is one machine."""
    truth: str
    """Correct verdict."""
    rate: int
    """[Hz]"""
    speed: float
    """Speed of the shaft [Hz]."""
    orders: Orders
    gain_known: bool = False
    """Whether all bearings of the machine are known to have been recorded with one gain, so that their levels can be compared."""

    @property
    def tags(self) -> Mapping[str, str | float]:
        """Tags of the scenario; see `Expectation.tags`."""
        return {"rig": self.rig}

    @abstractmethod
    def longest_part(self, seconds: float) -> Floats:
        """Return the acceleration of the first ``seconds`` [m/s^2], shape (samples,)."""

    def samples_within(self, seconds: float) -> int:
        """Return the number of samples of that part."""
        return len(self.longest_part(seconds))


Judged = TypeVar("Judged", bound=JudgedRecording)


@dataclass(frozen=True)
class LedSignal(Generic[Judged]):
    """A recording after a healthy one; the shaft turns on without a jump, at the speed of each.

    Levels cannot be compared unless all bearings are known to have been recorded with one gain. Otherwise the healthy recording is scaled
    to the rms of the other one.
    """

    recording: Judged
    lead: Judged | None
    """The healthy recording; None if there is none."""
    longest: float
    """Longest part of the recording under evaluation [s]."""
    longest_lead: float = LEAD
    """Longest part of the healthy recording [s]."""
    bearing: None = None

    @property
    def recordings(self) -> list[Judged]:
        """The healthy recording, if there is one, and the other one."""
        return [self.recording] if self.lead is None else [self.lead, self.recording]

    @property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""
        return self.recording.orders

    @property
    def sampling_rate(self) -> int:
        """[Hz]"""
        return self.recording.rate

    def temperatures(self) -> TemperatureReadings:
        """Return no reading."""
        return TemperatureReadings.none()

    def pieces(self) -> Iterator[Piece]:
        """Yield the blocks of both recordings."""
        rate, before, values = self.recording.rate, self._before(), self.recording.longest_part(self.longest)
        samples = np.concatenate([before, values])
        frequency = np.repeat([self.lead.speed if self.lead else 0.0, self.recording.speed], [len(before), len(values)])
        angle = np.mod(np.cumsum(frequency) * (2.0 * np.pi / rate), 2.0 * np.pi)
        length = max(1, int(PIECE * rate))
        for begin in range(0, len(samples), length):
            part = samples[begin : begin + length].astype(np.float32)
            yield Piece(begin, np.column_stack([part, part]), angle[begin : begin + length].astype(np.float32), 0.0)

    def _before(self) -> Floats:
        """Return the samples of the healthy recording at the sampling rate of the other one [m/s^2]."""
        from scipy.signal import resample_poly

        if self.lead is None:
            return np.zeros(0)
        signal, rate = self.lead.longest_part(self.longest_lead), self.recording.rate
        if self.lead.rate != rate:
            signal = np.asarray(resample_poly(signal, rate, self.lead.rate))
        return signal if self.recording.gain_known else signal * self._scale(signal)

    def _scale(self, lead: Floats) -> float:
        """Return the factor that gives the healthy recording the rms of the other one; 1 if one of them is constant."""
        healthy, judged = float(lead.std()), float(self.recording.longest_part(self.longest).std())
        return judged / healthy if healthy > 0.0 and judged > 0.0 else 1.0

    def expectation(self) -> Expectation:
        """Return what is expected: an alarm in the healthy lead is false, and the last verdict after it counts."""
        rate, before, lead = self.recording.rate, 0, ""
        if self.lead is not None:  # resampled to the other rate
            before, lead = math.ceil(Fraction(self.lead.samples_within(self.longest_lead) * rate, self.lead.rate)), self.lead.name
        return expectation(self.recording, (before + self.recording.samples_within(self.longest)) / rate, before / rate, lead)


def healthy_lead(recording: Judged, recordings: Sequence[Judged]) -> Judged | None:
    """Return another, healthy recording of the same machine and bearing type at the nearest speed; None if there is none.

    A bearing type is known by its orders. A higher sampling rate is reduced, so that rates may differ; a lower one cannot be used.
    """
    candidates = [
        other
        for other in recordings
        if other.truth == "healthy"
        and other.name != recording.name
        and other.machine == recording.machine
        and other.rate >= recording.rate
        and _same_bearing(other.orders, recording.orders)
    ]
    return min(candidates, key=lambda other: (abs(other.speed - recording.speed), other.name), default=None)


def _same_bearing(first: Orders, second: Orders) -> bool:
    pairs = zip(first.as_dict().values(), second.as_dict().values(), strict=True)
    return all(math.isclose(a, b, rel_tol=SAME_BEARING) for a, b in pairs)


def expectation(recording: JudgedRecording, end: float, onset: float = 0.0, lead: str = "") -> Expectation:
    """Return what is expected of a recording from ``onset`` to ``end`` [s], after the recording ``lead``; ball faults are not required."""
    # Envelope analysis cannot name most ball faults (Smith and Randall 2015), so they enter the statistics only.
    required = recording.truth != "roller"
    return Expectation(recording.name, recording.truth, end, onset, recording.tags, required=required, last_verdict=True, lead=lead)
