"""The first fault detector: from samples and shaft angle to a verdict on the raceways.

A healthy roller bearing has a BPFO line of its own: its compliance varies as the rollers pass the load line, and with little
noise that line stands 35 dB over its background. So a line is only evidence when it is larger than the healthy bearing's, and:

* outer ring: the BPFO harmonics exceed the healthy baseline of this speed by a margin, and stand well over the background;
* inner ring: the BPFI harmonics with their sidebands at one and two orders (the defect turns through the loading zone) exceed
  their baseline, stand over the background, and modulate the squared envelope; the last tells them from the rattle that a
  strong outer-ring defect leaves between its own lines.

Roller and cage are measured (levels at 2 BSF and FTF), but no verdict is drawn from them yet. A defect outside the loading
zone, or one that no loaded roller strikes, is not seen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.envelope import Floats, comb_order, line_level, order_spectrum, squared_envelope
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.kinematics import Orders
from dcrb_ros.refusal import Refusal

Verdict = Literal["waiting", "healthy", "outer_ring", "inner_ring", "compound", "cage", "roller", "sensor"]

DEFAULTS = DetectorParameters()

REFERENCE_FREQUENCY = 20.0
"""Shaft frequency at which the baselines are stated [Hz]."""
HARMONICS = 3
SIDEBANDS = (-2, -1, 0, 1, 2)
"""Sidebands looked at round every BPFI harmonic [orders]."""
EDGE_PERIODS = 10.0
"""Periods of the band's lower edge left out at both ends of a window."""

Spectrum = tuple[Floats, Floats]


def _no_levels() -> dict[str, float]:
    return {"BPFO": 0.0, "BPFI": 0.0, "BSF": 0.0, "FTF": 0.0}


def _no_spectrum() -> Spectrum:
    return np.zeros(0), np.zeros(0)


@dataclass(frozen=True)
class Diagnosis:
    """What the detector thinks of one window."""

    index: int
    """Index of the window's last sample."""
    time: float
    """Time of that sample [s]."""
    verdict: Verdict
    reason: str
    """The evidence in one sentence."""
    confidence: float = 0.0
    """From 0.5 at a threshold towards 1 far from it; 0 without a verdict on the bearing."""
    levels: dict[str, float] = field(default_factory=_no_levels)
    """Level over background at BPFO, BPFI, BSF (twice its order) and FTF [dB]."""
    shaft_frequency: float = 0.0
    """Mean over the window [Hz]."""
    spectrum: Spectrum = field(default_factory=_no_spectrum)
    """Orders [-], and root of the squared envelope's amplitude there [m/s^2]; empty when there is none."""
    gaps: int = 0
    """Interruptions of the stream so far."""


@dataclass(frozen=True)
class Comb:
    """A family of lines as one: medians, which a single foreign line cannot move."""

    order: float
    """Fundamental as found [-]."""
    amplitude: float
    """Amplitude [m/s^2]."""
    level: float
    """Level over background [dB]."""


@dataclass(frozen=True)
class Finding:
    """How far the lines of one raceway are beyond what names a defect [dB]; negative: short of it."""

    comb: Comb
    baseline: float
    """Amplitude of the healthy bearing at this speed [m/s^2]."""
    excess: float

    def describe(self, name: str) -> str:
        """Return the finding as words."""
        return (
            f"{name} at {self.comb.order:.3f} orders has {self.comb.amplitude:.3g} m/s^2 where the healthy bearing has up to "
            f"{self.baseline:.3g}, {self.comb.level:.1f} dB over background"
        )


