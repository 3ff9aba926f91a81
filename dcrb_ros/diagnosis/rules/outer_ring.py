"""Outer-ring defect: BPFO lines that are larger than those of a healthy bearing.

A healthy roller bearing has sharp BPFO lines, too: its compliance varies as rollers pass the load line, and unloaded rollers strike as they
enter the load zone. So the size of BPFO lines counts, in the whole band or in its upper quarter. Rows staggered by half a pitch strike in
turn and leave only the even harmonics.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.order_spectrum import HARMONICS, LineFamily, decibels, deeper, ratio
from dcrb_ros.diagnosis.rule import Finding, LineRule
from dcrb_ros.schema.fields import Group, quantity


class OuterRingParameters(Group):
    """Limits of BPFO lines, and how they are learned."""

    outer_limit: float = quantity(
        38.0,
        "m/s^2",
        "BPFO lines in the whole band, scaled to 20 Hz, from which they indicate a defect; healthy bearings have up to 26",
        0.0,
        1e6,
    )
    outer_limit_high: float = quantity(
        12.0,
        "m/s^2",
        "The same for the upper quarter of the band; healthy bearings have up to 5, with a resonant mount up to 10",
        0.0,
        1e6,
    )
    outer_depth: float = quantity(
        0.3, "-", "Modulation depth required of BPFO lines, relative to the mean squared envelope; noise has 0.05", 0.0, 2.0
    )
    learn: float = quantity(
        0.0,
        "s",
        "Time from the first verdict during which the bearing is assumed healthy and the limits of the outer ring are learned; 0 for none",
        0.0,
        1e5,
    )
    learn_margin: float = quantity(4.0, "dB", "Margin of learned limits over the largest BPFO lines", 0.0, 40.0)


class OuterRing(LineRule[OuterRingParameters]):
    """BPFO and its harmonics, or those of twice BPFO, by their size at the reference speed."""

    component, name, parameters = "outer_ring", "BPFO", OuterRingParameters

    def __init__(self, parameters: OuterRingParameters) -> None:
        super().__init__(parameters)
        self._whole_limit, self._high_limit = parameters.outer_limit, parameters.outer_limit_high
        self._remaining = parameters.learn
        """Time for which the limits are still learned [s]."""

    def bands(self, evidence: Evidence) -> Sequence[BandEvidence]:
        """Return the whole band and its upper quarter."""
        return [band for band in evidence.bands if band.band in (evidence.whole, evidence.high)]

    def lines(self, band: BandEvidence) -> LineFamily:
        """Return the deeper of the families at BPFO and at twice BPFO."""
        odd, even = (band.lines(order, HARMONICS * order) for order in band.outer_ring_orders)
        return deeper(odd, even)

    def excess(self, lines: LineFamily, band: Band, evidence: Evidence) -> float:
        """Return the size over the limit of the band, if the lines are also deep enough [dB]."""
        size = decibels(ratio(lines.amplitude, self._limit(band, evidence) ** 2))
        return min(size, 2.0 * decibels(ratio(lines.depth, self.p.outer_depth)))

    def _limit(self, band: Band, evidence: Evidence) -> float:
        return self._whole_limit if band == evidence.whole else self._high_limit

    def reason(self, lines: LineFamily, band: Band, evidence: Evidence) -> str:
        """Return size and limit in words."""
        limit = self._limit(band, evidence)
        if limit == 0.0:
            return super().reason(lines, band, evidence)
        size = f"has {lines.amplitude**0.5:.3g} m/s^2 (limit {limit:g} m/s^2, both at a shaft frequency of 20 Hz)"
        return f"{self._place(lines)} {size}, {self._level(lines, band)}"

    def settled(self, finding: Finding, evidence: Evidence) -> Finding:
        """Return the finding; while the limits are learned, raise them above the present lines and suspect nothing."""
        if self._remaining <= 0.0:
            return finding
        self._remaining -= evidence.interval
        margin = 10.0 ** (self.p.learn_margin / 20.0)
        for band in self.bands(evidence):
            size = margin * math.sqrt(band.family(self.lines).amplitude)
            if band.band == evidence.whole:
                self._whole_limit = max(self._whole_limit, size)
            if band.band == evidence.high:
                self._high_limit = max(self._high_limit, size)
        return finding._replace(excess=min(-1.0, finding.excess))

    @property
    def remark(self) -> str:
        """How long the limits are still learned."""
        return f"learning for another {self._remaining:.1f} s: outer-ring defects are not reported yet" if self._remaining > 0.0 else ""
