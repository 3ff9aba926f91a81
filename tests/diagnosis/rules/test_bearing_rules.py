"""Rules for the bearing: which lines they look at, their thresholds and the lines that their faults also make."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.cage_lines import PERIODIC, beyond_load_zone, cage_comb, spin_of_clusters
from dcrb_ros.diagnosis.combination import Combination
from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence, SharedSearch
from dcrb_ros.diagnosis.line_search import Comb, LineFamily
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.rule import LEAST_EXCESS, Finding, LineRule, modulation_excess
from dcrb_ros.diagnosis.rules.cage import Cage
from dcrb_ros.diagnosis.rules.inner_ring import InnerRing
from dcrb_ros.diagnosis.rules.outer_ring import PAPER_BEARING, OuterRing, is_paper_bearing
from dcrb_ros.diagnosis.rules.roller import Roller

ORDERS = Orders(ftf=0.42, bpfo=6.72, bpfi=9.28, bsf=3.05)
WHOLE, HIGH, MIDDLE, BELOW = Band(2000.0, 20000.0), Band(11247.0, 20000.0), Band(3557.0, 6325.0), Band(1000.0, 2000.0)
P = DetectorParameters()


def evidence(*bands: tuple[Band, dict[float, float]], mean: float = 1.0, orders: Orders = ORDERS) -> Evidence:
    """Return bands with lines of given amplitudes [unit^2] at some orders over a background of 0.01; ``orders`` are the bearing's."""

    def spectrum(lines: dict[float, float]) -> OrderSpectrum:
        amplitude = np.full(7000, 0.01, np.float32)
        for order, value in lines.items():
            amplitude[round(100.0 * order)] = value
        return OrderSpectrum(np.arange(0.0, 70.0, 0.01), amplitude, mean)

    return Evidence([BandEvidence(band, SharedSearch([spectrum(lines)], orders, 0.004)) for band, lines in bands], WHOLE, HIGH, 20.0, 0.5)


def found_by(rule: LineRule[Any], *bands: tuple[Band, dict[float, float]], orders: Orders = ORDERS) -> Finding:
    """Return what a rule finds in bands with lines; see `evidence`."""
    finding = rule.finding(evidence(*bands, orders=orders))
    assert finding is not None
    return finding


def comb(order: float, amplitude: float, count: int = 6) -> dict[float, float]:
    return {k * order: amplitude for k in range(1, count + 1)}


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        (OuterRing(P), [Comb(6.72)]),
        (InnerRing(P), [Comb(9.28, sidebands=(-1.0, 0.0, 1.0))]),
        (Roller(P), [Comb(6.1, sidebands=(-0.42, 0.0, 0.42)), Comb(6.1, harmonics=(1,))]),
        (Cage(P), [Comb(0.42, harmonics=tuple(range(1, 14)), leading=2)]),
    ],
    ids=["outer_ring", "inner_ring", "roller", "cage"],
)
def test_a_rule_looks_at_the_lines_of_its_fault(rule: LineRule[Any], expected: list[Comb]) -> None:
    assert list(rule.combs(ORDERS)) == expected


def test_the_cage_of_a_ball_bearing_is_searched_below_its_bpfo() -> None:
    (found,) = Cage(P).combs(Orders(ftf=0.398, bpfo=3.585, bpfi=5.415, bsf=2.357))  # 6205: nine balls
    assert found.harmonics == (1, 2, 3, 4, 5, 6)


def test_each_rule_has_its_bands() -> None:
    found = evidence((WHOLE, {}), (MIDDLE, {}), (HIGH, {}), (BELOW, {}))
    bands = [[band.band for band in rule.bands(found)] for rule in (OuterRing(P), InnerRing(P), Roller(P), Cage(P))]
    assert bands == [[WHOLE, MIDDLE, HIGH]] * 3 + [[WHOLE, MIDDLE, HIGH, BELOW]]
    baseline = OuterRing(DetectorParameters(outer_limit=30.0, outer_limit_high=10.0))
    assert [band.band for band in baseline.bands(found)] == [WHOLE, HIGH]


