"""Roller defect: lines at twice BSF with sidebands at FTF, since the cage carries the roller through the load zone.

A roller that slips outside the load zone strikes anew in every turn of the cage: then the lines are harmonics of FTF, which are large near
the multiples of 2 BSF and small halfway between them. If its spin wanders, as that of a ball does, the lines become a hump at 2 BSF.

Sharp lines must be modulated by the cage. Strikes with the strengths g(t) of the load zone, which has the lines g_k at k FTF, make lines of
2 g_0 at 2 BSF, and of 2 g_1 both at its sidebands and at FTF. Lines at 2 BSF without a line at FTF belong to something else.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.cage_lines import CLUSTERED, MOST_HARMONICS, PERIODIC, cage_comb, clusters_at_spin, spin_of_clusters
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.line_search import GUARD, Comb, LineFamily
from dcrb_ros.diagnosis.order_spectrum import decibels, ratio
from dcrb_ros.diagnosis.rule import LEAST_EXCESS, Finding, LineParameters, LineRule, sidebands
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import quantity

LEAST_MODULATION = 0.36
"""Amplitude of FTF or its double over that of the largest line at 2 BSF from which the cage modulates it [-]: g_1 over g_0 of a ball that
keeps half of its largest load outside the load zone, 0.5 + 0.5 max(cos, 0)^1.5; 0.88 without a preload."""
CAGE_SLIP, CAGES = 0.02, 21
"""Slip of the cage up to which a hump explains its lines, and orders within that range [-]."""
HUMP = (1,)
"""Harmonics of the family that stands for the hump."""
NOT_RESOLVED = 60.0
"""Modulation by the cage where it cannot be seen [dB]."""
SLOWER, SPIN_LOST = 0.94, 0.04
"""Spins of a roller relative to the kinematic one at which 2 BSF is searched as well, and the range beside it [-]: 0.9 to 0.98."""


class RollerParameters(LineParameters):
    """Threshold of 2 BSF lines."""

    roller_depth: float = quantity(
        0.17,
        "-",
        "Modulation depth required of 2 BSF lines with cage sidebands; impacts with a tenth of the power in the band make 0.17",
        0.0,
        2.0,
    )


class Roller(LineRule[RollerParameters]):
    """Twice BSF and harmonics with sidebands at FTF."""

    component, name, parameters = "roller", "2 BSF with sidebands at FTF", RollerParameters

    def combs(self, orders: Orders) -> Sequence[Comb]:
        """Return twice BSF with its sidebands, and the hump there."""
        return Comb(2.0 * orders.bsf, sidebands=(-orders.ftf, 0.0, orders.ftf)), Comb(2.0 * orders.bsf, harmonics=HUMP)

    def finding(self, evidence: Evidence) -> Finding | None:
        """Return the evidence of sharp lines that the cage modulates, or of a hump, whichever is stronger."""
        found = [self.strongest(evidence, (comb,)) for comb in self.combs(evidence.orders)]
        modulated = [_modulated(finding) for finding in found if finding is not None]
        return max(modulated, key=lambda finding: finding.excess, default=None)

    def family(self, band: BandEvidence, comb: Comb) -> LineFamily:
        """Return the hump at 2 BSF, or the deepest of the sharp lines there."""
        return band.hump(comb.order) if comb.harmonics == HUMP else self._sharp(band, comb)

    def _sharp(self, band: BandEvidence, comb: Comb) -> LineFamily:
        """Return the deepest of the family at 2 BSF, at a slower spin, and, if they cluster there, the harmonics of FTF."""
        family, cage = super().family(band, comb), band.family(cage_comb(band.orders))
        if cage.order <= 0.0:
            return family
        clusters, between = clusters_at_spin(band, cage)
        spin = comb.order
        if clusters <= CLUSTERED * between:
            family = self._slower(family, band, comb, cage)
            if cage.depth <= family.depth:
                return family
            # Lines of a roller that spins more slowly may lie on harmonics of FTF.
            periodicity, spin = spin_of_clusters(band, cage)
            clusters = cage.depth if periodicity > PERIODIC else 0.0
        if clusters <= family.depth:
            return family
        order = cage.order * round(spin / cage.order)
        return cage._replace(order=order, amplitude=clusters * band.spectrum.mean, depth=clusters, lines=(order,))

    def _slower(self, family: LineFamily, band: BandEvidence, comb: Comb, cage: LineFamily) -> LineFamily:
        """Return the deeper of the ``found`` family and that of a roller that spins more slowly than it should.

        Such a roller slips outside the load zone, which it reaches once per turn of the cage: FTF or its double is deeper than what was
        found. Lines on harmonics of FTF would be those of the cage.
        """
        if math.sqrt(float(band.at(cage.order * np.array([1.0, 2.0])).max())) <= family.depth:
            return family
        slower = band.family(comb._replace(order=SLOWER * comb.order), SPIN_LOST / SLOWER)
        beside = abs(math.remainder(slower.order, cage.order)) > GUARD * band.step
        return slower if beside and slower.depth > family.depth else family

    def families(self, orders: Orders) -> int:
        """Return the number of families among which the strongest counts: 2 BSF, that of slower rollers, and the hump."""
        return 3

    @property
    def depth(self) -> float:
        """Modulation depth that is required [-]."""
        return self.p.roller_depth

    def companions(self, lines: LineFamily, orders: Orders) -> Floats:
        """Return the harmonics of 2 BSF with sidebands at the cage, which carries the roller, and those of the cage itself.

        Lines that cluster at 2 BSF are harmonics of the cage as it was found, which may slip. Beside a hump, the cage was not found.
        """
        if not lines.lines:
            cages = orders.ftf * np.linspace(1.0 - CAGE_SLIP, 1.0 + CAGE_SLIP, CAGES)
            return np.outer(cages, np.arange(1.0, MOST_HARMONICS + 1.0)).ravel()
        clustered = lines.width == 1
        cage = lines.order / max(1, round(lines.order / orders.ftf)) if clustered else orders.ftf
        return sidebands(lines.order, np.add.outer(np.arange(-2.0, 3.0), cage * np.arange(-13.0, 14.0)))


def _modulated(finding: Finding) -> Finding:
    """Return a finding; without evidence if its sharp lines are at 2 BSF and the cage does not modulate them."""
    if finding.band is None or finding.lines.width == 1 or finding.excess < 0.0:
        return finding
    contrast = _cage_modulation(finding.lines, finding.band) - decibels(LEAST_MODULATION)
    return finding if contrast >= 0.0 else finding._replace(excess=max(LEAST_EXCESS, contrast))


def _cage_modulation(lines: LineFamily, band: BandEvidence) -> float:
    """Return the amplitude of FTF or its double over that of the largest line at 2 BSF and its sidebands [dB].

    In a short window, whose resolution does not separate FTF from the mean, it is `NOT_RESOLVED`.
    """
    orders = band.orders
    if orders.ftf < 2.0 * GUARD * band.step:
        return NOT_RESOLVED
    cages = [band.family(cage_comb(orders)).order, orders.ftf]
    cage = float(band.at(np.outer([1.0, 2.0], cages)).max())
    largest = float(band.at(lines.order + orders.ftf * np.array([-1.0, 0.0, 1.0])).max())
    return decibels(math.sqrt(ratio(cage, largest))) if largest > 0.0 else NOT_RESOLVED
