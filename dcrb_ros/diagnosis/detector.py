"""The reference fault detector: blocks of samples in, verdicts out, with bounded memory.

Every hop: the stream is mended, the sensor's health is looked at, and the squared envelopes of a tree of bands are laid over the
turns of the shaft. From the hops of a window come order spectra, from these the lines of each fault, from these the verdict.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.diagnosis.bands import Band, BandBank, band_tree, kurtosis
from dcrb_ros.diagnosis.diagnosis import Diagnosis, Spectrum
from dcrb_ros.diagnosis.envelope import OrderSpectrum, order_spectra
from dcrb_ros.diagnosis.evidence import HARMONICS, KINDS, SHAFT_SIDEBANDS, BandEvidence, Finding, Kind, Limits, families, findings
from dcrb_ros.diagnosis.gain import LevelHealth
from dcrb_ros.diagnosis.health import SampleHealth
from dcrb_ros.diagnosis.hops import REFERENCE_FREQUENCY, Hop, Window, margin_samples
from dcrb_ros.diagnosis.judgement import Judge, Trend, Verdict, confidence
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.speed import estimated_frequency
from dcrb_ros.diagnosis.stream import Stream, Stretch
from dcrb_ros.runtime.refusal import Refusal

__all__ = ["Diagnosis", "FaultDetector"]

DEFAULTS = DetectorParameters()

TREE_LEVELS = 2
"""Halvings of the band."""
MARGIN_PERIODS = 10.0
"""Periods of the lowest band's edge that a hop's envelope needs beside it."""
NYQUIST_SHARE = 0.45
"""Highest usable frequency over the sampling rate [-]: beyond it an anti-alias filter has its way."""
BINS_PER_ORDER = 3
"""Angle bins per turn and highest order; 2 would be Nyquist's."""


