"""The temperature of a bearing over time, and what it says about lubricant and overheating."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from dcrb_ros.diagnosis.heat_model import HeatModel
from dcrb_ros.diagnosis.heat_rule import HeatEvidence, HeatFinding, HeatParameters, HeatRule
from dcrb_ros.diagnosis.hysteresis import Suspicion
from dcrb_ros.schema.verdicts import Trouble

LEARNED_WITHIN = 3.0
"""Deviations within which a reading is learned from [-]."""
STARVED, REMEMBERED = 2.5, 12.0 * 3600.0
"""Deviations below the expected rise that are a hint of starved films [-], and how long it is remembered [s]."""
KNOWN_AFTER = 2.0 * 3600.0
"""Time of readings that were learned from, after which the healthy rise of a bearing is known [s]."""
LONGEST_PAUSE = 600.0
"""Time between two readings after which nothing is known about the time between them [s]."""
LATEST_LATE = 5.0
"""How late a reading may be [s]; an older one begins a new time."""
COLDEST, HOTTEST = -60.0, 700.0
"""Range of a reading that a thermometer at a bearing can have [deg C]."""
HOUR = 3600.0
"""[s]"""


class HeatJudgement(NamedTuple):
    """What a reading says."""

    evidence: HeatEvidence
    confirmed: HeatFinding | None
    """Finding of the trouble that is confirmed; None for none."""
    scores: dict[Trouble, float]
    """Evidence of each rule relative to its threshold [dB]."""


class HeatMonitor:
    """Compares the readings of a bearing's temperature with the model of the healthy bearing."""

    def __init__(self, parameters: HeatParameters, rules: list[HeatRule[Any]], release_margin: float = 1.0) -> None:
        """Judge by ``rules``; evidence counts as gone from ``release_margin`` [dB] below a threshold."""
        self.p, self._rules, self._margin = parameters, rules, release_margin
        self.model = HeatModel(parameters.heat_rise, parameters.heat_rise_deviation, parameters.heat_error, parameters.heat_error_share)
        self.learned = 0.0
        """Time from which the model was learned [s]."""
        self.rejected = 0
        """Readings that were no temperatures of a bearing."""
        self.pauses = 0
        """Readings that were not judged, because they followed a pause."""
        self._before: float | None = None
        self._judgement: HeatJudgement | None = None
        self._cool = -math.inf
        """Time of the latest reading that was a hint of starved films [s]."""
        self._suspicions = {rule.trouble: Suspicion() for rule in rules}

    def update(self, time: float, frequency: float, bearing: float, ambient: float, load: float = math.nan) -> HeatJudgement | None:
        """Take a reading of the ``bearing`` and of the ``ambient`` air [deg C] at a ``time`` [s]; return what it says.

        ``frequency`` is that of the shaft since the reading before [Hz], ``load`` that of the bearing [N], NaN where it is unknown. None
        for the first reading, for one after a pause, and for one that is not after the reading before or is no temperature of a bearing.
        """
        if not (COLDEST <= bearing <= HOTTEST and COLDEST <= ambient <= HOTTEST and math.isfinite(frequency) and not math.isinf(load)):
            self.rejected += 1
            return None
        rise, before = bearing - ambient, self._before
        if before is not None and time <= before:
            if time < before - LATEST_LATE:  # the clock was set back, as at the reset of a bench
                self._restart(time)
                self._cool = -math.inf
            return None
        passed = 0.0 if before is None else (time - before) * self.p.heat_time_lapse
        if before is None or time - before > LONGEST_PAUSE:
            self.pauses += before is not None
            self._restart(time)
            self.model.follow(frequency, load, 0.0, rise)
            return None
        self._before = time
        self.model.follow(frequency, load, passed, rise)
        expected, deviation = self.model.expected, self.model.deviation
        usual = self.model.least_rise if self.learned >= min(KNOWN_AFTER, HOUR * self.p.heat_learn) else None
        evidence = HeatEvidence(rise, expected, deviation, self._starved(time, rise - expected, deviation), usual)
        findings = [rule.finding(evidence) for rule in self._rules]
        self._learn(rise, passed, deviation)
        self._judgement = HeatJudgement(evidence, self._confirmed(findings), {finding.trouble: finding.excess for finding in findings})
        return self._judgement

    def judgement_at(self, time: float) -> HeatJudgement | None:
        """Return what the latest reading says at a ``time`` [s]; None if it is the first one, or far from that time, as after a reset."""
        return self._judgement if self._before is not None and abs(time - self._before) <= LONGEST_PAUSE else None

    def forget(self) -> None:
        """Begin anew, as after the reset of a bench; what was learned about the bearing is kept."""
        self._restart(None)
        self._cool = -math.inf

    def _restart(self, time: float | None) -> None:
        self._before, self._judgement = time, None
        self.model.restart()
        self._suspicions = {rule.trouble: Suspicion() for rule in self._rules}

    def _starved(self, time: float, residual: float, deviation: float) -> bool:
        """Return whether the bearing is or was too cool within the time that is remembered."""
        if residual < -STARVED * deviation:
            self._cool = time
        return (time - self._cool) * self.p.heat_time_lapse <= REMEMBERED

    def _learn(self, rise: float, passed: float, deviation: float) -> None:
        """Learn from a reading, unless enough has been learned, the bearing departs from the model, or it is too early to say."""
        wanted = self.learned < HOUR * self.p.heat_learn
        if wanted and self.model.known and abs(rise - self.model.expected) < LEARNED_WITHIN * deviation:
            self.model.learn(rise, passed)
            self.learned += passed

    def _confirmed(self, findings: list[HeatFinding]) -> HeatFinding | None:
        """Count the findings; return the strongest of those that are confirmed, the last rule's where two are equal."""
        confirmed = [
            finding
            for finding in findings
            if self._suspicions[finding.trouble].count(
                present=finding.excess >= 0.0,
                absent=finding.excess < -self._margin,
                confirm=self.p.heat_confirm,
                release=self.p.heat_release,
            )
        ]
        return max(reversed(confirmed), key=lambda finding: finding.excess, default=None)
