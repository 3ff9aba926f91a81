"""Findings combined: the strongest per component counts, and families that consist of the lines of another are discarded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.combination import Combination
from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence, SharedSearch
from dcrb_ros.diagnosis.line_search import Comb
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum
from dcrb_ros.diagnosis.rule import LEAST_EXCESS, LineParameters, LineRule
from dcrb_ros.schema.verdicts import Component

BAND = Band(2000.0, 20000.0)
OUTER, INNER = 6.73, 9.27


def evidence(**lines: float) -> Evidence:
    """Return a spectrum of noise with three harmonics at the orders of a name, such as ``o`` for 6.73, of given amplitudes."""
    spectrum = OrderSpectrum(np.arange(0.0, 60.0, 0.01), np.sqrt(np.random.default_rng(1).exponential(1e-4, 6000)).astype(np.float32), 1.0)
    for name, amplitude in lines.items():
        for harmonic in (1, 2, 3):
            spectrum.amplitude[round(100.0 * harmonic * {"o": OUTER, "i": INNER, "s": OUTER + 2.54}[name])] = amplitude
    return Evidence([BandEvidence(BAND, SharedSearch([spectrum], Orders(0.42, OUTER, INNER, 3.05), 0.004))], BAND, BAND, 20.0, 0.5)


def rule(kind: Component, order: float, *companions: float) -> LineRule[LineParameters]:
    """Return a rule for three harmonics of an order, whose fault also makes other lines [orders]."""

    class Fixed(LineRule[LineParameters]):
        component, name, depth = kind, kind, 0.17

        def combs(self, orders: Orders) -> Sequence[Comb]:
            return (Comb(order),)

        def companions(self, lines: object, orders: Orders) -> np.ndarray:
            return np.array(companions)

    return Fixed(LineParameters())


def excess(found: Evidence, *rules: LineRule[LineParameters], margin: float = 1.0) -> dict[Component, float]:
    """Return the excess of the combined finding of each component."""
    return {component: finding.excess for component, finding in Combination(rules, margin).findings(found).items()}


def test_a_component_without_a_rule_has_the_least_excess() -> None:
    found = excess(evidence(o=1.0), rule("cage", OUTER))
    assert found.pop("cage") > 0.0
    assert set(found.values()) == {LEAST_EXCESS}


def test_the_stronger_of_two_rules_for_a_component_counts() -> None:
    found = evidence(o=1.0, i=0.3)
    strong, weak = rule("cage", OUTER), rule("cage", INNER)
    assert excess(found, weak, strong)["cage"] == excess(found, strong)["cage"] > excess(found, weak)["cage"] > 0.0


@pytest.mark.parametrize(("depth", "kept"), [(0.4, False), (0.6, True)])
def test_lines_less_than_half_as_deep_are_explained(depth: float, kept: bool) -> None:
    found = excess(evidence(o=1.0, i=depth), rule("outer_ring", OUTER), rule("cage", INNER))
    assert found["outer_ring"] > 0.0
    assert (found["cage"] > 0.0) is kept


@pytest.mark.parametrize(
    ("first", "second", "third", "kept"),
    [(0.4, 0.4, 0.4, True), (0.4, 0.3, 0.2, True), (0.4, 0.05, 0.3, False), (0.3, 0.3, 0.6, False), (0.23, 0.23, 0.23, False)],
    ids=["even", "falling", "one missing", "growing", "too faint"],
)
def test_a_ring_is_named_beside_another_with_a_fifth_of_the_power(first: float, second: float, third: float, kept: bool) -> None:
    """Lines of depths 1 and 0.25 are impacts with four fifths and one fifth of the power; an image has uneven lines."""
    found = evidence(o=1.0)
    for harmonic, value in enumerate((first, second, third), 1):
        found.bands[0].spectrum.amplitude[round(100.0 * harmonic * INNER)] = value
    combined = excess(found, rule("outer_ring", OUTER), rule("inner_ring", INNER))
    assert combined["outer_ring"] > 0.0
    assert (combined["inner_ring"] > 0.0) is kept


def test_lines_that_the_other_fault_makes_are_explained_at_any_depth() -> None:
    images = tuple(harmonic * INNER for harmonic in (1, 2, 3))
    found = evidence(o=1.0, i=0.95)
    assert excess(found, rule("outer_ring", OUTER), rule("inner_ring", INNER))["inner_ring"] > 0.0
    assert excess(found, rule("outer_ring", OUTER, *images), rule("inner_ring", INNER), margin=3.0)["inner_ring"] <= -4.0


def test_only_suspected_components_explain_others() -> None:
    found = evidence(o=0.1, i=0.9)
    assert excess(found, rule("outer_ring", OUTER, INNER, 2 * INNER, 3 * INNER), rule("inner_ring", INNER))["inner_ring"] > 0.0


def test_an_explained_finding_explains_no_other() -> None:
    third = 9.27
    inner = rule("inner_ring", INNER, 3.07, 6.14, 9.21)
    found = evidence(o=1.0, i=0.8)
    for harmonic in (1, 2, 3):
        found.bands[0].spectrum.amplitude[round(307.0 * harmonic)] = 0.6
    combined = excess(found, rule("outer_ring", OUTER, third, 2 * third, 3 * third), inner, rule("cage", 3.07))
    assert (combined["outer_ring"] > 0.0, combined["inner_ring"] > 0.0, combined["cage"] > 0.0) == (True, False, True)
