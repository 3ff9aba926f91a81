"""Inner-ring defect: BPFI lines with sidebands at one and two orders, since the defect turns through the load zone."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.order_spectrum import HARMONICS, SHAFT_SIDEBANDS, LineFamily, deeper
from dcrb_ros.diagnosis.rule import LineRule, Overlap, modulation_excess
from dcrb_ros.diagnosis.rules.shadow import ShadowParameters
from dcrb_ros.schema.fields import quantity


class InnerRingParameters(ShadowParameters):
    """Thresholds of BPFI lines."""

    inner_depth: float = quantity(
        0.08, "-", "Modulation depth required of BPFI lines with sidebands; healthy bearings have up to 0.06", 0.0, 2.0
    )
    inner_level: float = quantity(
        7.0, "dB", "Level over background required of BPFI lines with sidebands; healthy bearings have up to 3", 0.0, 60.0
    )


class InnerRing(LineRule[InnerRingParameters]):
    """BPFI or twice BPFI and harmonics with sidebands at the shaft, by their modulation depth, which no gain of the sensor changes."""

    component, name, parameters = "inner_ring", "BPFI with sidebands at the shaft", InnerRingParameters

    def lines(self, band: BandEvidence) -> LineFamily:
        """Return the deeper of the families at BPFI and at twice BPFI."""
        fitted = band.fitted(band.orders.bpfi, 2.0 * band.orders.bpfi)
        odd, even = (band.lines(order, np.add.outer(HARMONICS * order, SHAFT_SIDEBANDS)) for order in fitted)
        return deeper(odd, even)

    def excess(self, lines: LineFamily, band: Band, evidence: Evidence) -> float:
        """Return the smaller excess of depth and level [dB]."""
        return modulation_excess(lines, self.p.inner_depth, self.p.inner_level)

    def overlaps(self) -> Iterable[Overlap]:
        """Sidebands of BPFI lie near lines of all other components."""
        return Overlap("roller", 2, self.p.shadow), Overlap("cage", 4, self.p.shadow), Overlap("outer_ring", 4, self.p.shadow)