def test_depth_and_significance_must_both_reach_their_thresholds() -> None:
    def excess(depth: float, significance: float, price: float = 0.0) -> float:
        return modulation_excess(LineFamily(1.0, 1.0, depth, 1.0, significance), 0.2, 1e-4, price)

    assert excess(0.2, 4.0) == pytest.approx(0.0, abs=1e-12)
    assert excess(2.0, 4.0) == pytest.approx(10.0)
    assert excess(2.0, 0.4) == pytest.approx(-10.0)
    assert excess(0.02, 40.0) == pytest.approx(-10.0)
    assert excess(2.0, 0.5 + 2.0, price=0.5) == pytest.approx(-3.0103)
    assert excess(2.0, -3.0) < LEAST_EXCESS
    assert excess(0.02, 2.0) == pytest.approx(-10.0)


@pytest.mark.parametrize(
    ("rule", "lines"),
    [
        (OuterRing(P), comb(6.72, 0.5)),
        (InnerRing(P), comb(9.28, 0.5)),
        (Roller(P), comb(6.1, 0.5) | {0.42: 0.3}),
        (Cage(P), comb(0.42, 0.5, 13)),
    ],
    ids=["outer_ring", "inner_ring", "roller", "cage"],
)
def test_a_rule_finds_its_lines_in_the_band_where_they_are_deepest(rule: LineRule[Any], lines: dict[float, float]) -> None:
    weak = {order: 0.5 * amplitude for order, amplitude in lines.items()}
    finding = found_by(rule, (WHOLE, weak), (MIDDLE, lines), (HIGH, {}))
    assert (finding.component, finding.band and finding.band.band) == (rule.component, MIDDLE)
    assert finding.lines.depth == pytest.approx(0.5, rel=0.05)
    assert 0.0 < finding.excess <= 10.0 * math.log10(finding.lines.depth / rule.depth) + 1e-9
    assert f"{rule.name} at {finding.lines.order:.3f} orders modulates the squared envelope by 0.50 of its mean" in finding.reason


def test_a_band_without_lines_gives_the_least_excess() -> None:
    for rule in (OuterRing(P), InnerRing(P), Roller(P), Cage(P)):
        assert found_by(rule, (WHOLE, {})).excess == LEAST_EXCESS == -60.0


@pytest.mark.parametrize(("beside", "suspected"), [(0.3, True), (0.5, False)])
def test_bpfo_must_stand_out_of_the_harmonics_of_the_cage(beside: float, suspected: bool) -> None:
    """1.5 dB are a ratio of 1.41 of squared envelopes: 0.5 over 0.35."""
    lines = comb(6.72, 0.5) | {k * 6.72 + s * 0.42: beside for k in (1, 2, 3) for s in (-1, 1)}
    assert (found_by(OuterRing(P), (WHOLE, lines)).excess >= 0.0) is suspected


@pytest.mark.parametrize("rule", [OuterRing(P), InnerRing(P)], ids=["outer_ring", "inner_ring"])
@pytest.mark.parametrize(("carrier", "suspected"), [(0.34, True), (0.37, False)])
@pytest.mark.parametrize("harmonic", [1, 2])
def test_what_the_cage_carries_is_no_ring(rule: LineRule[Any], carrier: float, suspected: bool, harmonic: int) -> None:
    """1.5 dB are a ratio of 1.41 of squared envelopes: 0.5 over 0.354."""
    (order,) = (one.order for one in rule.combs(ORDERS))
    assert (found_by(rule, (WHOLE, comb(order, 0.5) | {harmonic * 0.42: carrier})).excess >= 0.0) is suspected


