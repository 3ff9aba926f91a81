"""Roller defect: lines at twice BSF with sidebands at FTF, since the cage carries the roller through the load zone."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.order_spectrum import CAGE_SIDEBANDS, HARMONICS, LineFamily
from dcrb_ros.diagnosis.rule import LineRule, Overlap, modulation_excess
from dcrb_ros.diagnosis.rules.shadow import ShadowParameters
from dcrb_ros.schema.fields import quantity


class RollerParameters(ShadowParameters):
    """Thresholds of 2 BSF lines."""

    roller_depth: float = quantity(
        0.2, "-", "Modulation depth required of 2 BSF lines with cage sidebands; healthy bearings have up to 0.07", 0.0, 2.0
    )
    roller_level: float = quantity(
        7.0, "dB", "Level over background required of 2 BSF lines with cage sidebands; healthy bearings have up to 3", 0.0, 60.0
    )


class Roller(LineRule[RollerParameters]):
    """Twice BSF and harmonics with sidebands at FTF, by their modulation depth, which no gain of the sensor changes."""

    component, name, parameters = "roller", "2 BSF with sidebands at FTF", RollerParameters

    def lines(self, band: BandEvidence) -> LineFamily:
        """Return the family at twice BSF."""
        (order,) = band.fitted(2.0 * band.orders.bsf)
        return band.lines(order, np.add.outer(HARMONICS * order, band.cage_order * CAGE_SIDEBANDS))

    def excess(self, lines: LineFamily, band: Band, evidence: Evidence) -> float:
        """Return the smaller excess of depth and level [dB]."""
        return modulation_excess(lines, self.p.roller_depth, self.p.roller_level)

    def overlaps(self) -> Iterable[Overlap]:
        """Sidebands lie near BPFI and BPFO; a roller defect has the rhythm of the cage at any depth, since the cage carries the roller."""
        return Overlap("inner_ring", 3, self.p.shadow), Overlap("outer_ring", 4, self.p.shadow), Overlap("cage", 5, 0.0)
