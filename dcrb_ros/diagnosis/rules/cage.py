"""Cage fault: lines at k FTF up to nearly BPFO, since a missing bar lets the same rollers leave their places in every turn of the cage.

Healthy rollers that differ make the same lines. If the energies of Z rollers per pass scatter by c around their mean, independently, each
line at k FTF that is no multiple of Z has the root mean square 2 c / sqrt(Z), and the mean sqrt(pi) c / sqrt(Z) (the amplitude has a
Rayleigh distribution). Lines of a fault must be deeper.

Something that the load zone weights once per turn of the cage, such as a damaged roller, makes the first five lines only. A missing bar,
which frees rollers for two pitches at most, makes lines up to half of the number of rollers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.cage_lines import CLUSTERED, PERIODIC, beyond_load_zone, cage_comb, clusters_at_spin, rollers, spin_of_clusters
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.line_search import Comb, LineFamily
from dcrb_ros.diagnosis.order_spectrum import decibels, ratio
from dcrb_ros.diagnosis.rule import Finding, LineParameters, LineRule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import quantity

LINES_EXPLAINED = 60
"""Harmonics of FTF that a cage fault may make: three harmonics of BPFI reach up to there with 16 rollers."""


class CageParameters(LineParameters):
    """Threshold of the lines at k FTF."""

    cage_depth: float = quantity(
        0.17, "-", "Modulation depth required of the lines at k FTF; impacts with a tenth of the power in the band make 0.17", 0.0, 2.0
    )
    cage_scatter: float = quantity(
        0.7,
        "-",
        "Relative scatter of the energy of rollers in a healthy bearing; lines at k FTF that it explains are no evidence for the cage",
        0.0,
        3.0,
    )


class Cage(LineRule[CageParameters]):
    """Harmonics of FTF; the strongest line of a broken bar is often the second."""

    component, name, parameters = "cage", "FTF with its harmonics", CageParameters

    def combs(self, orders: Orders) -> Sequence[Comb]:
        """Return the harmonics of FTF."""
        return (cage_comb(orders),)

    @property
    def depth(self) -> float:
        """Modulation depth that is required [-]."""
        return self.p.cage_depth

    def bands(self, evidence: Evidence) -> Sequence[BandEvidence]:
        """Return all bands that are loud enough: below the detector's band, the varying compliance carries the rhythm of the cage."""
        return evidence.loud

    def finding(self, evidence: Evidence) -> Finding | None:
        """Return the evidence of the band in which it is strongest; for a roller, if the lines end with those of the load zone."""
        finding = super().finding(evidence)
        if finding is None or finding.excess < 0.0:
            return finding
        families = [(band, band.family(cage_comb(evidence.orders))) for band in self.bands(evidence)]
        deep = [(band, lines) for band, lines in families if super(Cage, self).excess(lines, band, evidence) >= 0.0]
        if min((beyond_load_zone(band, lines) for band, lines in deep), default=0.0) >= 0.0:
            return finding
        unequal = self.healthy_evidence(evidence.orders)
        return finding._replace(component="roller", excess=finding.excess - (unequal if finding.excess < unequal else 0.0))

    def excess(self, lines: LineFamily, band: BandEvidence, evidence: Evidence) -> float:
        """Return the excess of depth and significance; none if the lines cluster at 2 BSF, where a roller defect puts them [dB]."""
        excess = super().excess(lines, band, evidence)
        if lines.order <= 0.0:
            return excess
        clusters, between = clusters_at_spin(band, lines)
        contrast = decibels(ratio(clusters, CLUSTERED * between)) if between > 0.0 else -math.inf
        if excess >= 0.0 >= contrast:
            contrast = decibels(max(spin_of_clusters(band, lines)[0], 0.0) / PERIODIC)
        return min(excess, -contrast) if contrast > 0.0 else excess

    def healthy_evidence(self, orders: Orders) -> float:
        """Return the evidence of rollers whose energies scatter as in a healthy bearing [dB]; 0 if a baseline has their lines."""
        if self.baseline is not None:
            return 0.0
        depth = math.sqrt(math.pi / rollers(orders)) * self.p.cage_scatter
        return max(0.0, decibels(ratio(depth, self.depth)))

    def companions(self, lines: LineFamily, orders: Orders) -> Floats:
        """Return the harmonics of FTF, with BPFO among them."""
        return lines.order * np.arange(1.0, LINES_EXPLAINED + 1.0)
