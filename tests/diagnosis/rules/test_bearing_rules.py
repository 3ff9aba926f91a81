"""Rules for the bearing: which lines they look at, their thresholds and their overlaps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.order_spectrum import LineFamily, OrderSpectrum
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.rule import LEAST_EXCESS, Finding, LineRule, Overlap, modulation_excess
from dcrb_ros.diagnosis.rules.cage import Cage
from dcrb_ros.diagnosis.rules.inner_ring import InnerRing
from dcrb_ros.diagnosis.rules.outer_ring import OuterRing
from dcrb_ros.diagnosis.rules.roller import Roller

ORDERS = Orders(ftf=0.42, bpfo=6.72, bpfi=9.28, bsf=3.05)
WHOLE, HIGH, MIDDLE, BELOW = Band(2000.0, 20000.0), Band(11247.0, 20000.0), Band(3557.0, 6325.0), Band(1000.0, 2000.0)
P = DetectorParameters()


def spectrum(lines: dict[float, float], mean: float = 10.0) -> OrderSpectrum:
    """Return a spectrum of background 1 with amplitudes at some orders."""
    orders = np.arange(0.0, 70.0, 0.01)
    amplitude = np.ones(len(orders), np.float32)
    for order, value in lines.items():
        amplitude[round(order / 0.01)] = value
    return OrderSpectrum(orders, amplitude, mean)


def evidence(*bands: tuple[Band, dict[float, float]], mean: float = 10.0) -> Evidence:
    return Evidence([BandEvidence(band, spectrum(lines, mean), ORDERS, 0.004) for band, lines in bands], WHOLE, HIGH, 20.0, 0.5)


class Asked(BandEvidence):
    """A band that finds every line at its kinematic order and notes which lines a rule asks for."""

    def __init__(self) -> None:
        super().__init__(WHOLE, spectrum({}), ORDERS, 0.004)
        self.asked: list[tuple[float, list[float]]] = []

    def fitted(self, *orders: float) -> list[float]:
        return list(orders)

    def lines(self, order: float, lines: Any) -> LineFamily:
        self.asked.append((order, sorted(np.ravel(lines).tolist())))
        return LineFamily(order, float(order), float(order), 1.0)


@pytest.mark.parametrize(
    ("rule", "order", "families"),
    [
        (OuterRing(P), 13.44, [[6.72, 13.44, 20.16], [13.44, 26.88, 40.32]]),
        (
            InnerRing(P),
            18.56,
            [[k * 9.28 + s for k in (1, 2, 3) for s in (-2, -1, 0, 1, 2)], [k * 18.56 + s for k in (1, 2, 3) for s in (-2, -1, 0, 1, 2)]],
        ),
        (Roller(P), 6.1, [[k * 6.1 + s * 0.42 for k in (1, 2, 3) for s in (-1, 0, 1)]]),
        (Cage(P), 0.42, [[k * 0.42 for k in range(1, 14)]]),
    ],
    ids=["outer_ring", "inner_ring", "roller", "cage"],
)
def test_a_rule_looks_at_the_lines_of_its_fault(rule: LineRule[Any], order: float, families: list[list[float]]) -> None:
    band = Asked()
    assert rule.lines(band).order == pytest.approx(order)  # the deeper family of two
    assert len(band.asked) == len(families)
    for (_, asked), expected in zip(band.asked, families, strict=True):
        assert asked == pytest.approx(sorted(expected))


def test_each_component_may_imitate_others() -> None:
    assert [tuple(rule.overlaps()) for rule in (OuterRing(P), InnerRing(P), Roller(P), Cage(P))] == [
        (),
        (Overlap("roller", 2, 2.0), Overlap("cage", 4, 2.0), Overlap("outer_ring", 4, 2.0)),
        (Overlap("inner_ring", 3, 2.0), Overlap("outer_ring", 4, 2.0), Overlap("cage", 5, 0.0)),
        (Overlap("outer_ring", 1, 0.7), Overlap("inner_ring", 1, 0.7), Overlap("roller", 1, 0.7)),
    ]


def test_each_rule_has_its_bands() -> None:
    found = evidence((WHOLE, {}), (MIDDLE, {}), (HIGH, {}), (BELOW, {}))
    bands = [[band.band for band in rule.bands(found)] for rule in (OuterRing(P), InnerRing(P), Roller(P), Cage(P))]
    assert bands == [[WHOLE, HIGH], [WHOLE, MIDDLE, HIGH], [WHOLE, MIDDLE, HIGH], [WHOLE, MIDDLE, HIGH, BELOW]]


@pytest.mark.parametrize(
    ("rule", "depth", "level"), [(InnerRing(P), 0.08, 7.0), (Roller(P), 0.2, 7.0), (Cage(P), 0.08, 6.0)], ids=["inner", "roller", "cage"]
)
def test_depth_and_level_must_both_reach_their_thresholds(rule: LineRule[Any], depth: float, level: float) -> None:
    found = evidence((WHOLE, {}))
    assert rule.excess(LineFamily(1.0, 1.0, depth, level), WHOLE, found) == pytest.approx(0.0, abs=1e-12)
    assert rule.excess(LineFamily(1.0, 1.0, 10.0 * depth, level + 3.0), WHOLE, found) == pytest.approx(3.0)
    assert rule.excess(LineFamily(1.0, 1.0, 0.1 * depth, level + 3.0), WHOLE, found) == pytest.approx(-10.0)
    assert modulation_excess(LineFamily(1.0, 1.0, depth, level), depth, level) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("band", "limit"), [(WHOLE, 38.0), (HIGH, 12.0)])
def test_outer_ring_lines_are_compared_with_the_limit_of_their_band(band: Band, limit: float) -> None:
    rule, found = OuterRing(P), evidence((WHOLE, {}))
    assert rule.excess(LineFamily(6.7, limit**2, 2.0, 9.0), band, found) == pytest.approx(0.0, abs=1e-12)
    assert rule.excess(LineFamily(6.7, 10.0 * limit**2, 30.0, 9.0), band, found) == pytest.approx(10.0)
    assert rule.excess(LineFamily(6.7, 10.0 * limit**2, 0.3, 9.0), band, found) == pytest.approx(0.0, abs=1e-12)
    assert rule.excess(LineFamily(6.7, 10.0 * limit**2, 0.03, 9.0), band, found) == pytest.approx(-20.0)  # squared depth
    reason = rule.reason(LineFamily(6.7, 100.0, 2.0, 9.0), band, found)
    size = f"10 m/s^2 (limit {limit:g} m/s^2, both at a shaft frequency of 20 Hz)"
    assert reason == f"BPFO at 6.700 orders has {size}, 9.0 dB over background from {band}"


def test_without_a_limit_the_reason_gives_the_depth() -> None:
    rule = OuterRing(DetectorParameters(outer_limit=0.0))
    assert "modulates the squared envelope by 0.50 of its mean" in rule.reason(LineFamily(6.7, 1.0, 0.5, 9.0), WHOLE, evidence((WHOLE, {})))


def test_a_rule_reports_the_band_with_the_strongest_evidence() -> None:
    comb = {k * 0.42: 4.0 for k in range(1, 14)}
    strong = {k * 0.42: 8.0 for k in range(1, 14)}
    finding = Cage(P).finding(evidence((WHOLE, comb), (MIDDLE, strong), (BELOW, comb)))
    assert finding is not None
    assert (finding.component, finding.band) == ("cage", MIDDLE)
    assert finding.lines.amplitude == 8.0
    assert finding.lines.depth == pytest.approx(0.8)
    assert finding.excess == pytest.approx(10.0 * np.log10(8.0) - 6.0, abs=1e-6)


def test_a_finding_has_at_least_the_least_excess() -> None:
    finding = Cage(P).finding(evidence((WHOLE, {}), mean=1e12))
    assert finding is not None
    assert finding.excess == LEAST_EXCESS == -60.0


def test_limits_are_learned_with_their_margin_for_their_time() -> None:
    rule = OuterRing(DetectorParameters(learn=1.0))
    loud = {k * 6.72: 2500.0 for k in (1, 2, 3)}
    found = evidence((WHOLE, loud), (HIGH, loud), mean=100.0)
    finding = Finding("outer_ring", 5.0, "loud")
    assert rule.remark == "learning for another 1.0 s: outer-ring defects are not reported yet"
    assert rule.settled(finding, found).excess == -1.0
    assert rule.settled(finding._replace(excess=-7.0), found).excess == -7.0
    assert rule.remark == ""
    assert rule.settled(finding, found).excess == 5.0  # a second, in hops of half a second
    limit = 50.0 * 10.0 ** (4.0 / 20.0)
    for band in (WHOLE, HIGH):
        assert rule.excess(LineFamily(6.7, limit**2, 2.0, 9.0), band, found) == pytest.approx(0.0, abs=1e-9)
    quiet = OuterRing(DetectorParameters(learn=1.0))
    quiet.settled(finding, evidence((WHOLE, {}), (HIGH, {})))
    assert quiet.excess(LineFamily(6.7, 38.0**2, 2.0, 9.0), WHOLE, found) == pytest.approx(0.0, abs=1e-12)


def test_the_order_of_the_cage_slips_with_the_fitted_bpfo() -> None:
    band = BandEvidence(WHOLE, spectrum({k * 6.7: 50.0 for k in (1, 2, 3)}), ORDERS, 0.004)
    assert band.outer_ring_orders[0] == pytest.approx(6.7, abs=0.004)
    assert band.cage_order == pytest.approx(0.42 * band.outer_ring_orders[0] / 6.72)
    assert band.outer_ring_orders[1] == pytest.approx(13.4, abs=0.06)