class FaultDetector:
    """Judge a stream of blocks, hop by hop.

    Memory is bounded by one window and the longest gap that is bridged. The verdicts do not depend on how the stream is cut into
    blocks, but `update` returns one at most: of a block longer than the hop, the last.
    """

    def __init__(self, orders: Orders, rate: int, parameters: DetectorParameters = DEFAULTS, *, sensor_range: float = 0.0) -> None:
        """Watch a bearing of characteristic ``orders``, sampled at ``rate`` [Hz] by a sensor of a range [m/s^2], 0 if not known."""
        p = parameters
        self.orders, self.rate, self.parameters = orders, rate, parameters
        self.band, self._high, bands = _bands(rate, p)
        below = bands[-1]
        self._branches = (*band_tree(p.band_low, p.band_high, TREE_LEVELS)[-(2**TREE_LEVELS) :], below)
        self._hop = max(1, round(p.hop * rate))
        margin = margin_samples(rate, below.low, MARGIN_PERIODS)
        if self._hop < 2 * margin:
            raise Refusal(
                f"hop = {p.hop:g} s is below {2 * margin / rate:.2g} s, what the band from {p.band_low:g} Hz needs: make it longer"
            )
        if p.window < p.hop:
            raise Refusal(f"window = {p.window:g} s is below hop = {p.hop:g} s, how often it is judged: make it longer, or hop shorter")
        self._highest_order = (1.0 + p.slip) * (
            HARMONICS[-1] * max(2.0 * orders.bpfo, 2.0 * orders.bpfi, 2.0 * orders.bsf) + SHAFT_SIDEBANDS[-1]
        )
        bins = math.ceil(BINS_PER_ORDER * self._highest_order)
        bank = BandBank(bands, rate, self._hop + 2 * margin)
        self._window = Window(bank, rate, self._hop, margin, bins, max(1, round(p.window / p.hop)), p.speed_exponent)
        self._needed = min(p.least_window, p.window) - 0.5 * p.hop
        self._bands = bands
        self._stream = Stream(self._hop, margin, round(min(p.longest_gap, 0.5 * p.hop) * rate))
        self._margin = margin
        self._samples, self._levels = SampleHealth(p, rate, sensor_range), LevelHealth(p)
        self._judge, self._trend = Judge(p), Trend(p.trend_time, p.hop)
        self._learned, self._learning = Limits(0.0, 0.0), p.learn
        self._flawed, self._flaw = 0, ""

    @property
    def gaps(self) -> int:
        """Interruptions of the stream so far."""
        return self._stream.counts.gaps

    def update(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any] | None = None) -> Diagnosis | None:
        """Take the block of first sample ``index``; return the diagnosis when one falls due within it.

        ``acceleration`` has shape (samples, 2) [m/s^2], ``shaft_angle`` (samples,) [rad]; without a tacho leave it out or let it be NaN.

        Raises:
            Refusal: arrays of another shape or kind; the detector goes on with the next block.
        """
        diagnosis = None
        for stretch in self._stream.take(index, acceleration, shaft_angle):
            diagnosis = self._hopped(stretch)
        return diagnosis

    def _hopped(self, stretch: Stretch) -> Diagnosis:
        if stretch.fresh:
            self._window.clear()
            self._judge.forget()
            self._levels.forget()
            self._flawed = 0
        inside = slice(self._margin, self._margin + self._hop)
        turning = self._turning(stretch, inside)
        flaw = self._samples.flaw(stretch.acceleration[inside], stretch.missing[inside], stretch.senseless, turning=turning)
        hop = self._window.add(stretch, self.parameters.fastest, useless=bool(flaw))
        flaw = flaw or (self._level_flaw(hop) if hop and turning else "")
        self._flawed = round(self.parameters.window / self.parameters.hop) if flaw else max(0, self._flawed - 1)
        self._flaw = flaw or self._flaw
        if self._flawed:
            self._judge.forget()
            return self._without_verdict(stretch.last, "sensor", self._flaw)
        wait = self._wait()
        if wait:
            return self._without_verdict(stretch.last, "waiting", wait)
        return self._judged(stretch.last)

    def _turning(self, stretch: Stretch, inside: slice) -> bool:
        """Return whether the bearing turns fast enough to be heard, all the hop; without a tacho it is taken for turning."""
        if stretch.turns is None:
            return True
        turns, p = stretch.turns[inside], self.parameters
        return abs(float(turns[-1] - turns[0])) >= p.least_turns * p.hop / p.window

    def _level_flaw(self, hop: Hop) -> str:
        """Return what the levels of the tree's lowest branches and of the band below it say of the sensor, or nothing."""
        powers = hop.powers
        chosen = [k for k, band in enumerate(self._bands) if band in self._branches]
        third = self._branches[-3]
        high = chosen.index(self._bands.index(third)) if third in self._bands else None
        # Without a shaft angle nobody knows whether the levels fell with the speed: they are not compared.
        frequency = hop.turns * self.rate / self._hop if self._window.tracked else 0.0
        return self._levels.flaw(powers[chosen], frequency, high=high, below=len(chosen) - 1)

    @property
    def sensor_range(self) -> float:
        """Range of the sensor [m/s^2], 0 where it is not known; it may change under way."""
        return self._samples.range

    @sensor_range.setter
    def sensor_range(self, value: float) -> None:
        self._samples.range = value

    def _wait(self) -> str:
        """Return why there is no verdict yet, or nothing."""
        p, window = self.parameters, self._window
        if window.turned_back:
            return "the shaft turned back within the window"
        seconds = len(window) * self._hop / self.rate
        if seconds < self._needed:
            return f"{seconds:.1f} s of the {p.least_window:g} s that a verdict needs have come in"
        if window.tracked and window.turns < p.least_turns:
            return f"the shaft makes {window.turns:.2g} turns in {seconds:g} s where a verdict needs {p.least_turns:g}"
        if window.missing_share > p.most_missing:
            return f"{100.0 * window.missing_share:.0f} % of the window are missing where {100.0 * p.most_missing:.0f} % are the most"
        return ""

    def _without_verdict(self, last: int, verdict: Verdict, reason: str) -> Diagnosis:
        frequency = self._window.frequency if self._window.tracked else 0.0
        counts = self._stream.counts
        return Diagnosis(
            last,
            last / self.rate,
            verdict,
            reason,
            shaft_frequency=frequency,
            gaps=counts.gaps,
            clipped=self._samples.clipped,
            remarks=self._remarks(),
        )

    def _judged(self, last: int) -> Diagnosis:
        p = self.parameters
        envelopes, missing = self._window.envelopes()
        spectra = order_spectra(envelopes, missing, self._window.bins_per_turn)
        frequency = self._window.frequency
        if not self._window.tracked:
            told = estimated_frequency((spectra[0], spectra[-1]), p.fastest, self.orders, p.slowest, p.fastest)
            if told.score < p.speed_score or told.rival > p.speed_rival:
                why = f"{told.frequency:.2f} Hz explains its lines with {told.score:.0f} dB, another speed with {told.rival:.0%} of that"
                return self._without_verdict(last, "waiting", f"there is no shaft angle, and the signal does not tell the speed: {why}")
            frequency = told.frequency
            spectra = [_retold(spectrum, p.fastest / frequency, self._scale(frequency)) for spectrum in spectra]
        evidence = [families(band, s, self.orders, p.slip) for band, s in zip(self._bands, spectra, strict=True)]
        limits = Limits(max(p.outer_limit, self._learned.whole), max(p.outer_limit_high, self._learned.high))
        found = findings(evidence, self.band, self._high, limits, p)
        if self._learning > 0.0:
            self._learn(evidence)
            found["outer_ring"] = found["outer_ring"]._replace(excess=min(-1.0, found["outer_ring"].excess))
        sharpest = int(np.argmax(kurtosis(envelopes[: len(self._bands) - 1]))) if p.band == "kurtogram" else 0
        return self._told(last, frequency, found, evidence, sharpest)

    def _scale(self, frequency: float) -> float:
        """Return what a squared envelope at a shaft frequency [Hz] is over that at the reference frequency [-]."""
        return float((frequency / REFERENCE_FREQUENCY) ** (2.0 * self.parameters.speed_exponent))

    def _learn(self, evidence: list[BandEvidence]) -> None:
        """Raise the limits of the outer ring above what a bearing that is taken for healthy shows."""
        self._learning -= self.parameters.hop
        margin = 10.0 ** (self.parameters.learn_margin / 20.0)
        sizes = {one.band: margin * math.sqrt(one.combs["outer_ring"].amplitude) for one in evidence}
        self._learned = Limits(max(self._learned.whole, sizes[self.band]), max(self._learned.high, sizes.get(self._high, 0.0)))

    def _told(self, last: int, frequency: float, found: dict[Kind, Finding], evidence: list[BandEvidence], sharpest: int) -> Diagnosis:
        excess = {kind: found[kind].excess for kind in KINDS}
        verdict = self._judge.weigh(excess)
        named = self._judge.named
        severity = max((math.sqrt(evidence[0].combs[kind].amplitude) for kind in named), default=0.0)
        time, levels = last / self.rate, {kind: finding.comb.level for kind, finding in found.items()}
        return Diagnosis(
            last,
            time,
            verdict,
            self._reason(verdict, found),
            confidence=confidence(verdict, named, excess),
            levels={"BPFO": levels["outer_ring"], "BPFI": levels["inner_ring"], "BSF": levels["roller"], "FTF": levels["cage"]},
            shaft_frequency=frequency,
            spectrum=self._spectrum(evidence[sharpest].spectrum, frequency),
            gaps=self._stream.counts.gaps,
            scores={str(kind): value for kind, value in excess.items()},
            severity=severity,
            trend=self._trend.slope(time, verdict, severity),
            clipped=self._samples.clipped,
            remarks=self._remarks(f"the spectrum is of the band from {evidence[sharpest].band}"),
        )

    def _reason(self, verdict: Verdict, found: dict[Kind, Finding]) -> str:
        named = self._judge.named or (self._judge.suspected if verdict == "waiting" else [])
        words = ", and ".join(found[kind].describe(kind) for kind in named)
        if verdict == "waiting":
            return f"to be confirmed by the next judgement: {words or 'no line is beyond a healthy bearing'}"
        if named:
            return words
        return f"no line is beyond a healthy bearing; {found['outer_ring'].describe('outer_ring')}, which its varying compliance explains"

    def _spectrum(self, spectrum: OrderSpectrum, frequency: float) -> Spectrum:
        """Return the part of a spectrum that is published, as amplitudes at the present speed."""
        kept = spectrum.orders <= self._highest_order
        amplitude = np.sqrt(spectrum.amplitude[kept] * self._scale(max(frequency, 0.0)))
        amplitude[0] = math.sqrt(spectrum.mean * self._scale(max(frequency, 0.0)))
        return spectrum.orders[kept], amplitude

    def _remarks(self, *more: str) -> tuple[str, ...]:
        counts = self._stream.counts
        said = {
            "samples lost in gaps": counts.lost,
            "samples came again or too late and were left out": counts.repeated,
            "samples are no finite numbers": counts.senseless,
            "times the stream began anew": counts.restarts,
            "samples stood at the end of the range": self._samples.clipped,
        }
        remarks = [f"{number} {words}" for words, number in said.items() if number]
        if not self._window.tracked:
            remarks.append("no shaft angle: the speed is estimated from the signal")
        if self._learning > 0.0:
            remarks.append(f"learning for {self._learning:.1f} s more: outer-ring defects are not named yet")
        return (*remarks, *more)


