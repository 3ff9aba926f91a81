"""What the lines of the envelope spectra say for each fault, and which family of lines only mirrors another.

A healthy roller bearing has sharp BPFO lines of its own: its compliance varies as rollers pass the load line, and idle rollers strike
as they enter it. So BPFO lines count by their size, all others by their depth of modulation, which no gain of the sensor changes:

* outer ring: BPFO harmonics larger than the healthy bearing's at this speed, in the whole band or in its upper quarter. Rows staggered
  by half a pitch strike in turn and leave the even harmonics only;
* inner ring: BPFI harmonics with sidebands at one and two orders, since the defect turns through the loading zone;
* roller: harmonics of 2 BSF with sidebands at FTF, since the cage carries the roller through the loading zone;
* cage: a comb at k FTF up to nearly BPFO, since a bar that is missing lets the same rollers out of their places in every turn of the cage.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.diagnosis.bands import Band
from dcrb_ros.diagnosis.envelope import NO_COMB, Comb, OrderSpectrum, combs, decibels, fitted_orders, ratio
from dcrb_ros.diagnosis.parameters import DetectorParameters

Kind = Literal["outer_ring", "inner_ring", "roller", "cage"]
KINDS: tuple[Kind, ...] = ("outer_ring", "inner_ring", "roller", "cage")
LINES: dict[Kind, str] = {
    "outer_ring": "BPFO",
    "inner_ring": "BPFI with sidebands at the shaft",
    "roller": "2 BSF with sidebands at FTF",
    "cage": "the comb at FTF",
}
HARMONICS = np.array([1.0, 2.0, 3.0])
SHAFT_SIDEBANDS = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
CAGE_SIDEBANDS = np.array([-1.0, 0.0, 1.0])
CAGE_TEETH = np.arange(1.0, 14.0)
"""Teeth of the cage's comb; the 16th of the default bearing is BPFO, and its neighbours drown in that line's skirt."""
LEAST_EXCESS = -60.0
"""Excess where there is no line at all [dB]."""


class Finding(NamedTuple):
    """What one band says for one fault."""

    comb: Comb
    band: Band
    excess: float
    """How far the lines are beyond what names the fault; negative: short of it [dB]."""
    limit: float = 0.0
    """Amplitude from which it would be named, of the outer ring [m/s^2]."""

    def describe(self, kind: Kind) -> str:
        """Return the finding as words."""
        lines = self.comb
        place = f"{LINES[kind]} at {lines.order:.3f} orders"
        level = f"{lines.level:.1f} dB over background from {self.band}"
        if self.limit:
            return f"{place} has {lines.amplitude**0.5:.3g} m/s^2 at 20 Hz where {self.limit:g} is a defect, {level}"
        return f"{place} modulates the squared envelope by {lines.depth:.2f} of its mean, {level}"


class BandEvidence(NamedTuple):
    """The families of lines in one band."""

    band: Band
    spectrum: OrderSpectrum
    combs: Mapping[Kind, Comb]


def families(band: Band, spectrum: OrderSpectrum, orders: Orders, slip: float) -> BandEvidence:
    """Return the families of lines of a band."""
    bases = [orders.bpfo, 2.0 * orders.bpfo, orders.bpfi, 2.0 * orders.bpfi, 2.0 * orders.bsf]
    *rings, roller = fitted_orders(spectrum, bases, slip).tolist()
    ftf = orders.ftf * rings[0] / orders.bpfo
    teeth = [
        *((base, HARMONICS * base) for base in rings[:2]),
        *((base, np.add.outer(HARMONICS * base, SHAFT_SIDEBANDS).ravel()) for base in rings[2:]),
        (roller, np.add.outer(HARMONICS * roller, ftf * CAGE_SIDEBANDS).ravel()),
        (ftf, CAGE_TEETH * ftf),
    ]
    odd, even, inner, twice_inner, rollers, cage = combs(spectrum, teeth)
    found: dict[Kind, Comb] = {"outer_ring": _deeper(odd, even), "inner_ring": _deeper(inner, twice_inner), "roller": rollers, "cage": cage}
    return BandEvidence(band, spectrum, found)


def _deeper(first: Comb, second: Comb) -> Comb:
    return second if second.depth > first.depth else first


class Limits(NamedTuple):
    """Sizes of BPFO lines from which they are a fault, at the reference speed."""

    whole: float
    """In the whole band [m/s^2]."""
    high: float
    """In its upper quarter [m/s^2]."""


def findings(bands: Sequence[BandEvidence], whole: Band, high: Band, limits: Limits, parameters: DetectorParameters) -> dict[Kind, Finding]:
    """Return the strongest finding for each fault.

    ``whole`` and ``high`` are the bands that BPFO lines are measured in; the cage is looked for below the ``whole`` band too, where the
    varying compliance carries its rhythm.
    """
    sizes = {whole: limits.whole, high: limits.high}
    found: dict[Kind, list[Finding]] = {kind: [] for kind in KINDS}
    for evidence in bands:
        for kind in KINDS:
            if kind == "outer_ring" and evidence.band in sizes:
                found[kind].append(_outer(evidence, sizes[evidence.band], parameters))
            elif kind == "cage" or (kind != "outer_ring" and evidence.band.low >= whole.low):
                found[kind].append(_modulated(evidence, kind, parameters))
    best = {
        kind: max(own, key=lambda finding: finding.excess, default=Finding(NO_COMB, whole, LEAST_EXCESS)) for kind, own in found.items()
    }
    return _without_mirrors(best, bands, parameters)


def _outer(evidence: BandEvidence, limit: float, parameters: DetectorParameters) -> Finding:
    lines = evidence.combs["outer_ring"]
    size, depth = decibels(ratio(lines.amplitude, limit**2)), 2.0 * decibels(ratio(lines.depth, parameters.outer_depth))
    return Finding(lines, evidence.band, max(LEAST_EXCESS, min(size, depth)), limit)


def _modulated(evidence: BandEvidence, kind: Kind, parameters: DetectorParameters) -> Finding:
    lines = evidence.combs[kind]
    least_depth, least_level = {
        "inner_ring": (parameters.inner_depth, parameters.inner_level),
        "roller": (parameters.roller_depth, parameters.roller_level),
        "cage": (parameters.cage_depth, parameters.cage_level),
    }[kind]
    excess = min(decibels(ratio(lines.depth, least_depth)), lines.level - least_level)
    return Finding(lines, evidence.band, max(LEAST_EXCESS, excess))


MIRRORS: tuple[tuple[Kind, Kind], ...] = (
    ("cage", "outer_ring"),
    ("cage", "inner_ring"),
    ("cage", "roller"),
    ("inner_ring", "roller"),
    ("roller", "inner_ring"),
    ("inner_ring", "cage"),
    ("inner_ring", "outer_ring"),
    ("roller", "outer_ring"),
)
"""Families that throw lines on another's places: the first explains the second where it modulates deeper."""


def _without_mirrors(best: Mapping[Kind, Finding], bands: Sequence[BandEvidence], p: DetectorParameters) -> dict[Kind, Finding]:
    """Return the findings, those pushed below their thresholds that another family explains."""
    named = {kind for kind in KINDS if best[kind].excess >= 0.0}
    depths = {evidence.band: {kind: evidence.combs[kind].depth for kind in KINDS} for evidence in bands}
    found, explained = dict(best), set[Kind]()
    for source, image in MIRRORS:
        there, least = depths.get(best[image].band), p.comb_shadow if source == "cage" else p.shadow
        if {source, image} <= named - explained and there and there[source] >= least * there[image]:
            explained.add(image)
    if "roller" in named - explained:  # carried round by the cage, a roller defect has the cage's rhythm by itself
        explained.add("cage")
    for kind in explained & named:
        found[kind] = found[kind]._replace(excess=-max(p.release_margin + 1.0, abs(found[kind].excess)))
    return found