@pytest.mark.parametrize("spin", [0.92, 0.97])
@pytest.mark.parametrize("strikes", [1, 2])
def test_harmonics_of_the_cage_that_cluster_at_a_slower_spin_are_a_roller(spin: float, strikes: int) -> None:
    """A roller that slips by 3 or 8 %; its two strikes per turn may differ, which adds clusters halfway between."""
    period = 6.1 * spin / strikes
    lines = {0.42 * k: 0.35 * (1.0 + 0.9 * math.cos(2.0 * math.pi * 0.42 * k / period)) for k in range(1, 50)}
    roller, cage = (found_by(rule, (WHOLE, lines)) for rule in (Roller(P), Cage(P)))
    assert roller.excess > 0.0 > cage.excess
    if strikes == 2:
        assert roller.lines.order == pytest.approx(6.1 * spin, abs=0.25)


@pytest.mark.parametrize(("order", "found"), [(5.95, True), (5.53, True), (14.0 * 0.42, False)])
def test_a_roller_that_lost_spin_has_its_lines_beside_the_harmonics_of_the_cage(order: float, found: bool) -> None:
    """Lines with sidebands at FTF, 2.5 to 9 % below 2 BSF; on a harmonic of FTF, they may as well be those of a broken bar."""
    lines = {0.42: 0.5, 0.84: 0.45} | {h * order + k * 0.42: 0.6 for h in (1, 2, 3) for k in (-1, 0, 1)}
    finding = found_by(Roller(P), (WHOLE, lines))
    assert (finding.excess > 0.0 and finding.lines.order == pytest.approx(order, rel=1e-3)) is found
    assert Roller(P).families(ORDERS) == 3  # at 2 BSF, at a slower spin, and the hump


@pytest.mark.parametrize(("cage", "suspected"), [(0.19, True), (0.17, False), (0.0, False)])
@pytest.mark.parametrize("harmonic", [1, 2])
def test_the_cage_must_modulate_sharp_lines_of_a_roller(cage: float, suspected: bool, harmonic: int) -> None:
    """FTF or its double has at least 0.36 of the line at 2 BSF, 0.18 of 0.5: otherwise no load zone carries the strikes."""
    assert (found_by(Roller(P), (WHOLE, comb(6.1, 0.5) | {harmonic * 0.42: cage})).excess >= 0.0) is suspected