def _retold(spectrum: OrderSpectrum, stretched: float, scale: float) -> OrderSpectrum:
    """Return a spectrum over a clock's turns as one over the shaft's, at the reference frequency."""
    return OrderSpectrum(spectrum.orders * stretched, spectrum.amplitude / np.float32(scale), spectrum.mean / scale)


def _bands(rate: int, p: DetectorParameters) -> tuple[Band, Band, tuple[Band, ...]]:
    """Return the whole band, its upper quarter, and all bands: the whole first, then its parts, last the one below it."""
    highest = NYQUIST_SHARE * rate
    high = min(p.band_high, highest)
    if high < 1.25 * p.band_low:
        raise Refusal(
            f"band_low = {p.band_low:g} Hz leaves no band below {high:g} Hz, the smaller of band_high and {NYQUIST_SHARE:g} of the "
            f"sampling rate of {rate} Hz: it must be at most {high / 1.25:g} Hz; lower it or sample faster"
        )
    whole, tree = Band(p.band_low, high), band_tree(p.band_low, p.band_high, TREE_LEVELS)
    parts = tuple(band for band in tree[1:] if band.high <= high) if p.band == "kurtogram" else ()
    below = Band(0.5 * p.band_low, p.band_low)
    return whole, tree[-1], (whole, *parts, below)
