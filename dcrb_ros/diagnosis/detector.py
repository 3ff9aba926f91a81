"""The reference fault detector: blocks of samples in, diagnoses out, with bounded memory.

For every hop, the rules for the sensor look at the samples and at the levels of several bands. The squared envelopes of the bands are
resampled over the angle of the shaft. From the hops of a window follow the squared envelope spectra, in which the rules for the bearing
look for the lines of each fault. Their findings are combined to a verdict.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.baseline_learning import BaselineLearner
from dcrb_ros.diagnosis.combination import Combination
from dcrb_ros.diagnosis.demodulation import Demodulator, detector_bands, kurtosis
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence, SharedSearch, highest_searched
from dcrb_ros.diagnosis.healthy_baseline import HealthyBaseline, read_baseline
from dcrb_ros.diagnosis.hysteresis import Hysteresis, confidence, least_evidence, shortfall, strongest_of
from dcrb_ros.diagnosis.order_spectrum import HARMONICS, SHAFT_SIDEBANDS, OrderSpectrum, order_spectra
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.registry import BEARING_RULES
from dcrb_ros.diagnosis.rule import BearingRule, Finding, LineRule, found_lines
from dcrb_ros.diagnosis.segments import Segment, Segmenter
from dcrb_ros.diagnosis.sensor_check import SensorCheck
from dcrb_ros.diagnosis.speed_estimation import estimated_frequency
from dcrb_ros.diagnosis.trend import Trend
from dcrb_ros.diagnosis.window import MOST_BINS, REFERENCE_FREQUENCY, SLOWEST, Window, margin_samples
from dcrb_ros.schema.arguments import checked_arguments, of_type
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.numbers import sampling_rate
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import CHARACTERISTIC, Component, Verdict
from dcrb_ros.stream.diagnosis import Diagnosis, Spectrum

__all__ = ["Diagnosis", "FaultDetector"]

DEFAULTS = DetectorParameters()

MARGIN_PERIODS = 10.0
"""Periods of the lowest frequency on either side of a hop that its envelope depends on."""
LARGEST_INDEX = 2**53
"""Largest number of a sample [-]: times are numbers of double precision."""
NO_SPEED = "the speed cannot be estimated"
"""Part of the reason for no verdict without a shaft angle."""
BINS_PER_ORDER = 3
"""Bins per turn relative to the highest order [-]; 2 is the Nyquist rate."""


def check_parameters(parameters: DetectorParameters, baseline: HealthyBaseline | None = None) -> HealthyBaseline | None:
    """Check what needs neither bearing nor sampling rate; return the ``baseline``, without one that of the file that the parameters name.

    Raises:
        Refusal: the parameters do not fit each other, or the file is no baseline.
    """
    p: Any = parameters
    least = 2.0 * MARGIN_PERIODS / (0.5 * p.band_low)  # the octave below the band has the longest margins
    if p.hop < least:
        raise _short_hop(p, least)
    if p.window < p.hop:
        raise Refusal(f"window = {p.window:g} s is below hop = {p.hop:g} s: make the window longer or the hop shorter")
    if p.slowest >= p.fastest:
        raise Refusal(f"slowest = {p.slowest:g} Hz is not below fastest = {p.fastest:g} Hz: lower slowest or raise fastest")
    if (rise := p.heat_rise - 2.0 * p.heat_rise_deviation) >= p.heat_most:
        raise Refusal(
            f"heat_rise = {p.heat_rise:g} K less twice heat_rise_deviation is {rise:g} K, not below heat_most = {p.heat_most:g} K, so that "
            "every bearing would be too hot: lower heat_rise or raise heat_most"
        )
    return baseline if baseline is not None or not p.baseline else read_baseline(Path(p.baseline))


def _short_hop(parameters: DetectorParameters, least: float) -> Refusal:
    p = parameters
    return Refusal(f"hop = {p.hop:g} s is below {least:.2g} s, the least for a band from {p.band_low:g} Hz: make it longer")


class FaultDetector:
    """Diagnoses a bearing from blocks of samples, hop by hop.

    The memory is bounded by one window and the longest gap that is bridged. The diagnoses do not depend on the length of the blocks, except
    that `update` returns only the last one of a block that is longer than a hop.
    """

    @checked_arguments(orders=of_type(Orders), parameters=of_type(DetectorParameters), baseline=of_type(HealthyBaseline, type(None)))
    def __init__(
        self,
        orders: Orders,
        rate: int,
        parameters: DetectorParameters = DEFAULTS,
        *,
        sensor_range: float = 0.0,
        baseline: HealthyBaseline | None = None,
    ) -> None:
        """Prepare for a bearing with characteristic ``orders``, sampled at ``rate`` [Hz].

        ``sensor_range`` is the range of the sensor [m/s^2], 0 if it is not known; it may be changed later. ``baseline`` has the lines of
        the healthy bearing; without it, that of the file that the parameters name is used, if they name one.

        Raises:
            Refusal: the parameters do not fit each other or the sampling rate, or the baseline is of another bearing.
        """
        p = parameters
        self.orders, self.parameters, self.sensor_range = orders, parameters, sensor_range
        self.rate = rate = sampling_rate(rate, "the signal")
        self.band, self._high, self._bands = detector_bands(rate, p.band_low, p.band_high, divided=p.band == "kurtogram")
        below = self._bands[-1]
        self._hop = p.hop_samples(rate)
        self._margin = margin_samples(rate, below.low, MARGIN_PERIODS)
        if self._hop < 2 * self._margin:  # which is rounded up to samples
            raise _short_hop(p, 2 * self._margin / rate)
        self._baseline = check_parameters(p, baseline)
        self._highest_order = (1.0 + p.slip) * (
            HARMONICS[-1] * max(2.0 * orders.bpfo, 2.0 * orders.bpfi, 2.0 * orders.bsf) + SHAFT_SIDEBANDS[-1]
        )
        self._segmenter = Segmenter(self._hop, self._margin, p.gap_samples(rate))
        demodulator = Demodulator(self._bands, rate, self._hop + 2 * self._margin, p.whitening)
        bins = math.ceil(BINS_PER_ORDER * self._highest_order)
        self._window = Window(demodulator, rate, self._hop, self._margin, bins, p.hops, p.speed_exponent)
        self._needed = min(p.least_window, p.window) - 0.5 * p.hop
        self._sensor = SensorCheck(p, rate, self._hop, self._bands)
        self.rules: list[BearingRule[Any]] = [rule(p) for rule in BEARING_RULES]
        """Rules for the bearing."""
        self.learner: BaselineLearner | None = None
        """Takes the evidence of every judgement, if there is one."""
        self.begin = 0
        """Index of the first sample since the start, a restart or the last gap that was not bridged."""
        if self._baseline is not None:
            self._baseline.check(orders, rate, p)
            for each in self.rules:
                each.take_baseline(self._baseline)
        self._combination = Combination(self.rules, p.release_margin)
        self._hysteresis = Hysteresis(p.confirm, p.release, p.release_margin, p.persist)
        self._trend = Trend(p.trend_time, p.hop)

    @property
    def gaps(self) -> int:
        """Gaps in the signal so far."""
        return self._segmenter.counts.gaps

    @property
    def restarts(self) -> int:
        """Restarts of the signal so far."""
        return self._segmenter.counts.restarts

    @property
    def clipped(self) -> int:
        """Clipped samples so far."""
        return self._sensor.clipped

    def take_bearing(self, bearing: object) -> None:
        """Take the geometry of the bearing as a `dcrb_ros.Bearing` or a mapping of its fields; rules may have limits for it."""
        for rule in self.rules:
            rule.take_bearing(bearing)

    @checked_arguments(index=of_type(int, np.integer), acceleration=of_type(np.ndarray), shaft_angle=of_type(np.ndarray, type(None)))
    def update(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any] | None = None) -> Diagnosis | None:
        """Take the block that begins with sample ``index``; return a diagnosis if the block completes a hop.

        ``acceleration`` has shape (samples, axes) [m/s^2], ``shaft_angle`` (samples,) [rad]; without a tachometer, omit it or pass NaN.

        Raises:
            Refusal: arrays of another shape or type, other axes than those of the baseline, or an index beyond `LARGEST_INDEX`. The
                detector continues with the next block.
        """
        if abs(index) > LARGEST_INDEX:
            raise Refusal(f"index has {len(str(abs(index)))} digits, but the number of a sample is at most {LARGEST_INDEX}: count samples")
        diagnosis = None
        if self._baseline is not None and acceleration.ndim == 2:
            self._baseline.check_axes(acceleration)
        for segment in self._segmenter.add(index, acceleration, shaft_angle):
            diagnosis = self._diagnosed(segment)
        return diagnosis

    def _diagnosed(self, segment: Segment) -> Diagnosis:
        """Return the diagnosis at the end of a segment."""
        if segment.first:
            self.begin = segment.last + 1 - self._hop
            self._window.clear()
            self._hysteresis.reset()
            self._sensor.restart()
        turned, p = self._turned(segment), self.parameters
        # Whether the bearing turns fast enough to be diagnosed; without a shaft angle it is assumed to.
        turning = turned is None or turned >= p.least_turns * p.hop / p.window
        inside = segment._replace(acceleration=self._inside(segment.acceleration), missing=self._inside(segment.missing))
        flaw = self._sensor.flaw_of_samples(inside, turned or 0.0, self.sensor_range, turning=turning)
        hop = self._window.add(segment, self.parameters.fastest, useless=bool(flaw))
        if hop and turning and not flaw:
            # Without a shaft angle a level may have fallen with the speed: levels are not compared.
            frequency = hop.turns * self.rate / self._hop if self._window.tracked else 0.0
            flaw = self._level_flaw(hop.powers[self._sensor.bands], frequency)
        self._sensor.remember(flaw)
        if self._sensor.flaw:
            self._hysteresis.reset()
            return self._without_verdict(segment.last, "sensor", self._sensor.flaw)
        missing = self._what_is_missing()
        return self._without_verdict(segment.last, "waiting", missing) if missing else self._judged(segment.last)

    def _level_flaw(self, powers: Floats, frequency: float) -> str:
        """Return the first flaw of the sensor that a rule finds in the levels, or nothing."""
        return self._sensor.flaw_of_levels(powers, frequency)

    def _inside(self, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the part of a segment's array without the margins."""
        return array[self._margin : self._margin + self._hop]

    def _turned(self, segment: Segment) -> float | None:
        """Return the turns of the shaft within a hop [-], None without a shaft angle."""
        if segment.turns is None:
            return None
        turns = self._inside(segment.turns)
        return abs(float(turns[-1] - turns[0]))

    def _what_is_missing(self) -> str:
        """Return why there is no verdict yet, or nothing."""
        p, window = self.parameters, self._window
        if window.reversed:
            return "the shaft reversed within the window"
        if window.excessive_bins:
            return (
                f"at the speed of the shaft, the lines up to order {self._highest_order:.0f} need {window.excessive_bins:.0f} bins in a "
                f"window, more than {MOST_BINS}: check the shaft angle and the orders"
            )
        seconds = len(window) * self._hop / self.rate
        if seconds < self._needed:
            return f"{seconds:.1f} s of the {p.least_window:g} s that a verdict needs have arrived"
        if window.tracked and window.turns < p.least_turns:
            return f"the shaft made {window.turns:.2g} revolutions in {seconds:g} s, but a verdict needs {p.least_turns:g}"
        if window.missing_share > p.most_missing:
            return f"{100.0 * window.missing_share:.0f} % of the window is missing, more than the {100.0 * p.most_missing:.0f} % allowed"
        return ""

    def _without_verdict(self, last: int, verdict: Verdict, reason: str) -> Diagnosis:
        """Return a diagnosis without evidence on the bearing."""
        return Diagnosis(
            last,
            last / self.rate,
            verdict,
            reason,
            shaft_frequency=self._window.frequency if self._window.tracked else 0.0,
            gaps=self.gaps,
            clipped=self.clipped,
            baseline=self._baseline_used(),
            remarks=self._remarks(),
        )

    def _judged(self, last: int) -> Diagnosis:
        """Return the diagnosis from the squared envelope spectra of the window."""
        p = self.parameters
        envelopes, missing = self._window.envelopes()
        highest = max(self._highest_order, highest_searched(self.orders, p.slip)) if self._window.tracked else math.inf
        spectra = order_spectra(envelopes, missing, self._window.bins_per_turn, highest)
        frequency = self._window.frequency
        if not self._window.tracked:
            estimate = estimated_frequency((spectra[0], spectra[-1]), p.fastest, self.orders, p.slowest, p.fastest)
            if estimate.score < p.speed_score or estimate.rival > p.speed_rival:
                why = (
                    f"{estimate.frequency:.2f} Hz has a score of {estimate.score:.0f} dB, another frequency has {estimate.rival:.0%} of it"
                )
                return self._without_verdict(last, "waiting", f"there is no shaft angle, and {NO_SPEED} from the signal: {why}")
            frequency = estimate.frequency
            spectra = [_rescaled(spectrum, p.fastest / frequency, self._scale(frequency)) for spectrum in spectra]
        evidence = self._evidence(spectra, frequency)
        selected = int(np.argmax(kurtosis(envelopes[:-1]))) if p.band == "kurtogram" else 0
        return self._concluded(last, evidence, evidence.bands[selected])

    def _evidence(self, spectra: list[OrderSpectrum], frequency: float) -> Evidence:
        """Return the evidence in the spectra of all bands over orders at a shaft frequency [Hz]."""
        search = SharedSearch(spectra, self.orders, self.parameters.slip)
        bands = [BandEvidence(band, search, number) for number, band in enumerate(self._bands)]
        return Evidence(bands, self.band, self._high, frequency, self.parameters.hop)

    def _scale(self, frequency: float) -> float:
        """Return the squared envelope at a shaft frequency [Hz] relative to that at the reference frequency [-]."""
        return float((max(frequency, SLOWEST) / REFERENCE_FREQUENCY) ** (2.0 * self.parameters.speed_exponent))

    def _concluded(self, last: int, evidence: Evidence, selected: BandEvidence) -> Diagnosis:
        """Return the diagnosis from the evidence; the spectrum of the ``selected`` band is published."""
        findings = self._combination.findings(evidence)
        excess = {component: finding.excess for component, finding in findings.items()}
        least = self._least_evidence()
        verdict = self._hysteresis.verdict(excess, least)
        confirmed, time = self._hysteresis.confirmed, last / self.rate
        severity = self._severity(evidence, confirmed, findings)
        if self.learner is not None:
            self.learner.add(evidence, self.rules, verdict, time)
        spectrum_remark = f"the squared envelope spectrum is that of the band from {selected.band}"
        return dataclasses.replace(
            self._without_verdict(last, verdict, self._reason(verdict, findings, least)),
            confidence=confidence(verdict, confirmed, excess),
            levels={CHARACTERISTIC[component]: level for component, level in self._combination.levels.items()},
            shaft_frequency=evidence.shaft_frequency,
            spectrum=self._published(selected.spectrum, evidence.shaft_frequency),
            scores=excess,
            faults=tuple(confirmed),
            lines={component: lines for component, finding in findings.items() if (lines := found_lines(finding)) is not None},
            severity=severity,
            trend=self._trend.slope(time, verdict, severity),
            remarks=self._remarks(spectrum_remark),
            spectrum_remark=spectrum_remark,
        )

    def _least_evidence(self) -> dict[Component, float]:
        """Return the evidence that counts for each component [dB]: it depends on the length of the signal in the window."""
        p = self.parameters
        least = least_evidence(p.confirm, len(self._window) * self._hop / self.rate, p.alarm_evidence)
        return {rule.component: max(least, rule.healthy_evidence(self.orders)) for rule in self.rules}

    def _severity(self, evidence: Evidence, confirmed: list[Component], findings: Mapping[Component, Finding]) -> float:
        """Return the size of the largest lines of confirmed faults in the whole band, by the rules that found them [m/s^2]."""
        own = {rule.component: rule for rule in self.rules if isinstance(rule, LineRule)}
        rules = filter(None, (findings[component].rule or own.get(component) for component in confirmed))
        lines = (rule.family(evidence.bands[0], comb) for rule in rules for comb in rule.combs(self.orders))
        return max((math.sqrt(each.amplitude) for each in lines), default=0.0)

    def _reason(self, verdict: Verdict, findings: dict[Component, Finding], least: Mapping[Component, float]) -> str:
        """Return the evidence for a verdict in words."""
        components = self._hysteresis.confirmed or (self._hysteresis.suspected if verdict == "waiting" else [])
        reasons = ", and ".join(findings[component].reason for component in components)
        if components and verdict != "waiting":
            return reasons
        excess = {component: finding.excess for component, finding in findings.items()}
        strongest = strongest_of(excess, least)
        lacking = shortfall(excess[strongest], least.get(strongest, 0.0))
        if verdict == "waiting":
            return f"to be confirmed by the next hop: {reasons or lacking}"
        return f"{lacking}; {findings[strongest].reason}"

    def _published(self, spectrum: OrderSpectrum, frequency: float) -> Spectrum:
        """Return the part of a spectrum that is published, as amplitudes at the present shaft frequency [Hz]."""
        kept, scale = spectrum.orders <= self._highest_order, self._scale(frequency)
        amplitude = np.sqrt(spectrum.amplitude[kept] * scale)
        amplitude[0] = math.sqrt(spectrum.mean * scale)
        return spectrum.orders[kept], amplitude

    def _baseline_used(self) -> str:
        """Return which baseline is used, in words, or nothing."""
        if self._baseline is not None:
            return self._baseline.sentence(self._window.frequency if self._window.tracked else 0.0)
        return "; ".join(rule.remark for rule in self.rules if rule.remark)

    def _remarks(self, *more: str) -> tuple[str, ...]:
        """Return the remarks of a diagnosis."""
        counts = self._segmenter.counts
        irregularities = {
            "samples lost in gaps": counts.lost,
            "samples arrived twice or too late and were ignored": counts.repeated,
            "samples are not finite numbers": counts.not_finite,
            "restarts of the signal": counts.restarts,
            "clipped samples": self.clipped,
        }
        remarks = [f"{number} {words}" for words, number in irregularities.items() if number]
        if not self._window.tracked:
            remarks.append("no shaft angle: the speed is estimated from the signal")
        remarks += [words for words in (*self._sensor.remarks, self._baseline_used()) if words]
        return (*remarks, *more)


def _rescaled(spectrum: OrderSpectrum, ratio: float, scale: float) -> OrderSpectrum:
    """Return a spectrum over multiples of a clock's frequency as one over orders of the shaft, at the reference frequency."""
    return OrderSpectrum(spectrum.orders * ratio, spectrum.amplitude / np.float32(scale), spectrum.mean / scale)
