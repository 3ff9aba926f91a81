"""Outer-ring defect: BPFO lines, deeper than those of a healthy bearing, whose compliance varies as rollers pass the load line.

If it is known how large the lines of the healthy bearing are, as the baseline of one bearing and one sensor, they must also be larger.

The simulated bearing of the paper is loud when healthy. It has no roughness, no lubricant and much radial clearance, so its idle rollers
strike the raceway at BPFO as they enter the load zone. Those lines modulate the squared envelope as deeply as a defect's, and only their
size distinguishes them. Limits for it apply to the bearing with exactly this geometry, which is in the description of its sensor. They do
not apply to measured ones.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.cage_lines import over_the_cage, rollers
from dcrb_ros.diagnosis.evidence import BandEvidence, Evidence
from dcrb_ros.diagnosis.healthy_baseline import HealthyBaseline
from dcrb_ros.diagnosis.line_search import GUARD, Comb, LineFamily
from dcrb_ros.diagnosis.order_spectrum import HARMONICS, decibels, ratio
from dcrb_ros.diagnosis.rule import Finding, LineParameters, LineRule, sidebands
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import quantity
from dcrb_ros.schema.refusal import Refusal

PAPER_BEARING = {
    "rollers_per_row": 16.0,
    "inner_raceway_radius": 0.07886,
    "outer_raceway_radius": 0.10914,
    "pitch_radius": 0.094,
    "roller_radius": 0.015,
}
"""Geometry of the bearing of Fan et al. 2025, Table 1, with a diametral clearance of 0.28 mm [m]."""
PAPER_LIMITS = (38.0, 12.0)
"""Sizes of its healthy BPFO lines in the whole band and its upper quarter at a shaft frequency of 20 Hz, with a margin of 3 dB [m/s^2].

Healthy runs at 300 to 3820 rpm and 30 to 160 kN have up to 26 and, with a resonant mount, 10 m/s^2."""
HIGHEST_HARMONIC = 6
"""Harmonic of BPFO up to which the lines show whether rollers strike at one place."""
FEWEST_HARMONICS = 24.0
"""Harmonics of BPFO in a band from which on its envelope carries the sixth with three quarters of its size [-]."""
LEAST_SHARPNESS = 0.7
"""Amplitude of a harmonic times its number k, root mean square of harmonics 4 to 6 over that of 1 to 3, the least of impacts at one place.

Impacts that ring exponentially have harmonics that fall no faster than 1 / k: 1, and 0.87 in a band of `FEWEST_HARMONICS`. A decibel of
scatter leaves 0.7. The edge of the load zone is no such place: where a roller is first loaded depends on its diameter. Strikes that scatter
by a share s of the pitch have harmonics that fall as exp(-2 (pi k s)^2), which leaves 0.4 for s = 0.075."""


def is_paper_bearing(bearing: object) -> bool:
    """Return whether a mapping of the fields of `dcrb_ros.Bearing`, or such an object, has the geometry of the paper's bearing."""
    for name, value in PAPER_BEARING.items():
        given = bearing.get(name) if isinstance(bearing, Mapping) else getattr(bearing, name, None)
        if isinstance(given, bool) or not isinstance(given, (int, float)) or not math.isclose(given, value, rel_tol=1e-6):
            return False
    return True


class OuterRingParameters(LineParameters):
    """Threshold of BPFO lines, and the baseline of a healthy bearing."""

    outer_depth: float = quantity(
        0.17, "-", "Modulation depth required of BPFO lines; impacts with a tenth of the power in the band make 0.17", 0.0, 2.0
    )
    cage_contrast: float = quantity(
        1.5,
        "dB",
        "Amplitude of BPFO lines required over the neighbouring harmonics of FTF, to which they belong if the cage is the cause",
        0.0,
        20.0,
    )
    outer_double: float = quantity(
        1.5,
        "dB",
        "Largest amplitude of the line at 2 BPFO over that at BPFO; beyond it the rollers excite twice per pass, unlike at one defect",
        0.0,
        20.0,
    )
    outer_limit: float = quantity(
        0.0,
        "m/s^2",
        "Baseline: BPFO lines in the whole band, scaled to 20 Hz, up to which the bearing is known to be healthy; 0 without a baseline",
        0.0,
        1e6,
    )
    outer_limit_high: float = quantity(0.0, "m/s^2", "The same for the upper quarter of the band", 0.0, 1e6)
    learn: float = quantity(
        0.0,
        "s",
        "Time from the first verdict during which the bearing is assumed healthy and the limits of the outer ring are learned; 0 for none",
        0.0,
        1e5,
    )


