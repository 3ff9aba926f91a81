"""Cage fault: lines at k FTF up to nearly BPFO, since a missing bar lets the same rollers leave their places in every turn of the cage."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.order_spectrum import LineFamily
from dcrb_ros.diagnosis.rule import LineRule, Overlap, modulation_excess
from dcrb_ros.schema.fields import Group, quantity

CAGE_HARMONICS = np.arange(1.0, 14.0)
"""Harmonics of FTF: the 16th of the default bearing is BPFO, and its neighbours lie in the skirt of that line."""


class CageParameters(Group):
    """Thresholds of the lines at k FTF."""

    cage_depth: float = quantity(0.08, "-", "Modulation depth required of the lines at k FTF; healthy bearings have up to 0.06", 0.0, 2.0)
    cage_level: float = quantity(
        6.0, "dB", "Level over background required of the lines at k FTF; healthy bearings have up to 3", 0.0, 60.0
    )
    comb_shadow: float = quantity(
        0.7, "-", "Ratio of modulation depths from which lines at k FTF explain lines of another component in the same band", 0.1, 100.0
    )


class Cage(LineRule[CageParameters]):
    """Harmonics of FTF by their modulation depth, which no gain of the sensor changes."""

    component, name, parameters = "cage", "FTF with its harmonics", CageParameters

    def bands(self, evidence: Evidence) -> Sequence[BandEvidence]:
        """Return all bands: below the detector's band, the varying compliance carries the rhythm of the cage."""
        return evidence.bands

    def lines(self, band: BandEvidence) -> LineFamily:
        """Return the harmonics of FTF."""
        return band.lines(band.cage_order, CAGE_HARMONICS * band.cage_order)

    def excess(self, lines: LineFamily, band: Band, evidence: Evidence) -> float:
        """Return the smaller excess of depth and level [dB]."""
        return modulation_excess(lines, self.p.cage_depth, self.p.cage_level)

    def overlaps(self) -> Iterable[Overlap]:
        """A harmonic of FTF lies near every line of the other components."""
        ratio = self.p.comb_shadow
        return Overlap("outer_ring", 1, ratio), Overlap("inner_ring", 1, ratio), Overlap("roller", 1, ratio)
