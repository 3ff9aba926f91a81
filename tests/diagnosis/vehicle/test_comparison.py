"""The same lines compared in several boxes: which of them are evidence where the lines of a wheel lie."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence, SharedSearch
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.rule import LEAST_EXCESS, Finding
from dcrb_ros.diagnosis.rules.cage import Cage
from dcrb_ros.diagnosis.rules.inner_ring import InnerRing
from dcrb_ros.diagnosis.rules.outer_ring import OuterRing
from dcrb_ros.diagnosis.rules.roller import Roller
from dcrb_ros.diagnosis.vehicle.arrival import TurnEnvelopes
from dcrb_ros.diagnosis.vehicle.box_detector import fainter
from dcrb_ros.diagnosis.vehicle.comparison import Compared, Judgement, compare, contrast
from dcrb_ros.diagnosis.vehicle.detector import _reason
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.schema.verdicts import COMPONENTS, Component

ORDERS = Orders(ftf=0.42, bpfo=6.72, bpfi=9.28, bsf=3.05)
WHOLE, HIGH = Band(2000.0, 20000.0), Band(11247.0, 20000.0)
P, Q = DetectorParameters(), VehicleDetectorParameters()
FTF = {0.42: 0.5, 0.84: 0.4}
"""Modulation by the cage."""
OTHERS = ("axle_1/right", "axle_2/left", "axle_2/right")
Lines = dict[float, float]


def judged(lines: Lines, component: Component, frequency: float = 20.0, orders: Orders = ORDERS) -> Judgement:
    """Return what a box whose shaft turns at a frequency [Hz] finds in lines of given depths at some orders over a background of 0.01."""
    amplitude = np.full(7000, 0.01, np.float32)
    for order, depth in lines.items():
        amplitude[round(100.0 * order)] = depth
    search = SharedSearch([OrderSpectrum(np.arange(0.0, 70.0, 0.01), amplitude, 1.0)], orders, 0.02)
    evidence = Evidence([BandEvidence(WHOLE, search)], WHOLE, HIGH, frequency, 0.5)
    rule = {"outer_ring": OuterRing(P), "inner_ring": InnerRing(P), "roller": Roller(P), "cage": Cage(P)}[component]
    usual, faint = ({name: Finding(name, LEAST_EXCESS, "") for name in COMPONENTS} for _ in range(2))
    usual[component] = rule.finding(evidence) or usual[component]
    faint[component] = fainter(rule, Q.relief).finding(evidence) or faint[component]
    return Judgement(evidence, usual, faint, TurnEnvelopes(np.zeros((1, 64), np.float32), 64, -1.0))


def compared(lines: Lines, others: Lines, component: Component = "roller") -> Compared:
    """Return what becomes of the evidence of the box ``axle_1/left`` if the other boxes have other lines."""
    return compare({"axle_1/left": judged(lines, component)} | {name: judged(others, component) for name in OTHERS}, Q, {})["axle_1/left"][
        component
    ]


def sidebands(depth: float) -> Lines:
    return FTF | {h * 6.0 + side: depth for h in (1, 2, 3) for side in (-0.42, 0.42)}


def hump(depth: float) -> Lines:
    return {round(order, 2): depth for order in np.arange(5.88, 6.08, 0.01)}


@pytest.mark.parametrize("of", [sidebands, hump])
def test_lines_of_a_roller_around_whole_orders_are_its_own(of: Callable[[float], Lines]) -> None:
    """A roller that lost 1.6 % of its spin: its lines are at 6, 12 and 18 orders, where the search leaves out those of the wheel."""
    found = compared(of(0.3), {})
    assert (found.excess > 0.0, found.contrast > Q.contrast) == (True, True)
    assert compared(of(0.1), of(0.3)).excess < 0.0


def test_harmonics_of_a_roller_count_alone_if_they_are_the_largest() -> None:
    """A line of the other box beside the harmonics is of another fault."""
    own = FTF | {h * 6.1: 0.5 for h in (1, 2, 3)}
    beside = {h * 6.1 + side: 0.5 for h in (1, 2, 3) for side in (-0.42, 0.42)}
    assert compared(own, beside).excess > 0.0


@pytest.mark.parametrize(("depth", "relieved"), [(0.12, True), (0.05, True), (0.02, False)])
def test_faint_lines_that_no_other_box_has_are_relieved(depth: float, relieved: bool) -> None:
    found = compared({k * 6.72: depth for k in range(1, 7)}, {}, "outer_ring")
    assert (found.excess > 0.0) is relieved


def test_faint_lines_are_not_relieved_without_another_box() -> None:
    alone = {"axle_1/left": judged({k * 6.72: 0.05 for k in range(1, 7)}, "outer_ring")}
    assert compare(alone, Q, {})["axle_1/left"]["outer_ring"].excess < 0.0


def test_a_verdict_is_explained_with_the_lines_that_it_is_about() -> None:
    """By itself the box has another family, which is below its limit."""
    faint, other = (judged({k * order: 0.1 for k in range(1, 7)}, "outer_ring") for order in (6.72, 6.65))
    own = dataclasses.replace(faint, findings=other.findings)
    found = compare({"axle_1/left": own} | {name: judged({}, "outer_ring") for name in OTHERS}, Q, {})["axle_1/left"]["outer_ring"]
    assert found.excess > 0.0
    assert _reason("outer_ring", found).startswith("lines of the outer_ring at 6.720 orders")


def test_lines_that_another_criterion_refuses_are_not_relieved() -> None:
    """Deep lines with twice as deep ones at 2 BPFO: the rhythm of rollers that excite twice per pass."""
    found = compared({k * 6.72: 0.6 if k == 2 else 0.17 for k in range(1, 7)}, {}, "outer_ring")
    assert found.excess < 0.0


def test_a_faint_roller_must_be_modulated_by_the_cage() -> None:
    """The whole orders of the other wheelset may lie at 2 BSF, too."""
    lines = {h * 6.1: 0.05 for h in (1, 2, 3)}
    assert compared(FTF | lines, {}).excess > 0.0
    assert compared(lines, {}).excess < 0.0


@pytest.mark.parametrize(("depth", "named"), [(0.6, True), (0.1, False)])
def test_lines_of_a_cage_need_more_than_those_of_unequal_rollers(depth: float, named: bool) -> None:
    """Sixteen rollers whose energies scatter by 0.7 have a depth of 0.31; faint lines that no other box has are below it, too."""
    found = compared({k * 0.42: depth for k in range(1, 14)}, {}, "cage")
    assert (found.excess >= found.healthy) is named


def test_what_noise_leaves_in_another_box_is_no_rival() -> None:
    """Lines of 0.05 over a background with a limit of 0.021; the other box has 0.022 at the first harmonic, a tenth of that in power."""
    own, noise = {k * 6.72: 0.05 for k in range(1, 7)}, {6.72: 0.022}
    clear, alike = compared(own, noise, "outer_ring"), compared(own, own, "outer_ring")
    assert clear.contrast > 2.0 * Q.contrast
    assert alike.contrast == pytest.approx(0.0, abs=0.1)


def test_the_contrast_is_the_mean_of_that_of_the_lines_and_that_of_the_modulations() -> None:
    """Depths of 0.4 and 0.1 at equal power: 6.0 dB, and 6.7 dB of d / (2 - d)."""
    strong, weak = (judged({6.72: depth}, "outer_ring") for depth in (0.4, 0.1))
    order = np.array([6.72])
    assert contrast(order, strong, weak, 0.0) == pytest.approx(6.4, abs=0.2)
    assert contrast(order, weak, strong, 0.0) == pytest.approx(-contrast(order, strong, weak, 0.0), rel=1e-9)
    # A depth above 1, which no modulation has, is compared by the lines alone: 4.8 dB for 1.5 and 0.5.
    beating, half = (judged({6.72: depth}, "outer_ring") for depth in (1.5, 0.5))
    assert contrast(order, beating, half, 0.0) == pytest.approx(4.8, abs=0.1)


@pytest.mark.parametrize(("turn", "found", "bpfi"), [(1.031, 9.235, 9.28), (1.002, 9.06, 9.07)])
def test_a_flat_of_the_other_wheelset_may_be_largest_beside_its_lines(turn: float, found: float, bpfi: float) -> None:
    """Its lines at k ``turn`` orders of this wheelset reach 0.05 orders; three of them are the first of a family at BPFI.

    At 1.002 the others lie where the search leaves out the whole orders of this wheelset.
    """
    family, flat = {found + side: 0.3 for side in (-1.0, 0.0, 1.0)}, {k * turn: 0.3 for k in (7, 8, 10, 11)}
    orders = dataclasses.replace(ORDERS, bpfi=bpfi)
    for lines, own in ((family, True), (family | flat, False)):
        boxes = {"axle_1/left": judged(lines, "inner_ring", orders=orders), "axle_2/left": judged({}, "inner_ring", turn * 20.0, orders)}
        assert (compare(boxes, Q, {})["axle_1/left"]["inner_ring"].excess > 0.0) is own
