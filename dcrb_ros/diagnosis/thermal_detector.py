"""The shipped fault detector with the temperature of the bearing beside its vibration.

Without temperatures, and with the rule for the level of vibration off as by default, its diagnoses are those of `FaultDetector`.
"""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.diagnosis.demodulation import NYQUIST_SHARE
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.heat_monitor import LEARNED_WITHIN, LONGEST_PAUSE, HeatMonitor
from dcrb_ros.diagnosis.heat_rule import HeatFinding
from dcrb_ros.diagnosis.hysteresis import Suspicion, probability
from dcrb_ros.diagnosis.registry import HEAT_RULES
from dcrb_ros.diagnosis.rules.starved_noise import StarvedNoise
from dcrb_ros.diagnosis.segments import Segment
from dcrb_ros.schema.arguments import checked_arguments, number
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import COMPONENTS, Verdict, fault_class
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.stream.vehicle_diagnosis import Status

Judged = TypeVar("Judged", Diagnosis, Status)


class ThermalFaultDetector(FaultDetector):
    """A `FaultDetector` that also takes temperatures.

    The verdicts ``lubrication`` and ``overheating`` follow from them. With a fault of the bearing the verdict is ``compound``. They take
    precedence over the verdict ``sensor``, because a faulty accelerometer does not affect the thermometer.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        """Prepare as `FaultDetector`.

        Raises:
            Refusal: as `FaultDetector`, or the rule for the level of vibration has no quarters of the band to compare.
        """
        super().__init__(*arguments, **options)
        p: Any = self.parameters
        if p.starved_noise and len(self._sensor.bands) == 1:
            usable = NYQUIST_SHARE * self.rate
            raise Refusal(
                f"starved_noise = {p.starved_noise:g} dB compares the quarters of the band from {p.band_low:g} to {p.band_high:g} Hz; they "
                f"need band = kurtogram and a band_high of at most {usable:g} Hz, {NYQUIST_SHARE:g} of the sampling rate of "
                f"{self.rate} Hz: set both, or starved_noise = 0"
            )
        self._monitor = HeatMonitor(p, [rule(p) for rule in HEAT_RULES], p.release_margin)
        self._noise, self._loud = StarvedNoise(p), Suspicion()
        """Rule for the level of vibration, and how long the level has been high."""
        self._noise_finding: HeatFinding | None = None
        self._frequency = math.nan
        """Latest shaft frequency [Hz], but for `_angle`; NaN where it is unknown."""
        self._last = math.nan
        """Latest shaft frequency that was known when a temperature was read [Hz]."""
        self._turned_until = 0.0
        """End of the block from which the frequency is known [s]."""
        self._angle: Floats | None = None
        """Angle of a later block from which the frequency is taken when it is needed [rad]."""

    @checked_arguments(time=number, bearing=number, ambient=number, load=number)
    def take_temperature(self, time: float, bearing: float, ambient: float, load: float = math.nan) -> None:
        """Take a reading at a ``time`` [s] of the ``bearing``, at its outer ring or axle box, and of the ``ambient`` air.

        Temperatures are in deg C. ``load`` is that on the bearing [N], NaN where it is unknown. The next diagnosis takes the reading into
        account. Readings need not be regular. During a pause of more than ten minutes the operation of the bearing is unknown, and the
        reading after it is not judged. Such readings and impossible values are counted in the remarks of the diagnosis. While the shaft
        frequency is unknown, and from ten minutes after the latest block, only readings far above the rise that was expected last are taken
        into account: a bearing that cools need not be starved, but one that is hot overheats.
        """
        self._take_angle()
        known = not math.isnan(self._frequency) and time - self._turned_until <= LONGEST_PAUSE
        if known:
            self._last = self._frequency
        model = self._monitor.model
        if known or (not math.isnan(self._last) and bearing - ambient > model.expected + LEARNED_WITHIN * model.deviation):
            self._monitor.update(time, self._last, bearing, ambient, load)

    def update(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any] | None = None) -> Diagnosis | None:
        """Take a block; see `FaultDetector.update`."""
        restarts = self.restarts
        diagnosis, end = super().update(index, acceleration, shaft_angle), (int(index) + len(acceleration)) / self.rate
        if self.restarts != restarts:
            self._monitor.forget()
        if shaft_angle is not None and len(shaft_angle) > 1 and np.isfinite(shaft_angle).all():
            self._angle, self._turned_until = np.array(shaft_angle, np.float64), end
        elif diagnosis is not None:
            self._frequency, self._angle, self._turned_until = diagnosis.shaft_frequency or math.nan, None, end
        return None if diagnosis is None else self._with_noise(self._with_heat(diagnosis))

    def _take_angle(self) -> None:
        """Take the shaft frequency from the angle of the latest block."""
        if self._angle is not None:
            steps = np.diff(np.unwrap(self._angle))
            self._frequency, self._angle = abs(float(steps.mean())) * self.rate / (2.0 * math.pi), None

    def _diagnosed(self, segment: Segment) -> Diagnosis:
        """Return the diagnosis at the end of a segment; without levels, nothing is known about the loss of lubricant."""
        self._noise_finding = None
        return super()._diagnosed(segment)

    def _level_flaw(self, powers: Floats, frequency: float) -> str:
        """Take the levels of a hop for the loss of lubricant, too."""
        flaw = super()._level_flaw(powers, frequency)
        if not flaw:
            # The last of these bands lies below the band of the detector.
            self._noise_finding = self._noise.finding(powers[:-1], frequency, self._hop / self.rate)
        return flaw

    def _with_heat(self, diagnosis: Diagnosis) -> Diagnosis:
        """Return a diagnosis with what the temperature says."""
        counts = {
            "readings were no temperatures of a bearing": self._monitor.rejected,
            f"temperatures followed more than {LONGEST_PAUSE:g} s after the one before, and were not judged": self._monitor.pauses,
        }
        remarks = [f"{number} {words}" for words, number in counts.items() if number]
        judgement = self._monitor.judgement_at(diagnosis.time)
        if judgement is None:
            return dataclasses.replace(diagnosis, remarks=(*diagnosis.remarks, *remarks)) if remarks else diagnosis
        scores, remarks = diagnosis.scores | judgement.scores, [*remarks, judgement.evidence.sentence]
        heated = dataclasses.replace(diagnosis, scores=scores, remarks=(*diagnosis.remarks, *remarks))
        finding = judgement.confirmed
        return dataclasses.replace(with_trouble(heated, finding), faults=(*heated.faults, finding.trouble)) if finding else heated

    def _with_noise(self, diagnosis: Diagnosis) -> Diagnosis:
        """Return a diagnosis with what the level of vibration says; it says nothing beside a fault that explains it."""
        finding = self._noise_finding
        if finding is None or diagnosis.verdict not in ("healthy", "waiting", "lubrication"):
            self._loud = Suspicion()
            return diagnosis
        # As long as a window: lines have had time to appear.
        p, excess = self.parameters, finding.excess
        confirm = max(p.confirm, p.hops)
        loud = self._loud.count(present=excess >= 0.0, absent=excess < -p.release_margin, confirm=confirm, release=p.release)
        scores = {**diagnosis.scores, "lubrication": max(finding.excess, diagnosis.scores.get("lubrication", finding.excess))}
        diagnosis = dataclasses.replace(diagnosis, scores=scores)
        return with_trouble(diagnosis, finding) if loud else diagnosis


class TemperatureFeed:
    """Gives recorded readings to a detector as its signal reaches their times."""

    def __init__(self, readings: TemperatureReadings) -> None:
        """Prepare readings of ambient and outer ring, or of the axle box where no reading has the outer ring."""
        bearing = readings.outer_ring if np.isfinite(readings.outer_ring).any() else readings.box
        known = np.isfinite(bearing) & np.isfinite(readings.ambient)
        self._waiting = deque(zip(*(values[known].tolist() for values in (readings.time, bearing, readings.ambient)), strict=True))

    def give(self, take: Callable[[float, float, float], None], end: float) -> None:
        """Call ``take`` with time [s], bearing and ambient [deg C] of each reading up to the time ``end`` [s] that it has not had."""
        while self._waiting and self._waiting[0][0] <= end + 1e-9:
            take(*self._waiting.popleft())


def temperatures_of(signal: object) -> TemperatureReadings:
    """Return the readings of temperature in a run or recording; none in anything else."""
    readings = getattr(signal, "temperatures", None)
    given: TemperatureReadings | None = readings() if callable(readings) else readings
    return TemperatureReadings.none() if given is None else given


def with_trouble(diagnosis: Judged, finding: HeatFinding) -> Judged:
    """Return a diagnosis, or the status of a bearing, with a trouble beside what it says so far."""
    damaged = diagnosis.verdict in (*COMPONENTS, "compound")
    verdict: Verdict = finding.trouble if not damaged else fault_class([diagnosis.verdict, finding.trouble])
    chance = probability(max(finding.excess, 0.0))
    return dataclasses.replace(
        diagnosis,
        verdict=verdict,
        reason=f"{diagnosis.reason}, and {finding.reason}" if damaged else finding.reason,
        confidence=min(diagnosis.confidence, chance) if damaged else chance,
    )
