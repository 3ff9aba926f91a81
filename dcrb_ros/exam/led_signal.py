"""A recording with known truth after a healthy signal of the same machine, from which a detector learns what healthy is."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Generic, TypeVar

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.schema.arrays import Floats

LEAD = 2.5
"""Longest healthy signal before a recording [s]."""
PIECE = 0.05
"""Length of a block [s]."""
SAME_SPEED = 0.05
"""Relative difference up to which the speed of a healthy signal is made that of the recording [-]."""
LARGEST_FACTOR = 10000
"""Largest denominator of the factor by which it is resampled [-]: the time and the memory for it grow with the factor."""
ROUNDING = 1e-6
"""Rounding error of a number of samples [-]."""
FILTER_ORDER = 8
"""Order of the low-pass filter, which is applied forwards and backwards [-]."""
BAND = 0.42
"""Corner of the low-pass filter of all signals over the sampling rate [-], below the edges that other filters leave behind."""
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
    def samples(self) -> Floats:
        """Return the acceleration [m/s^2], shape (samples,)."""


Judged = TypeVar("Judged", bound=JudgedRecording)


@dataclass(frozen=True, kw_only=True)
class Form:
    """What all signals of a machine and bearing type have in common, so that only the vibration distinguishes healthy from faulty ones."""

    rate: int
    """Sampling rate, the lowest one of the recordings [Hz]."""
    judged: float
    """Length of the part under evaluation [s]."""
    lead: float
    """Length of the healthy signal [s]."""


@dataclass(frozen=True)
class LedSignal(Generic[Judged]):
    """The beginning of a recording after the end of a healthy one, both without their mean and behind one low-pass filter.

    * A healthy signal at nearly the speed of the recording is stretched to that speed, and the shaft turns on without a jump.
    * Levels cannot be compared unless all bearings are known to have been recorded with one gain. Otherwise the healthy signal is scaled
      to the rms of the recording.
    """

    recording: Judged
    lead: Judged | None
    """The recording with the healthy signal at its end, for a measured healthy one itself; None if there is none."""
    form: Form
    bearing: None = None

    @property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""
        return self.recording.orders

    @property
    def sampling_rate(self) -> int:
        """[Hz]"""
        return self.form.rate

    @property
    def _lead_samples(self) -> int:
        """Samples of the healthy signal; none without one."""
        return math.floor(self.form.lead * self.form.rate + ROUNDING) if self.lead else 0

    @property
    def _judged_samples(self) -> int:
        """Samples of the part under evaluation."""
        return math.floor(self.form.judged * self.form.rate + ROUNDING)

    def temperatures(self) -> TemperatureReadings:
        """Return no reading."""
        return TemperatureReadings.none()

    def pieces(self) -> Iterator[Piece]:
        """Yield the blocks of both recordings."""
        rate, speed, samples = self.form.rate, self.recording.speed, np.concatenate(self._signals())
        frequency = np.full(len(samples), speed)
        if self.lead and not self._near:
            frequency[: self._lead_samples] = self.lead.speed
        angle = np.mod(np.cumsum(frequency) * (2.0 * np.pi / rate), 2.0 * np.pi)
        length = max(1, int(PIECE * rate))
        for begin in range(0, len(samples), length):
            part = samples[begin : begin + length].astype(np.float32)
            yield Piece(begin, np.column_stack([part, part]), angle[begin : begin + length].astype(np.float32), 0.0)

    @property
    def _near(self) -> bool:
        """Whether the healthy signal is stretched to the speed of the recording."""
        return self.lead is not None and abs(self.lead.speed / self.recording.speed - 1.0) <= SAME_SPEED

    def _signals(self) -> tuple[Floats, Floats]:
        """Return the healthy signal and the recording after it [m/s^2]."""
        samples, ratio = self.recording.samples(), Fraction(self.form.rate, self.recording.rate)
        judged = self._formed(samples[: math.ceil(self._judged_samples / ratio)], ratio)[: self._judged_samples]
        if self.lead is None:
            return np.zeros(0), judged
        count, ratio = self._lead_samples, Fraction(self.form.rate, self.lead.rate)
        if self._near:
            ratio = (ratio * Fraction(self.lead.speed / self.recording.speed)).limit_denominator(LARGEST_FACTOR)
        given = samples if self.lead is self.recording else self.lead.samples()
        lead = self._formed(given[-math.ceil(count / ratio) :], ratio)[:count]
        healthy, level = float(lead.std()), float(judged.std())
        scaled = not self.recording.gain_known and healthy > 0.0 and level > 0.0
        return lead * (level / healthy) if scaled else lead, judged

    def _formed(self, samples: Floats, ratio: Fraction) -> Floats:
        """Return samples without their mean, at ``ratio`` times their rate, and behind the low-pass filter."""
        from scipy.signal import butter, resample_poly, sosfiltfilt

        formed = samples - samples.mean()
        if ratio != 1:
            formed = resample_poly(formed, ratio.numerator, ratio.denominator)
        return np.asarray(sosfiltfilt(butter(FILTER_ORDER, 2.0 * BAND, output="sos"), formed))

    def expectation(self) -> Expectation:
        """Return what is expected: an alarm in the healthy signal is false, and the last verdict after it counts."""
        onset, end = (count / self.form.rate for count in (self._lead_samples, self._lead_samples + self._judged_samples))
        return expectation(self.recording, end, onset, f"the end of {self.lead.name}" if self.lead else "")


def form_of(recording: Judged, seconds: Mapping[str, float], recordings: Iterable[Judged], longest: float) -> Form:
    """Return the form of all signals of a recording's machine and bearing type, whose lengths by name are ``seconds`` [s].

    A healthy recording provides `LEAD` or, if it is shorter than twice that, half of its length as the healthy signal; the rest is judged.
    Of a faulty one, all is judged.
    """
    alike = [other for other in recordings if _alike(recording, other)]
    leads = {other.name: min(LEAD, 0.5 * seconds[other.name]) for other in alike if other.truth == "healthy"}
    judged = min(longest, *(seconds[other.name] - leads.get(other.name, 0.0) for other in alike))
    return Form(rate=min(other.rate for other in alike), judged=judged, lead=min(leads.values(), default=LEAD))


def healthy_recording(recording: Judged, recordings: Iterable[Judged]) -> Judged | None:
    """Return the healthy recording of the same machine and bearing type at the nearest speed, itself if it is healthy; None without one."""
    if recording.truth == "healthy":
        return recording
    candidates = [other for other in recordings if other.truth == "healthy" and _alike(recording, other)]
    return min(candidates, key=lambda other: (abs(other.speed - recording.speed), other.name), default=None)


def _alike(first: JudgedRecording, second: JudgedRecording) -> bool:
    """Return whether two recordings are of one machine and bearing type, which is known by its orders."""
    return first.machine == second.machine and all(
        math.isclose(a, b, rel_tol=SAME_BEARING)
        for a, b in zip(first.orders.as_dict().values(), second.orders.as_dict().values(), strict=True)
    )


def expectation(recording: JudgedRecording, end: float, onset: float = 0.0, lead: str = "") -> Expectation:
    """Return what is expected of a recording from ``onset`` to ``end`` [s], after the signal ``lead``; ball faults are not required."""
    # Envelope analysis cannot name most ball faults (Smith and Randall 2015), so they enter the statistics only.
    required = recording.truth != "roller"
    return Expectation(recording.name, recording.truth, end, onset, recording.tags, required=required, last_verdict=True, lead=lead)
