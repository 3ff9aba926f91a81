"""Inner-ring defect: BPFI lines with sidebands at one order, since the defect turns through the load zone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.cage_lines import over_the_cage, rollers
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.line_search import Comb, LineFamily
from dcrb_ros.diagnosis.rule import LineParameters, LineRule, sidebands
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import quantity


class InnerRingParameters(LineParameters):
    """Threshold of BPFI lines."""

    inner_depth: float = quantity(
        0.17,
        "-",
        "Modulation depth required of BPFI lines with sidebands; impacts with a tenth of the power in the band make 0.17",
        0.0,
        2.0,
    )


class InnerRing(LineRule[InnerRingParameters]):
    """BPFI and harmonics with sidebands at the shaft."""

    component, name, parameters = "inner_ring", "BPFI with sidebands at the shaft", InnerRingParameters

    def combs(self, orders: Orders) -> Sequence[Comb]:
        """Return BPFI with its sidebands."""
        return (Comb(orders.bpfi, sidebands=(-1.0, 0.0, 1.0)),)

    @property
    def depth(self) -> float:
        """Modulation depth that is required [-]."""
        return self.p.inner_depth

    def excess(self, lines: LineFamily, band: BandEvidence, evidence: Evidence) -> float:
        """Return the excess of depth and significance; none if the lines of the cage are larger [dB]."""
        return over_the_cage(super().excess(lines, band, evidence), lines, band, self.p.ring_contrast)

    def companions(self, lines: LineFamily, orders: Orders) -> Floats:
        """Return the harmonics of BPFI with sidebands at the shaft, which turns the defect, and at the cage with its unequal rollers."""
        cage = 1.0 - lines.order / rollers(orders)
        turning = np.arange(-4.0, 5.0)
        return sidebands(lines.order, np.concatenate([turning, np.add.outer(turning[2:-2], (-cage, cage)).ravel()]))
