"""The sensor of the fault detector: flaws that its rules find in the samples and in the levels of a hop, kept for a window."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from dcrb_ros.diagnosis.demodulation import NYQUIST_SHARE, QUARTERS, Band, band_tree
from dcrb_ros.diagnosis.evidence import LevelEvidence, LevelHistory, SampleEvidence
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.registry import LEVEL_RULES, SAMPLE_RULES
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.diagnosis.segments import Segment
from dcrb_ros.schema.arrays import Floats


class SensorCheck:
    """Applies the rules for the sensor, and remembers a flaw until its samples have left the window."""

    def __init__(self, parameters: DetectorParameters, rate: int, hop: int, bands: Sequence[Band]) -> None:
        """Prepare for hops of so many samples at a ``rate`` [Hz], whose levels are those of ``bands``, the last one below the others."""
        p = parameters
        self._rate, self._hop, self._hops = rate, hop, p.hops
        # Levels are compared in the quarters of the band and in the band below it.
        quarters = band_tree(p.band_low, p.band_high, (QUARTERS,))
        self.bands = [k for k, band in enumerate(bands) if band in (*quarters, bands[-1])]
        """Indices of the bands whose levels are compared."""
        third = quarters[-2]
        self._third = self.bands.index(bands.index(third)) if third in bands else None
        self._sample_rules = [rule(p) for rule in SAMPLE_RULES]
        self._level_rules = [rule(p) for rule in LEVEL_RULES]
        self._levels = LevelHistory([bands[k].high - bands[k].low for k in self.bands], p.speed_exponent)
        hidden = [_hidden(rule, hop / rate, rate) for rule in self._sample_rules]
        self.remarks = [*filter(None, hidden), *([] if len(self.bands) > 1 else [_undetected(p, NYQUIST_SHARE * rate)])]
        """Which faults of the sensor cannot be detected, and why."""
        self._flaw = ""
        self._remaining = 0
        """Hops until the samples with the last flaw have left the window."""

    @property
    def clipped(self) -> int:
        """Clipped samples so far."""
        return sum(rule.clipped for rule in self._sample_rules)

    @property
    def flaw(self) -> str:
        """The flaw of samples that are in the window, or nothing."""
        return self._flaw if self._remaining else ""

    def restart(self) -> None:
        """Begin anew with the signal: nothing is compared across a gap."""
        for rule in self._sample_rules:
            rule.restart()
        self._levels.restart()
        self._remaining = 0

    def remember(self, flaw: str) -> None:
        """Remember the flaw of a hop, if it has one."""
        if flaw:
            self._flaw, self._remaining = flaw, self._hops
        else:
            self._remaining = max(0, self._remaining - 1)

    def flaw_of_samples(self, segment: Segment, turned: float, sensor_range: float, *, turning: bool) -> str:
        """Return the first flaw that a rule finds in the samples, or nothing.

        Args:
            segment: a segment without its margins.
            turned: turns of the shaft within them; 0 if they are unknown [-].
            sensor_range: range of the sensor; 0 if it is unknown [m/s^2].
            turning: whether the shaft is taken to turn; at standstill some rules do not apply.
        """
        missing = segment.missing
        known = segment.acceleration[~missing] if missing.any() else segment.acceleration
        frequency = turned * self._rate / self._hop
        evidence = SampleEvidence(known, len(missing), segment.not_finite, self._rate, sensor_range, self._hops, frequency)
        rules = (rule for rule in self._sample_rules if len(known) >= rule.fewest_samples and (turning or rule.at_standstill))
        return next((flaw for rule in rules if (flaw := rule.flaw(evidence))), "")

    def flaw_of_levels(self, powers: Floats, frequency: float) -> str:
        """Return the first flaw that a rule finds in the powers of `bands` [(m/s^2)^2] at a shaft frequency [Hz], 0 if it is not known.

        The text is empty without one.
        """
        levels = self._levels.add(powers, frequency)
        if levels is None:
            return ""
        evidence = LevelEvidence(levels, self._third)
        return next((flaw for rule in self._level_rules if (flaw := rule.flaw(evidence))), "")


def _hidden(rule: SampleRule[Any], hop: float, rate: int) -> str:
    """Return which fault a rule cannot detect in a ``hop`` that is too short [s], or nothing."""
    shortest = rule.shortest_hop(rate)
    if not rule.fault or hop >= shortest:
        return ""
    least = math.ceil(1e3 * shortest) / 1e3
    return f"no {rule.fault} is detected: hop = {hop:g} s is below {least:g} s, the least at {rate} Hz"


def _undetected(p: DetectorParameters, highest: float) -> str:
    """Return which faults cannot be detected if the quarters of the band are not compared, which ends at most at ``highest`` [Hz]."""
    why = f"band = {p.band} is not divided: give band = kurtogram"
    if p.band_high > highest:
        why = f"band_high = {p.band_high:g} Hz is above {highest:g} Hz, {NYQUIST_SHARE:g} of the sampling rate: lower it for these verdicts"
    return f"no gain drift and no loss of high frequencies is detected: {why}"