class OuterRing(LineRule[OuterRingParameters]):
    """BPFO and its harmonics; with a baseline, also by their size at the reference speed."""

    component, name, parameters = "outer_ring", "BPFO", OuterRingParameters

    def __init__(self, parameters: OuterRingParameters) -> None:
        super().__init__(parameters)
        self._whole_limit, self._high_limit = parameters.outer_limit, parameters.outer_limit_high
        self._remaining = parameters.learn
        """Time for which the limits are still learned [s]."""

    def take_baseline(self, baseline: HealthyBaseline) -> None:
        """Compare lines with those of the healthy bearing.

        Raises:
            Refusal: the parameters give sizes of its lines, or say that they are to be learned.
        """
        given = next((name for name in ("outer_limit", "outer_limit_high", "learn") if getattr(self.p, name)), "")
        if given:
            raise Refusal(f"{given} = {getattr(self.p, given):g} and a baseline are given: leave out one of them")
        super().take_baseline(baseline)

    def take_bearing(self, bearing: object) -> None:
        """Use the limits of the paper's bearing, unless a baseline or the parameters give others or they are to be learned."""
        given = self.baseline is not None or self.p.outer_limit or self.p.outer_limit_high or self.p.learn
        if not given and is_paper_bearing(bearing):
            self._whole_limit, self._high_limit = PAPER_LIMITS

    def combs(self, orders: Orders) -> Sequence[Comb]:
        """Return BPFO."""
        # Rows staggered by half a pitch strike in turn and leave only the even harmonics; a baseline makes those safe to use.
        return self.baseline_combs(orders) if self._limited or self.baseline is not None else (Comb(orders.bpfo),)

    def baseline_combs(self, orders: Orders) -> Sequence[Comb]:
        """Return BPFO and its double."""
        return Comb(orders.bpfo), Comb(2.0 * orders.bpfo)

    @property
    def depth(self) -> float:
        """Modulation depth that is required [-]."""
        return self.p.outer_depth

    @property
    def _limited(self) -> bool:
        """Whether it is known how large the lines of the healthy bearing are."""
        return self._whole_limit > 0.0 or self._high_limit > 0.0

    def bands(self, evidence: Evidence) -> Sequence[BandEvidence]:
        """Return the bands within the detector's; with a baseline the whole band and its upper quarter."""
        if not self._limited:
            return super().bands(evidence)
        return [band for band in evidence.bands if band.band in (evidence.whole, evidence.high)]

    def companions(self, lines: LineFamily, orders: Orders) -> Floats:
        """Return the harmonics of BPFO with sidebands at the shaft, whose unbalance turns, and at the cage with its unequal rollers."""
        cage = lines.order / rollers(orders)
        return sidebands(lines.order, np.add.outer(np.arange(-2.0, 3.0), cage * np.arange(-3.0, 4.0)))

    def excess(self, lines: LineFamily, band: BandEvidence, evidence: Evidence) -> float:
        """Return the excess of depth and significance; with a baseline also that of the size over the limit of the band [dB]."""
        excess = min(super().excess(lines, band, evidence), self._contrast(lines, band))
        excess = min([excess, *(lack for lack in (self._rhythm(lines, band), self._sharpness(lines, band, evidence)) if lack < 0.0)])
        excess = over_the_cage(excess, lines, band, self.p.ring_contrast)
        if not self._limited:
            return excess
        return min(excess, decibels(ratio(lines.amplitude, self._limit(band, evidence) ** 2)))

    def _contrast(self, lines: LineFamily, band: BandEvidence) -> float:
        """Return the amplitude of BPFO lines over that of the neighbouring harmonics of FTF, less the contrast required, or infinity [dB].

        BPFO is itself a harmonic of FTF. What the cage carries, a broken bar or a damaged roller, makes it no larger than its neighbours.
        """
        cage = lines.order / rollers(band.orders)
        if lines.depth <= 0.0 or cage < 2.0 * GUARD * band.step:
            return math.inf
        beside = band.at(np.add.outer(np.asarray(lines.lines), [-cage, cage]))
        power = ratio(float(band.at(lines.lines).mean()), float(beside.mean())) if beside.any() else math.inf
        return decibels(math.sqrt(power)) - self.p.cage_contrast

    def _rhythm(self, lines: LineFamily, band: BandEvidence) -> float:
        """Return by how much the line at 2 BPFO is below its limit [dB]; 0 if nothing follows.

        One impact per pass of a roller has harmonics that fall, or stay as large. A healthy roller that enters and leaves the load zone
        excites twice per pass: strengths a and b half a pitch apart make lines of a - b at BPFO and a + b at its double. Where BPFO is
        next to a harmonic of the shaft, its line is not seen as large as it is, and nothing follows from that.
        """
        if len(lines.lines) < 2 or abs(lines.order - round(lines.order)) <= 2.0 * GUARD * band.step:
            return 0.0
        first, second = band.at(lines.lines[:2]).tolist()
        return decibels(math.sqrt(ratio(first, second))) + self.p.outer_double if second > 0.0 else 0.0

    def _sharpness(self, lines: LineFamily, band: BandEvidence, evidence: Evidence) -> float:
        """Return by how much harmonics 4 to 6 of BPFO exceed the least that impacts at one place make [dB]; see `LEAST_SHARPNESS`.

        It is 0 if the band is too narrow for them, or if noise would hide them. A healthy bearing whose lines are known needs no such
        criterion.
        """
        known = self._limited or self.baseline is not None
        if known or band.band.high - band.band.low < FEWEST_HARMONICS * lines.order * evidence.shaft_frequency:
            return 0.0
        harmonics = np.arange(1, HIGHEST_HARMONIC + 1)
        places = harmonics * lines.order
        # Next to a harmonic of the shaft, a low line is not seen as large as it is, and a high one is at most what is seen there.
        beside = np.abs(places - np.rint(places)) > 2.0 * GUARD * band.step
        low, high = beside & (harmonics <= len(HARMONICS)), harmonics > len(HARMONICS)
        power, noise = harmonics**2 * band.largest(places), harmonics**2 * band.noise(places)
        least = LEAST_SHARPNESS**2 * float(power[low].mean()) if low.any() else 0.0
        if float(noise[high].mean()) >= least:
            return 0.0
        return decibels(math.sqrt(ratio(float(power[high].mean()), least)))

    def _limit(self, band: BandEvidence, evidence: Evidence) -> float:
        return self._whole_limit if band.band == evidence.whole else self._high_limit

    def reason(self, lines: LineFamily, band: BandEvidence, evidence: Evidence) -> str:
        """Return depth, or size and limit, in words."""
        limit = self._limit(band, evidence)
        if not self._limited or limit == 0.0:
            return super().reason(lines, band, evidence)
        size = f"has {lines.amplitude**0.5:.3g} m/s^2 (baseline {limit:g} m/s^2, both at a shaft frequency of 20 Hz)"
        return f"{self._place(lines)} {size}, {self._level(lines, band)}"

    def settled(self, finding: Finding, evidence: Evidence) -> Finding:
        """Return the finding; while the limits are learned, raise them above the present lines and suspect nothing."""
        if self._remaining <= 0.0:
            return finding
        self._remaining -= evidence.interval
        margin = 10.0 ** (self.p.learn_margin / 20.0)
        for band in evidence.bands:
            size = margin * math.sqrt(max(band.family(comb).amplitude for comb in self.combs(evidence.orders)))
            if band.band == evidence.whole:
                self._whole_limit = max(self._whole_limit, size)
            if band.band == evidence.high:
                self._high_limit = max(self._high_limit, size)
        return finding._replace(excess=min(-1.0, finding.excess))

    @property
    def remark(self) -> str:
        """How long the limits are still learned, or that a baseline is used."""
        if self._remaining <= 0.0 and self._limited:
            return "outer-ring lines are compared with a baseline of the healthy bearing"
        return f"learning for another {self._remaining:.1f} s: outer-ring defects are not reported yet" if self._remaining > 0.0 else ""
