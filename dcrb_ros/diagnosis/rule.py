"""Base of the rules of the detector: each looks for one fault of the bearing, or one of the sensor."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence, LevelEvidence, SampleEvidence
from dcrb_ros.diagnosis.healthy_baseline import LEAST_DEPTH, HealthyBaseline
from dcrb_ros.diagnosis.hysteresis import probability
from dcrb_ros.diagnosis.line_search import NO_LINES, Comb, LineFamily
from dcrb_ros.diagnosis.order_spectrum import decibels, ratio
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity
from dcrb_ros.schema.verdicts import Component
from dcrb_ros.stream.diagnosis import FoundLines

LEAST_EXCESS = -60.0
"""Smallest excess of a finding [dB]."""
HARMONICS_EXPLAINED = 6
"""Harmonics of a fault whose sidebands may be images of another family: three harmonics of BPFI reach up to the sixth of BPFO."""


class LineParameters(Group):
    """When lines are significant, and when they are the image of others."""

    false_alarm: float = quantity(
        1e-4,
        "-",
        "Probability per window and fault with which noise may have lines as strong as those that indicate the fault",
        1e-12,
        0.1,
    )
    shadow: float = quantity(
        0.5,
        "-",
        "Modulation depth relative to that of another fault below which lines are taken for an image of it, as the sidebands of one fault "
        "can lie on the lines of another",
        0.0,
        1.0,
    )
    ring_contrast: float = quantity(
        1.5,
        "dB",
        "Largest amplitude of the lines of a ring required over that of FTF and its double, where faults of cage and rollers have "
        "their largest lines",
        0.0,
        20.0,
    )
    learn_margin: float = quantity(4.0, "dB", "Margin of learned limits over the largest lines of the healthy bearing", 0.0, 40.0)


Parameters = TypeVar("Parameters", bound=Group)
Lines = TypeVar("Lines", bound=LineParameters)


class Finding(NamedTuple):
    """The evidence for a fault of one component."""

    component: Component
    excess: float
    """Evidence relative to the threshold of the rule [dB]: a fault is suspected from 0 on."""
    reason: str
    """The evidence in words, a part of the diagnosis."""
    lines: LineFamily = NO_LINES
    """Lines of the fault in the squared envelope spectrum, if the rule looks at lines."""
    band: BandEvidence | None = None
    """Band of that spectrum."""
    comb: Comb | None = None
    """Family that was searched."""
    rule: LineRule[Any] | None = None
    """Rule that found it, if it looks at lines."""


def found_lines(finding: Finding) -> FoundLines | None:
    """Return the lines of a finding for a diagnosis, or none if the rule does not look at lines."""
    lines, band, comb = finding.lines, finding.band, finding.comb
    if band is None or comb is None or lines.order <= 0.0:
        return None
    departure = lines.order / comb.order - 1.0
    size, chance = math.sqrt(lines.amplitude), probability(finding.excess)
    return FoundLines(chance, lines.order, departure, lines.lines, lines.depth, size, lines.significance, (band.band.low, band.band.high))


class Rule(ABC, Generic[Parameters]):
    """A rule of the detector with its own parameters."""

    parameters: ClassVar[type[Group]] = Group
    """Fields that the rule adds to the parameters of the detector."""

    def __init__(self, parameters: Parameters) -> None:
        self.p = parameters


class BearingRule(Rule[Parameters]):
    """Looks for a fault of one component of the bearing once per hop."""

    component: ClassVar[Component]

    @abstractmethod
    def finding(self, evidence: Evidence) -> Finding | None:
        """Return the evidence for the fault, or none."""

    def healthy_evidence(self, orders: Orders) -> float:
        """Return the evidence that a healthy bearing of these orders may have [dB]: a verdict needs more of it."""
        return 0.0

    def settled(self, finding: Finding, evidence: Evidence) -> Finding:
        """Return the finding of the component after all rules have been combined; a rule may lower it."""
        return finding

    @property
    def remark(self) -> str:
        """A remark for the diagnosis, or nothing."""
        return ""

    def take_bearing(self, bearing: object) -> None:
        """Take the geometry of the bearing; a rule may have limits for it."""

    def take_baseline(self, baseline: HealthyBaseline) -> None:
        """Take the lines of the healthy bearing; a rule may compare with them.

        Raises:
            Refusal: the parameters of the rule give a baseline, too.
        """


class LineRule(BearingRule[Lines]):
    """Looks for a family of lines in the squared envelope spectra."""

    name: ClassVar[str]
    """Name of the lines in a reason."""
    baseline: HealthyBaseline | None = None
    """Lines of the healthy bearing, if they are known."""

    @abstractmethod
    def combs(self, orders: Orders) -> Sequence[Comb]:
        """Return the families to search for a bearing of these orders; the strongest counts."""

    def families(self, orders: Orders) -> int:
        """Return the number of families in a band among which the strongest counts."""
        return len(self.combs(orders))

    @property
    @abstractmethod
    def depth(self) -> float:
        """Modulation depth that is required [-]."""

    def take_baseline(self, baseline: HealthyBaseline) -> None:
        """Compare lines with those of the healthy bearing."""
        self.baseline = baseline

    def baseline_combs(self, orders: Orders) -> Sequence[Comb]:
        """Return the families that a baseline must know: those to search with a baseline."""
        return self.combs(orders)

    def companions(self, lines: LineFamily, orders: Orders) -> Floats:
        """Return the lines that this fault also makes [orders]; families that consist of them alone are its images.

        By default they are the harmonics with sidebands at one and two orders of the shaft.
        """
        return sidebands(lines.order, np.arange(-2.0, 3.0))

    def excess(self, lines: LineFamily, band: BandEvidence, evidence: Evidence) -> float:
        """Return the evidence of lines in one band relative to the thresholds [dB]: the smaller excess of depth and significance."""
        price = math.log10(max(1, len(self.bands(evidence)) * self.families(evidence.orders)))
        healthy = self.baseline.of(self.component, band.band) if self.baseline is not None else None
        if healthy is None:
            return modulation_excess(lines, self.depth, self.p.false_alarm, price)
        margin = 10.0 ** (self.p.learn_margin / 20.0)
        depth = min(self.depth, max(LEAST_DEPTH, margin * healthy.depth))
        excess = modulation_excess(lines, depth, self.p.false_alarm, price)
        # In a band without healthy lines, any line is larger.
        return min(excess, decibels(ratio(lines.amplitude, (margin * healthy.size) ** 2))) if healthy.size > 0.0 else excess

    def family(self, band: BandEvidence, comb: Comb) -> LineFamily:
        """Return the lines of a comb in one band."""
        return band.family(comb)

    def bands(self, evidence: Evidence) -> Sequence[BandEvidence]:
        """Return the bands to look at: by default those within the detector's band that are loud enough."""
        return evidence.within

    def finding(self, evidence: Evidence) -> Finding | None:
        """Return the evidence of the band in which it is strongest."""
        return self.strongest(evidence, self.combs(evidence.orders))

    def strongest(self, evidence: Evidence, combs: Sequence[Comb]) -> Finding | None:
        """Return the evidence of the band and family in which it is strongest."""
        families = [(band, comb, self.family(band, comb)) for band in self.bands(evidence) for comb in combs]
        rated = [(max(LEAST_EXCESS, self.excess(lines, band, evidence)), lines, band, comb) for band, comb, lines in families]
        if not rated:
            return None
        excess, lines, band, comb = max(rated, key=lambda rating: (rating[0], rating[1].depth))
        return Finding(self.component, excess, self.reason(lines, band, evidence), lines, band, comb, self)

    def reason(self, lines: LineFamily, band: BandEvidence, evidence: Evidence) -> str:
        """Return the evidence in words."""
        return f"{self._place(lines)} modulates the squared envelope by {lines.depth:.2f} of its mean, {self._level(lines, band)}"

    def _place(self, lines: LineFamily) -> str:
        return f"{self.name} at {lines.order:.3f} orders"

    def _level(self, lines: LineFamily, band: BandEvidence) -> str:
        return f"{lines.level:.1f} dB over background from {band.band}"