class FaultDetector:
    """Judge a stream of blocks, window by window.

    Memory is bounded by one window. The verdicts do not depend on how the stream is cut into blocks, but `update` returns
    one at most: of a block longer than the hop, the last.
    """

    def __init__(self, orders: Orders, rate: int, parameters: DetectorParameters = DEFAULTS) -> None:
        """Watch a bearing of characteristic ``orders``, sampled at ``rate`` [Hz]."""
        self.orders, self.rate, self.parameters = orders, rate, parameters
        self.gaps = 0
        self.band = _band(rate, parameters)
        self._window, self._hop = round(parameters.window * rate), max(1, round(parameters.hop * rate))
        self._edge = math.ceil(EDGE_PERIODS * rate / parameters.band_low)
        highest = max(orders.bpfo, orders.bpfi, orders.bsf)
        self._highest_order = (1.0 + parameters.slip) * HARMONICS * highest + max(SIDEBANDS) + 0.5
        self._acceleration = np.zeros((0, 2), np.float32)
        self._angle = np.zeros(0, np.float32)
        self._next: int | None = None
        self._seen = 0

    def update(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any]) -> Diagnosis | None:
        """Take the block of first sample ``index``; return the diagnosis when one falls due within it.

        ``acceleration`` has shape (samples, 2) [m/s^2], ``shaft_angle`` (samples,) [rad]. An ``index`` that does not follow
        on the last block counts as a gap and starts a new window.
        """
        samples = len(shaft_angle)
        if acceleration.shape != (samples, 2) or shaft_angle.shape != (samples,):
            raise Refusal(
                f"a block with acceleration {acceleration.shape} and shaft_angle {shaft_angle.shape} is refused: "
                "they must be (samples, 2) and (samples,); the detector waits for the next block"
            )
        if self._next is not None and index != self._next:
            self._start_afresh()
        self._next = index + samples
        due = (self._seen + samples) // self._hop * self._hop - self._seen
        if due <= 0:
            self._append(acceleration, shaft_angle)
            return None
        self._append(acceleration[:due], shaft_angle[:due])
        diagnosis = self._judge(index + due - 1)
        self._append(acceleration[due:], shaft_angle[due:])
        return diagnosis

    def _start_afresh(self) -> None:
        self.gaps += 1
        self._seen = 0
        self._acceleration, self._angle = self._acceleration[:0], self._angle[:0]

    def _append(self, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any]) -> None:
        self._seen += len(shaft_angle)
        self._acceleration = _latest(self._acceleration, acceleration, self._window)
        self._angle = _latest(self._angle, shaft_angle, self._window)

    def _judge(self, last: int) -> Diagnosis:
        flaw = _sensor_flaw(self._acceleration, self._angle)
        if flaw:
            return self._without_verdict(last, "sensor", flaw)
        turned = np.unwrap(self._angle.astype(np.float64))
        turns = abs(turned[-1] - turned[0]) / (2.0 * math.pi)
        frequency = turns * self.rate / (len(turned) - 1)
        wait = self._wait(turned, turns)
        if wait:
            return self._without_verdict(last, "waiting", wait, frequency)
        return self._verdict(last, turned, frequency)

    def _wait(self, turned: Floats, turns: float) -> str:
        """Return why there is no verdict yet, or nothing."""
        if len(turned) < self._window:
            return f"{len(turned) / self.rate:.1f} s of the {self.parameters.window:g} s of a window have come in"
        if turns < self.parameters.least_turns:
            least = self.parameters.least_turns
            return f"the shaft makes {turns:.2g} turns in {self.parameters.window:g} s where a verdict needs {least:g}"
        if float(np.abs(np.diff(turned)).sum()) > 1.01 * 2.0 * math.pi * turns:
            return "the shaft turned back within the window"
        return ""

    def _without_verdict(self, last: int, verdict: Verdict, reason: str, frequency: float = 0.0) -> Diagnosis:
        return Diagnosis(last, last / self.rate, verdict, reason, shaft_frequency=frequency, gaps=self.gaps)

    def _verdict(self, last: int, turned: Floats, frequency: float) -> Diagnosis:
        inside = slice(self._edge, -self._edge)
        envelope = squared_envelope(self._acceleration, self.rate, self.band)[inside]
        forward = turned if turned[-1] > turned[0] else -turned
        orders, squared = order_spectrum(envelope, forward[inside], self._highest_order)
        spectrum = orders, np.sqrt(squared)
        outer, inner = self._outer(spectrum, frequency), self._inner(spectrum, frequency)
        verdict, reason, margin = _decide(outer, inner)
        return Diagnosis(
            last,
            last / self.rate,
            verdict,
            reason,
            confidence=1.0 - 0.5 * 10.0 ** (-margin / 10.0),
            levels={
                "BPFO": outer.comb.level,
                "BPFI": inner.comb.level,
                "BSF": self._comb(spectrum, 2.0 * self.orders.bsf, harmonics=1).level,
                "FTF": self._comb(spectrum, self.orders.ftf).level,
            },
            shaft_frequency=frequency,
            spectrum=spectrum,
            gaps=self.gaps,
        )

    def _outer(self, spectrum: Spectrum, frequency: float) -> Finding:
        p = self.parameters
        comb = self._comb(spectrum, self.orders.bpfo)
        baseline = self._baseline(p.outer_baseline, frequency)
        return Finding(comb, baseline, min(_decibels(comb.amplitude, baseline) - p.outer_margin, comb.level - p.outer_level))

    def _inner(self, spectrum: Spectrum, frequency: float) -> Finding:
        p = self.parameters
        comb = self._comb(spectrum, self.orders.bpfi, sidebands=SIDEBANDS)
        baseline = self._baseline(p.inner_baseline, frequency)
        mean_root = float(spectrum[1][0])
        over = _decibels(comb.amplitude, baseline) - p.inner_margin
        deep = _decibels(comb.amplitude, math.sqrt(p.inner_depth) * mean_root)
        return Finding(comb, baseline, min(over, deep, comb.level - p.inner_level))

    def _comb(self, spectrum: Spectrum, order: float, *, harmonics: int = HARMONICS, sidebands: tuple[int, ...] = (0,)) -> Comb:
        orders, amplitude = spectrum
        fundamental = comb_order(orders, amplitude, order, search=self.parameters.slip, harmonics=harmonics)
        teeth = [k * fundamental + shift for k in range(1, harmonics + 1) for shift in sidebands]
        # The spectrum is padded to twice its length: two orders' steps are the window's resolution.
        width = 2.0 * float(orders[1] - orders[0])
        lines = [line_level(orders, amplitude, tooth, search=0.0, resolution=width) for tooth in teeth]
        amplitudes, levels = [line.amplitude for line in lines], [line.level for line in lines]
        return Comb(fundamental, float(np.median(amplitudes)), float(np.median(levels)))

    def _baseline(self, amplitude: float, frequency: float) -> float:
        return amplitude * math.pow(frequency / REFERENCE_FREQUENCY, self.parameters.speed_exponent)


