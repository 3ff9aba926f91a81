"""Modulation at the cage frequency: harmonics of FTF, their clusters at the spin of a roller, and a ring's lines beside them."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.evidence import BandEvidence
from dcrb_ros.diagnosis.line_search import GUARD, Comb, LineFamily
from dcrb_ros.diagnosis.order_spectrum import decibels, ratio

BELOW_BPFO = 3
"""The highest harmonic of FTF is so many below BPFO, whose skirt hides the last two."""
MOST_HARMONICS = 13
"""Most harmonics of FTF that are searched: higher ones are too faint."""
CLUSTERED = 1.5
"""Amplitude of the harmonics of FTF near multiples of 2 BSF over those halfway between [-]; infinite for two strikes alike."""
PERIODIC = 0.25
"""Periodicity of the harmonics of FTF over the spin of a roller from which they cluster there [-]: those at the multiples are then three
times as large as those halfway between."""
SPINS = np.linspace(0.9, 1.02, 25)
"""Spin of a roller relative to the kinematic one that is tried [-]: unloaded rollers lose spin, which friction returns under load only."""
FEWEST_TURNS, MOST_SPINS = 4, 3.25
"""Lowest harmonic of FTF in which clusters are looked for, whose lower ones follow the load zone, and the highest over 2 BSF [-]."""
LOAD_ZONE = 5
"""Highest harmonic of FTF that the load zone makes [-]: a weight cos^1.5 within 60 degrees on either side has its first zero below the
sixth."""
LEAST_REACH = 0.3
"""Harmonics of FTF beyond those of the load zone over those, in the band with the least [-]: 32 simulated broken bars have 0.33 or more, 32
damaged rollers 0.18 or less."""


def over_the_cage(excess: float, lines: LineFamily, band: BandEvidence, contrast: float) -> float:
    """Return the ``excess`` of a ring's lines [dB]: below 0 if they are not larger than FTF and its double by a ``contrast`` [dB].

    All rollers strike the defect of a ring, and the cage modulates that only as far as they are unequal. A broken bar, or a damaged roller
    that the load zone reaches once per turn, has its largest lines at FTF.
    """
    if excess < 0.0 or not lines.lines or band.orders.ftf < 2.0 * GUARD * band.step:
        return excess
    ftf = band.family(cage_comb(band.orders)).order
    cage = float(band.at(np.outer([1.0, 2.0], [ftf, band.orders.ftf])).max())
    lead = decibels(math.sqrt(ratio(float(band.at(lines.lines).max()), cage))) - contrast if cage > 0.0 else 0.0
    return lead if lead < 0.0 else excess


def rollers(orders: Orders) -> int:
    """Return the number of rollers in a row, BPFO over FTF [-]."""
    return max(1, round(orders.bpfo / orders.ftf))


def cage_comb(orders: Orders) -> Comb:
    """Return the harmonics of FTF below BPFO."""
    last = min(MOST_HARMONICS, max(3, rollers(orders) - BELOW_BPFO))
    return Comb(orders.ftf, harmonics=tuple(range(1, last + 1)), leading=2)


def beyond_load_zone(band: BandEvidence, cage: LineFamily) -> float:
    """Return the harmonics of FTF beyond those of the load zone over those, less `LEAST_REACH` [dB]; 0 where noise would hide them.

    A broken bar disturbs the rollers beside it for two pitches at most, so that its lines reach half the number of rollers. The lines of
    something that the load zone weights once per turn of the cage, such as a damaged roller, end with the load zone.
    """
    zone = cage.order * np.arange(1, LOAD_ZONE + 1)
    beyond = cage.order * np.arange(LOAD_ZONE + 1, rollers(band.orders) // 2 + 1)
    if not len(beyond):
        return 0.0
    least = LEAST_REACH * float(np.sqrt(band.at(zone)).mean())
    if math.sqrt(float(band.noise(beyond).mean())) >= least:
        return 0.0
    return decibels(ratio(math.sqrt(float(band.at(beyond).mean())), least))


def spin_of_clusters(band: BandEvidence, cage: LineFamily) -> tuple[float, float]:
    """Return how strongly the harmonics of FTF cluster at multiples of a roller's spin, and twice that spin [orders].

    A defect strikes the two raceways in turn, unequally, and in every turn of the cage anew. The depths d_k of the harmonics k then vary
    with a period of BSF / FTF or twice that: the first value is the largest of sum(d_k cos(2 pi k FTF / spin)) / sum(d_k), at most 1 [-].
    """
    harmonics = np.arange(FEWEST_TURNS, math.floor(MOST_SPINS * 2.0 * band.orders.bsf / cage.order) + 1)
    depths = np.sqrt(band.at(harmonics * cage.order))
    if not depths.any():
        return 0.0, 2.0 * band.orders.bsf
    spins = band.orders.bsf * np.concatenate([SPINS, 2.0 * SPINS])
    periodicity = (np.cos(2.0 * math.pi * cage.order * harmonics / spins[:, None]) * depths).sum(axis=1) / depths.sum()
    best = int(np.argmax(periodicity))
    return float(periodicity[best]), 2.0 * band.orders.bsf * float(SPINS[best % len(SPINS)])


def clusters_at_spin(band: BandEvidence, cage: LineFamily) -> tuple[float, float]:
    """Return the depth of the harmonics of FTF at 2 BSF and its double, and halfway between such multiples [-].

    The first is a median, since one of the lines may belong to another family, the second the root of the mean power.
    """
    if cage not in band.clusters:
        band.clusters[cage] = _clusters_at_spin(band, cage)
    return band.clusters[cage]


def _clusters_at_spin(band: BandEvidence, cage: LineFamily) -> tuple[float, float]:
    orders = 2.0 * band.orders.bsf * np.array([[1.0, 2.0], [0.5, 1.5]])
    harmonics = np.rint(orders / cage.order)[..., None] + np.arange(-1.0, 2.0)
    near, between = band.at(harmonics * cage.order)
    middle = np.sort(near, axis=None)[near.size // 2 - 1 : near.size // 2 + 1]  # of six values
    return math.sqrt(0.5 * float(middle.sum())), math.sqrt(float(between.mean()))