def sidebands(order: float, distances: npt.ArrayLike) -> Floats:
    """Return the harmonics of an order, and 0, with sidebands at ``distances`` [orders], shape (lines,)."""
    lines = np.add.outer(np.arange(HARMONICS_EXPLAINED + 1) * order, np.asarray(distances, np.float64).ravel())
    return np.asarray(np.abs(lines).ravel(), np.float64)


def modulation_excess(lines: LineFamily, least_depth: float, false_alarm: float, price: float) -> float:
    """Return the excess of modulation depth [-] over its threshold, or the deficit of significance if that is smaller [dB].

    Significance is required, but does not add to the evidence: it grows with the length of the signal. The probability of a false alarm is
    multiplied by 10 to the ``price``, the number of families and bands among which the best was chosen.
    """
    significance = max(lines.significance - price, 0.0) / -math.log10(false_alarm)
    depth = decibels(ratio(lines.depth, least_depth))
    return depth if significance >= 1.0 else min(depth, decibels(significance))


class SampleRule(Rule[Parameters]):
    """Looks for a fault of the sensor in the samples of every hop."""

    at_standstill: ClassVar[bool] = False
    """Whether the rule also applies while the shaft does not turn."""
    fewest_samples: ClassVar[int] = 64
    """Samples below which the rule does not apply."""
    fault: ClassVar[str] = ""
    """Fault for which a hop that the parameters allow may be too short; empty for none."""
    clipped: int = 0
    """Clipped samples that the rule has counted so far."""

    def shortest_hop(self, rate: int) -> float:
        """Return the length of a hop from which the rule applies [s]."""
        return self.fewest_samples / rate

    def restart(self) -> None:
        """Discard earlier hops."""

    @abstractmethod
    def flaw(self, evidence: SampleEvidence) -> str:
        """Return what is wrong with the sensor, or nothing."""


class LevelRule(Rule[Parameters]):
    """Looks for a fault of the sensor in the power of several bands; evaluated while the shaft turns."""

    @abstractmethod
    def flaw(self, evidence: LevelEvidence) -> str:
        """Return what is wrong with the sensor, or nothing."""
