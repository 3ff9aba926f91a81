"""The findings of all rules combined: one per component, without those that the lines of another component explain."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dcrb_ros.diagnosis.evidence import Evidence
from dcrb_ros.diagnosis.rule import LEAST_EXCESS, BearingRule, Finding, LineRule
from dcrb_ros.schema.verdicts import COMPONENTS, Component


class Combination:
    """Line families overlap: sidebands and harmonics of one component lie on lines of another. The weaker explanation is discarded."""

    def __init__(self, rules: Sequence[BearingRule[Any]], release_margin: float) -> None:
        """Lower findings that are explained by more than ``release_margin`` [dB] below their thresholds."""
        self._rules, self._margin = rules, release_margin
        overlaps = [(rule, overlap) for rule in rules if isinstance(rule, LineRule) for overlap in rule.overlaps()]
        self._overlaps = sorted(overlaps, key=lambda one: one[1].rank)

    def findings(self, evidence: Evidence) -> dict[Component, Finding]:
        """Return the strongest finding for each component, shape as in `COMPONENTS`."""
        found = {component: Finding(component, LEAST_EXCESS, "no rule applies") for component in COMPONENTS}
        for rule in self._rules:
            finding = rule.finding(evidence)
            if finding is not None and finding.excess >= found[finding.component].excess:
                found[finding.component] = finding
        for component in self._explained(found, evidence):
            excess = found[component].excess
            found[component] = found[component]._replace(excess=-max(self._margin + 1.0, abs(excess)))
        for rule in self._rules:
            found[rule.component] = rule.settled(found[rule.component], evidence)
        return found

    def _explained(self, found: dict[Component, Finding], evidence: Evidence) -> set[Component]:
        """Return the suspected components whose lines those of another suspected component explain."""
        suspected = {component for component, finding in found.items() if finding.excess >= 0.0}
        explained: set[Component] = set()
        for rule, overlap in self._overlaps:
            image = found[overlap.component]
            if {rule.component, image.component} <= suspected - explained:
                there = evidence.of_band(image.band)
                if there is not None and there.family(rule.lines).depth >= overlap.ratio * image.lines.depth:
                    explained.add(image.component)
        return explained
