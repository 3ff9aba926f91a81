"""Roller defect: lines at twice BSF with sidebands at FTF, since the cage carries the roller through the load zone.

A roller that slips outside the load zone strikes anew in every turn of the cage: then the lines are harmonics of FTF, which are large near
the multiples of 2 BSF and small halfway between them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.cage_lines import CLUSTERED, PERIODIC, cage_comb, clusters_at_spin, spin_of_clusters
from dcrb_ros.diagnosis.evidence import BandEvidence
from dcrb_ros.diagnosis.line_search import GUARD, Comb, LineFamily
from dcrb_ros.diagnosis.rule import LineParameters, LineRule, sidebands
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import quantity

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
        """Return twice BSF with its sidebands."""
        return (Comb(2.0 * orders.bsf, sidebands=(-orders.ftf, 0.0, orders.ftf)),)

    def family(self, band: BandEvidence, comb: Comb) -> LineFamily:
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
        """Return the number of families among which the strongest counts: 2 BSF and that of slower rollers."""
        return 2 * len(self.combs(orders))

    @property
    def depth(self) -> float:
        """Modulation depth that is required [-]."""
        return self.p.roller_depth

    def companions(self, lines: LineFamily, orders: Orders) -> Floats:
        """Return the harmonics of 2 BSF with sidebands at the cage, which carries the roller, and those of the cage itself.

        Lines that cluster at 2 BSF are harmonics of the cage as it was found, which may slip.
        """
        clustered = lines.width == 1
        cage = lines.order / max(1, round(lines.order / orders.ftf)) if clustered else orders.ftf
        return sidebands(lines.order, np.add.outer(np.arange(-2.0, 3.0), cage * np.arange(-13.0, 14.0)))
