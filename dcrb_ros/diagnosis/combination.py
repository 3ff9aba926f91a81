"""The findings of all rules combined: one per component, without those that the lines of another component explain.

Families overlap: sidebands and harmonics of one fault lie on lines of another, and the search for a departure from the kinematic orders
adds chances. The joint explanation is found in steps, as in matching pursuit (Mallat and Zhang 1993): the deepest family is accepted with
all the lines that its fault makes, and another one is accepted only if it is left without those lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.line_search import Comb, LineFamily
from dcrb_ros.diagnosis.rule import LEAST_EXCESS, BearingRule, Finding
from dcrb_ros.schema.verdicts import COMPONENTS, Component

LEAST_REMAINDER = 0.5
"""Share of the modulation depth that an independent family keeps without the lines of another [-]: more of its lines are left than not."""

RINGS: tuple[Component, ...] = ("outer_ring", "inner_ring")
"""Components whose defects all rolling elements strike."""
FAINTER = 0.5
"""Share of the usual limit up to which lines like those of impacts are no image of another ring's [-]: with `shadow` 0.5, a defect that
has a fifth of the power is named."""
LARGEST_GROWTH = 2.0
"""Largest power of a sideband over that of its harmonic, or of a harmonic over the first [-]: a scatter of 1.5 dB of the amplitude."""
LEAST_FALL = 0.25
"""Amplitude of a harmonic over that of the first, the least of impacts [-]: if they ring exponentially, it falls no faster than 1 / k."""


class Combination:
    """Combines the findings of rules."""

    def __init__(self, rules: Sequence[BearingRule[Any]], release_margin: float) -> None:
        """Lower findings that are explained by more than ``release_margin`` [dB] below their thresholds."""
        self._rules, self._margin = rules, release_margin
        self.levels = dict.fromkeys(COMPONENTS, 0.0)
        """Level of the lines that the rules of each component searched last, even if they are evidence for another one [dB]."""

    def findings(self, evidence: Evidence) -> dict[Component, Finding]:
        """Return the strongest finding for each component, shape as in `COMPONENTS`."""
        findings = {component: Finding(component, LEAST_EXCESS, "no rule applies") for component in COMPONENTS}
        self.levels = dict.fromkeys(COMPONENTS, 0.0)
        for rule in self._rules:
            finding = rule.finding(evidence)
            if finding is None:
                continue
            self.levels[rule.component] = max(self.levels[rule.component], finding.lines.level)
            if finding.excess >= findings[finding.component].excess:
                findings[finding.component] = finding
        for component in self._explained(findings):
            excess = findings[component].excess
            findings[component] = findings[component]._replace(excess=-max(self._margin + 1.0, abs(excess)))
        for rule in self._rules:
            findings[rule.component] = rule.settled(findings[rule.component], evidence)
        return findings

    def _explained(self, findings: dict[Component, Finding]) -> set[Component]:
        """Return the suspected components whose lines those of another suspected component explain."""
        suspected = sorted(
            (finding for finding in findings.values() if finding.excess >= 0.0), key=lambda finding: -finding.lines.depth_per_line
        )
        accepted: list[Finding] = []
        explained: set[Component] = set()
        for finding in suspected:
            if any(explains(other, finding) for other in accepted):
                explained.add(finding.component)
            else:
                accepted.append(finding)
        return explained


def explains(cause: Finding, image: Finding) -> bool:
    """Return whether the lines of a deeper finding explain those of another."""
    band = image.band
    if cause.rule is None or image.rule is None or cause.comb is None or image.comb is None or band is None:
        return False
    there = cause.rule.family(band, cause.comb)
    both_rings = cause.component in RINGS and image.component in RINGS
    share = FAINTER if both_rings and like_impacts(image.lines, image.comb, band) else 1.0
    if image.lines.depth_per_line < share * image.rule.p.shadow * there.depth_per_line:
        return True
    # Where the cause is faint, its order is that of noise: its lines are those of the band in which it was found.
    faint = there.depth < image.rule.p.shadow * cause.lines.depth
    companions = cause.rule.companions(cause.lines if faint else there, band.orders)
    remaining = band.remainder(image.comb, image.lines, companions).depth
    return bool(remaining < max(image.rule.depth, LEAST_REMAINDER * image.lines.depth))


def like_impacts(lines: LineFamily, comb: Comb, band: BandEvidence) -> bool:
    """Return whether all lines of a family have amplitudes that impacts on one ring have, which an image has by chance only.

    Harmonics do not grow and none is missing. A load zone, whose weight of the impacts is nowhere negative, makes no sideband larger than
    its harmonic.
    """
    if len(lines.lines) < len(comb.harmonics):
        return False
    power = band.at(np.add.outer(np.array(lines.lines), np.array(comb.sidebands)))
    centre = power[:, list(comb.sidebands).index(0.0)]
    none_grows = (power.max(axis=1) <= LARGEST_GROWTH * centre).all() and (centre <= LARGEST_GROWTH * centre[0]).all()
    return bool(none_grows and (centre >= LEAST_FALL**2 * centre[0]).all())
