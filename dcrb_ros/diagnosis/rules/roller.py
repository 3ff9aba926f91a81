"""Roller defect: lines at twice BSF with sidebands at FTF, since the cage carries the roller through the load zone.

A roller that slips outside the load zone strikes anew in every turn of the cage: then the lines are harmonics of FTF, which are large near
the multiples of 2 BSF and small halfway between them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.diagnosis.cage_lines import CLUSTERED, PERIODIC, cage_comb, clusters_at_spin, spin_of_clusters
from dcrb_ros.diagnosis.evidence import BandEvidence
from dcrb_ros.diagnosis.line_parameters import LineParameters
from dcrb_ros.diagnosis.line_search import Comb, LineFamily
from dcrb_ros.diagnosis.rule import LineRule, sidebands
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import quantity


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
        """Return the deeper of the family at 2 BSF and, if they cluster there, the harmonics of FTF."""
        found, cage = super().family(band, comb), band.family(cage_comb(band.orders))
        if cage.order <= 0.0:
            return found
        clusters, between = clusters_at_spin(band, cage)
        spin = comb.order
        if clusters < CLUSTERED * between and cage.depth <= found.depth:
            return found
        if clusters < CLUSTERED * between:
            # The rollers may spin more slowly than they should.
            periodicity, spin = spin_of_clusters(band, cage)
            clusters = cage.depth if periodicity > PERIODIC else 0.0
        if clusters <= found.depth:
            return found
        order = cage.order * round(spin / cage.order)
        return cage._replace(order=order, amplitude=clusters * band.spectrum.mean, depth=clusters, lines=(order,))

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