@pytest.mark.parametrize(("rolling", "expected"), [(16, 0.31), (9, 0.4136)])
def test_rollers_that_differ_are_no_cage_fault(rolling: int, expected: float) -> None:
    """Energies that scatter by 0.7 make lines of the mean depth 0.7 sqrt(pi / Z); the formula is checked against drawn energies."""
    orders = Orders(ftf=0.42, bpfo=0.42 * rolling, bpfi=0.58 * rolling, bsf=3.05)
    assert 0.17 * 10.0 ** (Cage(P).healthy_evidence(orders) / 10.0) == pytest.approx(expected, abs=5e-4)
    energies = 1.0 + 0.7 * np.random.default_rng(1).uniform(-math.sqrt(3.0), math.sqrt(3.0), (20000, rolling))
    lines = 2.0 * np.abs(np.fft.rfft(energies, axis=1)[:, 1 : rolling // 2]) / energies.sum(axis=1)[:, None]
    assert lines.mean() == pytest.approx(expected, rel=0.1)
    assert Cage(DetectorParameters(cage_scatter=0.0)).healthy_evidence(orders) == 0.0


def weighted_by_the_load_zone(half: float, depth: float = 0.4) -> dict[float, float]:
    """Return lines at k FTF of a mean depth over 13, of the weight cos^1.5 within an angle on either side of the load [degrees]."""
    angle = np.linspace(-180.0, 180.0, 4096, endpoint=False)
    weight = np.where(np.abs(angle) < half, np.maximum(np.cos(0.5 * math.pi * angle / half), 0.0) ** 1.5, 0.0)
    harmonics = np.abs(np.fft.rfft(weight))[1:40]
    return {0.42 * k: float(value * depth / harmonics[:13].mean()) for k, value in enumerate(harmonics, 1)}


@pytest.mark.parametrize(("half", "component"), [(90.0, "roller"), (75.0, "roller"), (60.0, "roller"), (22.5, "cage")])
def test_lines_of_the_cage_that_end_with_the_load_zone_are_those_of_a_roller(half: float, component: str) -> None:
    """A damaged roller is as loud as the load zone is deep; a broken bar lets rollers go for two pitches, a pitch of 22.5 degrees each."""
    finding = found_by(Cage(P), (WHOLE, weighted_by_the_load_zone(half)))
    assert (finding.component, finding.excess > 0.0) == (component, True)


def test_the_severity_is_that_of_the_lines_that_name_the_fault() -> None:
    """Lines of the cage that end with the load zone, and those that cluster at 2 BSF, which no search of sharp lines at 2 BSF has."""
    clustered = {0.42 * k: 0.5 if k % 14 in (0, 1, 13) else 0.05 for k in range(1, 60)}
    for lines in (weighted_by_the_load_zone(60.0), clustered):
        found, detector = evidence((WHOLE, lines)), FaultDetector(ORDERS, 51200)
        findings = detector._combination.findings(found)
        assert findings["roller"].excess > 0.0
        assert detector._severity(found, ["roller"], findings) == pytest.approx(findings["roller"].lines.amplitude ** 0.5)


@pytest.mark.parametrize(("share", "component"), [(0.27, "roller"), (0.33, "cage")])
def test_lines_beyond_the_load_zone_must_have_three_tenths_of_those_within(share: float, component: str) -> None:
    lines = {0.42 * k: 0.6 if k <= 5 else 0.6 * share for k in range(1, 14)}
    finding = found_by(Cage(P), (WHOLE, lines))
    assert (finding.component, finding.excess > 0.0) == (component, True)


def test_the_level_at_ftf_remains_that_of_ftf_if_the_lines_are_those_of_a_roller() -> None:
    combination = Combination([Roller(P), Cage(P)], 1.0)
    findings = combination.findings(evidence((WHOLE, weighted_by_the_load_zone(60.0))))
    assert findings["roller"].excess > 0.0 > findings["cage"].excess
    assert combination.levels["cage"] > 20.0 > combination.levels["roller"]


def test_one_band_in_which_the_lines_end_with_the_load_zone_suffices_for_a_roller() -> None:
    wide = comb(0.42, 0.5, 9)
    assert found_by(Cage(P), (WHOLE, wide), (BELOW, weighted_by_the_load_zone(60.0))).component == "roller"


@pytest.mark.parametrize("rolling", [9, 11])
def test_lines_of_few_rolling_elements_do_not_reach_beyond_the_load_zone(rolling: int) -> None:
    """Half of their number is less than the five harmonics of the load zone."""
    orders = Orders(ftf=0.42, bpfo=0.42 * rolling, bpfi=0.58 * rolling, bsf=3.05)
    (band,) = evidence((WHOLE, weighted_by_the_load_zone(60.0)), orders=orders).bands
    assert beyond_load_zone(band, band.family(cage_comb(orders))) == 0.0


def test_a_roller_needs_more_than_the_scatter_of_unequal_rollers() -> None:
    """2.6 dB with 16 rollers, a mean depth of 0.31."""
    for depth, suspected in ((0.28, False), (0.34, True)):
        finding = found_by(Cage(P), (WHOLE, weighted_by_the_load_zone(60.0, depth)))
        assert (finding.component, finding.excess > 0.0) == ("roller", suspected)


def test_even_or_falling_harmonics_of_the_cage_do_not_cluster() -> None:
    for fall in (1.0, 0.95, 0.8):
        (there,) = evidence((WHOLE, {0.42 * k: 0.5 * fall**k for k in range(1, 50)})).bands
        assert spin_of_clusters(there, there.family(cage_comb(ORDERS)))[0] < PERIODIC


@pytest.mark.parametrize(("below", "loud"), [(39.0, True), (41.0, False)])
def test_a_band_far_below_the_loudest_is_no_evidence(below: float, loud: bool) -> None:
    strong, weak = (
        evidence((BELOW, {}), mean=1e4),
        evidence((MIDDLE, comb(6.72, 0.5 * 10.0 ** (4.0 - 0.1 * below))), mean=10.0 ** (4.0 - 0.1 * below)),
    )
    found = Evidence([*weak.bands, *strong.bands], WHOLE, HIGH, 20.0, 0.5)
    assert [band.band for band in OuterRing(P).bands(found)] == [MIDDLE] * loud
    assert [band.band for band in Cage(P).bands(found)] == [MIDDLE] * loud + [BELOW]


@pytest.mark.parametrize(("share", "loud"), [(0.025, False), (0.035, True)])
def test_a_band_with_a_small_share_of_the_power_is_no_evidence(share: float, loud: bool) -> None:
    """Healthy rollers strike the raceway where they enter the load zone, and no defect is that faint in all loud bands."""
    whole, faint, below = evidence((WHOLE, {})), evidence((MIDDLE, {}), mean=share), evidence((BELOW, {}), mean=share)
    found = Evidence([*whole.bands, *faint.bands, *below.bands], WHOLE, HIGH, 20.0, 0.5)
    assert [band.band for band in Cage(P).bands(found)] == [WHOLE] + [MIDDLE] * loud + [BELOW]


@pytest.mark.parametrize(("double", "suspected"), [(0.0, True), (0.5, True), (0.69, True), (0.72, False), (1.5, False)])
def test_rollers_that_excite_twice_per_pass_are_no_outer_ring_defect(double: float, suspected: bool) -> None:
    """1.5 dB are a ratio of 1.41 of squared envelopes: 0.706 over 0.5."""
    assert (found_by(OuterRing(P), (WHOLE, comb(6.72, 0.5) | {2 * 6.72: double})).excess >= 0.0) is suspected


@pytest.mark.parametrize(("scatter", "suspected"), [(0.0, True), (0.03, True), (0.075, False), (0.1, False)])
def test_strikes_that_scatter_over_the_pitch_are_no_outer_ring_defect(scatter: float, suspected: bool) -> None:
    """Strikes that scatter by a share s of the pitch have harmonics of exp(-2 (pi k s)^2); the edge of the load zone is no one place."""
    lines = {k * 6.72: 0.6 * math.exp(-2.0 * (math.pi * k * scatter) ** 2) for k in range(1, 7)}
    assert (found_by(OuterRing(P), (WHOLE, lines)).excess >= 0.0) is suspected


def test_impacts_that_ring_long_are_an_outer_ring_defect() -> None:
    """If impacts ring much longer than a pitch, their harmonics fall as 1 / k, and no faster."""
    assert found_by(OuterRing(P), (WHOLE, {k * 6.72: 0.6 / k for k in range(1, 7)})).excess >= 0.0


def test_nothing_follows_from_harmonics_that_a_narrow_band_or_noise_hides() -> None:
    narrow = Band(2000.0, 4000.0)  # 15 harmonics of 134 Hz
    for band, scale in ((narrow, 1.0), (WHOLE, 0.1)):
        lines = {k * 6.72: scale * 0.6 for k in (1, 2, 3)}
        found = evidence((band, lines), mean=0.2 * scale)
        rule, there = OuterRing(P), found.bands[0]
        family = rule.family(there, Comb(6.72))
        assert rule.excess(family, there, found) >= 0.0


def test_a_line_hidden_by_the_shaft_tells_nothing_about_the_rhythm() -> None:
    """BPFO within the resolution of the third harmonic of the shaft: its line is masked in part."""
    near = Orders(ftf=0.425, bpfo=3.06, bpfi=3.94, bsf=3.25)
    lines = {3.06: 0.3, 6.12: 0.6, 9.18: 0.5, 12.24: 0.5, 15.3: 0.5, 18.36: 0.5}
    assert found_by(OuterRing(P), (WHOLE, lines), orders=near).excess >= 0.0


@pytest.mark.parametrize("clustered", [True, False])
def test_harmonics_of_the_cage_that_cluster_at_2_bsf_are_those_of_a_roller(clustered: bool) -> None:
    lines = {0.42 * k: 0.8 if not clustered or abs((0.42 * k / 6.1 + 0.5) % 1.0 - 0.5) < 0.25 else 0.4 for k in range(1, 40)}
    cage, roller = (found_by(rule, (WHOLE, lines)) for rule in (Cage(P), Roller(P)))
    assert cage.lines.depth > P.cage_depth
    assert (cage.excess < 0.0, roller.lines.depth > 0.5) == (clustered, clustered)


def test_the_companions_of_a_fault_are_its_harmonics_with_sidebands() -> None:
    lines = LineFamily(6.72, 1.0, 1.0, 1.0)
    outer = OuterRing(P).companions(lines, ORDERS)
    for order in (6.72, 2 * 6.72 + 2.0, 6.72 - 1.0 + 3 * 0.42, 0.42, 1.0, 6 * 6.72):
        assert np.abs(outer - order).min() < 1e-9
    assert np.abs(outer - 9.28).min() > 0.03
    cage = Cage(P).companions(LineFamily(0.42, 1.0, 1.0, 1.0), ORDERS)
    assert np.abs(cage - 6.72).min() < 1e-9
    assert np.abs(InnerRing(P).companions(LineFamily(9.28, 1.0, 1.0, 1.0), ORDERS) - (9.28 - 3.0)).min() < 1e-9


@pytest.mark.parametrize(("band", "limit"), [(WHOLE, 38.0), (HIGH, 12.0)])
def test_with_a_baseline_the_lines_are_also_compared_with_the_limit_of_their_band(band: Band, limit: float) -> None:
    rule, found = OuterRing(DetectorParameters(outer_limit=38.0, outer_limit_high=12.0)), evidence((band, {}))
    (there,) = found.bands
    assert rule.excess(LineFamily(6.7, limit**2, 2.0, 9.0, 99.0), there, found) == pytest.approx(0.0, abs=1e-12)
    assert rule.excess(LineFamily(6.7, 10.0 * limit**2, 2.0, 99.0, 99.0), there, found) == pytest.approx(10.0)
    assert rule.excess(LineFamily(6.7, 10.0 * limit**2, 0.017, 9.0, 99.0), there, found) == pytest.approx(-10.0)
    reason = rule.reason(LineFamily(6.7, 100.0, 2.0, 9.0), there, found)
    size = f"10 m/s^2 (baseline {limit:g} m/s^2, both at a shaft frequency of 20 Hz)"
    assert reason == f"BPFO at 6.700 orders has {size}, 9.0 dB over background from {band}"


def test_limits_are_learned_with_their_margin_for_their_time() -> None:
    rule = OuterRing(DetectorParameters(learn=1.0))
    loud = comb(6.72, 2500.0)
    found = evidence((WHOLE, loud), (HIGH, loud), mean=100.0)
    finding = Finding("outer_ring", 5.0, "loud")
    assert rule.remark == "learning for another 1.0 s: outer-ring defects are not reported yet"
    assert rule.settled(finding, found).excess == -1.0
    assert rule.settled(finding._replace(excess=-7.0), found).excess == -7.0
    assert "baseline" in rule.remark
    assert rule.settled(finding, found).excess == 5.0  # a second, in hops of half a second
    limit = 50.0 * 10.0 ** (4.0 / 20.0)
    for band in found.bands:
        assert rule.excess(LineFamily(6.7, limit**2, 2.0, 9.0, 99.0), band, found) == pytest.approx(0.0, abs=0.01)


def test_only_the_bearing_of_the_paper_has_a_known_baseline() -> None:
    assert is_paper_bearing(PAPER_BEARING)
    for other in (None, {}, {**PAPER_BEARING, "inner_raceway_radius": 0.07896}, {**PAPER_BEARING, "rollers_per_row": "16"}):
        assert not is_paper_bearing(other)
    rule = OuterRing(P)
    rule.take_bearing(PAPER_BEARING)
    assert "baseline" in rule.remark
    limited = OuterRing(DetectorParameters(outer_limit=5.0))
    limited.take_bearing(PAPER_BEARING)
    found = evidence((WHOLE, {}))
    assert "baseline 5 m/s^2" in limited.reason(LineFamily(6.7, 1.0, 2.0, 9.0), found.bands[0], found)