def _band(rate: int, parameters: DetectorParameters) -> tuple[float, float]:
    high = min(parameters.band_high, 0.45 * rate)
    if high < 1.25 * parameters.band_low:
        raise Refusal(
            f"band_low = {parameters.band_low:g} Hz leaves no band below {high:g} Hz, the smaller of band_high and 0.45 of the "
            f"sampling rate of {rate} Hz: it must be at most {high / 1.25:g} Hz; lower it or sample faster"
        )
    return parameters.band_low, high


def _latest(kept: npt.NDArray[np.float32], come: npt.NDArray[Any], samples: int) -> npt.NDArray[np.float32]:
    """Return the last ``samples`` of what was kept and what has come."""
    return np.concatenate([kept, come[-samples:]], dtype=np.float32, casting="same_kind")[-samples:]


def _sensor_flaw(acceleration: npt.NDArray[np.float32], shaft_angle: npt.NDArray[np.float32]) -> str:
    """Return what is wrong with the samples, or nothing."""
    bad = int(np.count_nonzero(~(np.isfinite(acceleration).all(axis=1) & np.isfinite(shaft_angle))))
    if bad:
        return f"{bad} of {len(shaft_angle)} samples are not finite numbers"
    still = " and ".join(axis for axis, column in zip("XY", acceleration.T, strict=True) if float(np.ptp(column)) == 0.0)
    if still:
        return f"the acceleration in {still} does not change: the sensor is dead, or the signal below its resolution"
    return ""


def _decibels(value: float, reference: float) -> float:
    """Return a ratio of amplitudes [dB], held within 120 dB."""
    if value <= 0.0 or reference <= 0.0:
        return -120.0 if value <= 0.0 else 120.0
    return min(120.0, max(-120.0, 20.0 * math.log10(value / reference)))


def _decide(outer: Finding, inner: Finding) -> tuple[Verdict, str, float]:
    """Return verdict, evidence and the margin to the nearest other verdict [dB]."""
    margin = min(abs(outer.excess), abs(inner.excess))
    if outer.excess >= 0.0 and inner.excess >= 0.0:
        return "compound", f"{outer.describe('BPFO')}, and {inner.describe('BPFI with its sidebands')}", margin
    if outer.excess >= 0.0:
        return "outer_ring", outer.describe("BPFO"), margin
    if inner.excess >= 0.0:
        return "inner_ring", inner.describe("BPFI with its sidebands"), margin
    return "healthy", f"{outer.describe('BPFO')}, which its varying compliance explains, and BPFI stays within its own", margin
