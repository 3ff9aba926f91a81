"""Learning of a baseline from a recording of a healthy bearing."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Any

from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.healthy_baseline import HealthyBaseline, HealthyLines
from dcrb_ros.diagnosis.rule import BearingRule, LineRule
from dcrb_ros.schema.verdicts import Component, Verdict

Key = tuple[Component, tuple[float, float]]
"""Component, and edges of a band [Hz]."""
Largest = tuple[float, float]
"""Size [m/s^2] and depth [-]."""


class BaselineLearner:
    """Collects the largest lines of every fault in every band over the judgements of a detector.

    A detector judges only while the sensor is sound. A bearing that is healthy at first and then raises an alarm has changed: learning
    stops there. One that raises an alarm from the first verdict on is stated to be healthy, and learned with a remark.
    """

    def __init__(self, window: float, start: float = 0.0) -> None:
        """Learn from judgements of windows of that length [s] of a signal from ``start`` [s] on.

        Those that overlap with the one of an alarm are not used.
        """
        self._window, self._start = window, start
        self._largest: dict[Key, Largest] = {}
        self._pending: deque[tuple[float, float, dict[Key, Largest]]] = deque()
        """Time, shaft frequency and lines of the judgements of the latest windows."""
        self._verdicts: set[Verdict] = set()
        self._speeds: list[float] = []
        self._stopped = 0.0
        """Time of the alarm that ended the learning [s], 0 if none did."""

    @property
    def judgements(self) -> int:
        """Judgements from which lines were learned, or will be unless an alarm follows [-]."""
        return len(self._speeds) + len(self._pending)

    @property
    def seconds(self) -> float:
        """Length of signal that was used before an alarm [s], 0 without an alarm."""
        return max(0.0, self._stopped - self._window - self._start)

    def add(self, evidence: Evidence, rules: Iterable[BearingRule[Any]], verdict: Verdict, time: float) -> None:
        """Take the evidence of a judgement at a ``time`` [s] and its verdict."""
        if verdict not in ("healthy", "waiting") and "healthy" in self._verdicts and not self._stopped:
            self._stopped = time
            self._pending.clear()
        if self._stopped:
            return
        self._verdicts.add(verdict)
        largest: dict[Key, Largest] = {}
        for rule in rules:
            if isinstance(rule, LineRule):
                largest |= {(rule.component, (band.band.low, band.band.high)): _largest(rule, band) for band in evidence.bands}
        self._pending.append((time, evidence.shaft_frequency, largest))
        while self._pending[0][0] <= time - self._window:
            self._learn_oldest()

    def _learn_oldest(self) -> None:
        _, speed, largest = self._pending.popleft()
        self._speeds.append(speed)
        for key, (size, depth) in largest.items():
            known = self._largest.get(key, (0.0, 0.0))
            self._largest[key] = max(known[0], size), max(known[1], depth)

    def remark(self) -> str:
        """Return a remark on the recording for the user, or nothing."""
        alarms = sorted(self._verdicts - {"healthy", "waiting"})
        if self._stopped:
            return f"that recording raises an alarm at {self._stopped:.1f} s, and what its window contains was not used"
        return f"that recording itself is diagnosed as {' and '.join(alarms)}, and taken as healthy" if alarms else ""

    def baseline(self, about: dict[str, Any]) -> HealthyBaseline:
        """Return the baseline; ``about`` has its fields that do not depend on the judgements."""
        judgements = self.judgements
        while self._pending:
            self._learn_oldest()
        lines = [
            HealthyLines(component=component, band=band, size=size, depth=depth)
            for (component, band), (size, depth) in self._largest.items()
        ]
        speeds = (min(self._speeds), max(self._speeds))
        return HealthyBaseline(**about, judgements=judgements, speeds=speeds, remark=self.remark(), lines=lines)


def _largest(rule: LineRule[Any], band: BandEvidence) -> Largest:
    """Return size [m/s^2] and depth [-] of the largest lines of a rule in a band."""
    families = [rule.family(band, comb) for comb in rule.baseline_combs(band.orders)]
    return max(lines.amplitude for lines in families) ** 0.5, max(lines.depth for lines in families)
