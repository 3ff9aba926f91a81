"""Findings combined: the strongest per component counts, and lines that those of another component explain are discarded."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.diagnosis.combination import Combination
from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.order_spectrum import LineFamily, OrderSpectrum
from dcrb_ros.diagnosis.rule import LEAST_EXCESS, LineRule, Overlap
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.verdicts import Component

BAND = Band(2000.0, 20000.0)
SPECTRUM = OrderSpectrum(np.arange(0.0, 20.0, 0.01), np.ones(2000, np.float32), 1.0)
EVIDENCE = Evidence([BandEvidence(BAND, SPECTRUM, Orders(0.42, 6.7, 9.3, 3.0), 0.004)], BAND, BAND, 20.0, 0.5)


def rule(kind: Component, depth: float, excess: float, *overlaps: Overlap) -> LineRule[Group]:
    """Return a rule with lines of a given depth [-] and excess [dB]."""

    class Fixed(LineRule[Group]):
        component, name = kind, kind

        def lines(self, band: BandEvidence) -> LineFamily:
            return LineFamily(1.0, 1.0, depth, 1.0)

        def excess(self, lines: LineFamily, band: Band, evidence: Evidence) -> float:
            return excess

        def overlaps(self) -> Iterable[Overlap]:
            return overlaps

    return Fixed(Group())


def excess(*rules: LineRule[Group], margin: float = 1.0) -> dict[Component, float]:
    """Return the excess of the combined finding of each component."""
    return {component: finding.excess for component, finding in Combination(rules, margin).findings(EVIDENCE).items()}


def test_a_component_without_a_rule_has_the_least_excess() -> None:
    assert excess(rule("cage", 0.5, 3.0)) == {"outer_ring": LEAST_EXCESS, "inner_ring": LEAST_EXCESS, "roller": LEAST_EXCESS, "cage": 3.0}


def test_the_stronger_of_two_rules_for_a_component_counts() -> None:
    assert excess(rule("cage", 0.5, 3.0), rule("cage", 0.5, 7.0), rule("cage", 0.5, -2.0))["cage"] == 7.0


@pytest.mark.parametrize(("depth", "explained"), [(1.0, True), (0.99, False)])
def test_lines_are_explained_by_sufficiently_deeper_ones(depth: float, explained: bool) -> None:
    found = excess(rule("inner_ring", depth, 5.0, Overlap("roller", 1, 2.0)), rule("roller", 0.5, 4.0))
    assert found["inner_ring"] == 5.0
    assert found["roller"] == (-4.0 if explained else 4.0)


def test_an_explained_finding_falls_below_its_threshold_by_more_than_the_margin() -> None:
    found = excess(rule("inner_ring", 2.0, 5.0, Overlap("roller", 1, 1.0)), rule("roller", 0.5, 0.5), margin=3.0)
    assert found["roller"] == -4.0


def test_only_suspected_components_explain_others() -> None:
    assert excess(rule("inner_ring", 2.0, -0.1, Overlap("roller", 1, 1.0)), rule("roller", 0.5, 4.0))["roller"] == 4.0


def test_an_explained_finding_explains_no_other() -> None:
    inner = rule("inner_ring", 2.0, 5.0, Overlap("cage", 2, 1.0))
    roller = rule("roller", 3.0, 5.0, Overlap("inner_ring", 1, 1.0))
    found = excess(inner, roller, rule("cage", 0.5, 4.0))
    assert (found["roller"], found["inner_ring"], found["cage"]) == (5.0, -5.0, 4.0)
