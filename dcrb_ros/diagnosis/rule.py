"""Base of the rules of the detector: each looks for one fault of the bearing, or one of the sensor."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import ClassVar, Generic, NamedTuple, TypeVar

from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence, LevelEvidence, SampleEvidence
from dcrb_ros.diagnosis.order_spectrum import NO_LINES, LineFamily, decibels, ratio
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.verdicts import Component

Parameters = TypeVar("Parameters", bound=Group)

LEAST_EXCESS = -60.0
"""Smallest excess of a finding [dB]."""


class Finding(NamedTuple):
    """The evidence for a fault of one component."""

    component: Component
    excess: float
    """Evidence relative to the threshold of the rule [dB]: a fault is suspected from 0 on."""
    reason: str
    """The evidence in words, a part of the diagnosis."""
    lines: LineFamily = NO_LINES
    """Lines of the fault in the squared envelope spectrum, if the rule looks at lines."""
    band: Band | None = None
    """Band of that spectrum."""


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

    def settled(self, finding: Finding, evidence: Evidence) -> Finding:
        """Return the finding of the component after all rules have been combined; a rule may lower it."""
        return finding

    @property
    def remark(self) -> str:
        """A remark for the diagnosis, or nothing."""
        return ""


class Overlap(NamedTuple):
    """A component whose lines another family of lines can imitate."""

    component: Component
    """Component that seems to be damaged."""
    rank: int
    """Overlaps are resolved in the order of their ranks, since a finding that has been explained explains no other."""
    ratio: float
    """Modulation depth of the imitating lines relative to the imitated ones from which they explain them [-]."""


class LineRule(BearingRule[Parameters]):
    """Looks for a family of lines in the squared envelope spectra."""

    name: ClassVar[str]
    """Name of the lines in a reason."""

    @abstractmethod
    def lines(self, band: BandEvidence) -> LineFamily:
        """Return the family of lines in the spectrum of one band."""

    @abstractmethod
    def excess(self, lines: LineFamily, band: Band, evidence: Evidence) -> float:
        """Return the evidence of lines in one band relative to the thresholds [dB]."""

    def bands(self, evidence: Evidence) -> Sequence[BandEvidence]:
        """Return the bands to look at: by default those within the detector's band."""
        return [band for band in evidence.bands if band.band.low >= evidence.whole.low]

    def overlaps(self) -> Iterable[Overlap]:
        """Return the components whose lines this family can imitate."""
        return ()

    def finding(self, evidence: Evidence) -> Finding | None:
        """Return the evidence of the band in which it is strongest."""
        found = [(band, band.family(self.lines)) for band in self.bands(evidence)]
        rated = [(max(LEAST_EXCESS, self.excess(lines, band.band, evidence)), lines, band.band) for band, lines in found]
        if not rated:
            return None
        excess, lines, band = max(rated, key=lambda one: one[0])
        return Finding(self.component, excess, self.reason(lines, band, evidence), lines, band)

    def reason(self, lines: LineFamily, band: Band, evidence: Evidence) -> str:
        """Return the evidence in words."""
        return f"{self._place(lines)} modulates the squared envelope by {lines.depth:.2f} of its mean, {self._level(lines, band)}"

    def _place(self, lines: LineFamily) -> str:
        return f"{self.name} at {lines.order:.3f} orders"

    def _level(self, lines: LineFamily, band: Band) -> str:
        return f"{lines.level:.1f} dB over background from {band}"


def modulation_excess(lines: LineFamily, least_depth: float, least_level: float) -> float:
    """Return the smaller excess of modulation depth [-] and level over background [dB] over their thresholds [dB]."""
    return min(decibels(ratio(lines.depth, least_depth)), lines.level - least_level)


class SampleRule(Rule[Parameters]):
    """Looks for a fault of the sensor in the samples of every hop."""

    at_standstill: ClassVar[bool] = False
    """Whether the rule also applies while the shaft does not turn."""
    fewest_samples: ClassVar[int] = 64
    """Samples below which the rule does not apply."""

    @abstractmethod
    def flaw(self, evidence: SampleEvidence) -> str:
        """Return what is wrong with the sensor, or nothing."""


class LevelRule(Rule[Parameters]):
    """Looks for a fault of the sensor in the power of several bands; evaluated while the shaft turns."""

    @abstractmethod
    def flaw(self, evidence: LevelEvidence) -> str:
        """Return what is wrong with the sensor, or nothing."""
