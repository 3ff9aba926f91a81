"""The findings of all rules combined: one per component, without those that the lines of another component explain.

Families overlap: sidebands and harmonics of one fault lie on lines of another, and the search for a departure from the kinematic orders
adds chances. The joint explanation is found in steps, as in matching pursuit (Mallat and Zhang 1993): the deepest family is accepted with
all the lines that its fault makes, and another one is accepted only if it is left without those lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dcrb_ros.diagnosis.evidence import Evidence
from dcrb_ros.diagnosis.rule import LEAST_EXCESS, BearingRule, Finding
from dcrb_ros.schema.verdicts import COMPONENTS, Component

LEAST_REMAINDER = 0.5
"""Share of the modulation depth that an independent family keeps without the lines of another [-]: more of its lines are left than not."""


class Combination:
    """Combines the findings of rules."""

    def __init__(self, rules: Sequence[BearingRule[Any]], release_margin: float) -> None:
        """Lower findings that are explained by more than ``release_margin`` [dB] below their thresholds."""
        self._rules, self._margin = rules, release_margin

    def findings(self, evidence: Evidence) -> dict[Component, Finding]:
        """Return the strongest finding for each component, shape as in `COMPONENTS`."""
        findings = {component: Finding(component, LEAST_EXCESS, "no rule applies") for component in COMPONENTS}
        for rule in self._rules:
            finding = rule.finding(evidence)
            if finding is not None and finding.excess >= findings[finding.component].excess:
                findings[finding.component] = finding
        for component in self._explained(findings, evidence):
            excess = findings[component].excess
            findings[component] = findings[component]._replace(excess=-max(self._margin + 1.0, abs(excess)))
        for rule in self._rules:
            findings[rule.component] = rule.settled(findings[rule.component], evidence)
        return findings

    def _explained(self, findings: dict[Component, Finding], evidence: Evidence) -> set[Component]:
        """Return the suspected components whose lines those of another suspected component explain."""
        suspected = sorted(
            (finding for finding in findings.values() if finding.excess >= 0.0), key=lambda finding: -finding.lines.depth_per_line
        )
        accepted: list[Finding] = []
        explained: set[Component] = set()
        for finding in suspected:
            if any(explains(other, finding, evidence) for other in accepted):
                explained.add(finding.component)
            else:
                accepted.append(finding)
        return explained


def explains(cause: Finding, image: Finding, evidence: Evidence) -> bool:
    """Return whether the lines of a deeper finding explain those of another."""
    band = evidence.of_band(image.band)
    if cause.rule is None or image.rule is None or cause.comb is None or image.comb is None or band is None:
        return False
    there = cause.rule.family(band, cause.comb)
    if image.lines.depth_per_line < image.rule.p.shadow * there.depth_per_line:
        return True
    # Where the cause is faint, its order is that of noise: its lines are those of the band in which it was found.
    faint = there.depth < image.rule.p.shadow * cause.lines.depth
    companions = cause.rule.companions(cause.lines if faint else there, evidence.orders)
    remaining = band.remainder(image.comb, image.lines, companions).depth
    return bool(remaining < max(image.rule.depth, LEAST_REMAINDER * image.lines.depth))
