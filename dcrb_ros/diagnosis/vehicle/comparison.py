"""Which box the lines of a damaged bearing belong to: the same lines compared in all boxes of the vehicle.

The bearings of a vehicle have equal orders, and the vibration of one reaches the sensors of all boxes. Lines that one box shows may
therefore be those of another one. They are compared in each band by two quantities:

* their **size**, which is that of the source over the path, but depends on the gain of the sensor;
* their **modulation** d / (2 - d), with d the depth over the mean squared envelope. It is the power of the impacts over that of the noise
  in the same band, so it does not depend on the gain, but on the noise.

The contrast of two boxes is the mean of both ratios, in the median of the bands [dB]. In a band almost without noise, only the size
distinguishes them. Where the contrast to the other box of the wheelset is small, the damaged box measures the impacts first.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from dcrb_ros.diagnosis.evidence import Evidence
from dcrb_ros.diagnosis.line_search import GUARD
from dcrb_ros.diagnosis.rule import Finding
from dcrb_ros.diagnosis.vehicle.arrival import LEAST, TurnEnvelopes, lead
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.verdicts import COMPONENTS, Component

FAINTEST = 0.02
"""Modulation depth of lines from which a band is compared [-]: a fifth of the least that a rule requires."""
NOISE = 0.4
"""Depth of sharp lines over the limit of their noise up to which a box has none [-].

In 120 000 draws of white noise, 7 % of families of three lines and 3 % of families of nine had more. The values of a hump are many and near
their noise; none of them is left out."""
LIMIT = 30.0
"""Largest contrast of a band [dB]."""
SHARPEST = 2.0
"""Modulation depth of sharp impacts without noise [-]."""
SATURATED = 1.0
"""Modulation depth from which the noise is too small to compare with [-]: impacts have more power than it."""
LEAST_NOISE = 0.2
"""Least noise that is assumed in that scale [-]: sidebands make lines deeper than 2."""
LEAST_MODULATION = 1e-3
"""Modulation at which a line is no larger than the noise of the spectrum [-]."""
BESIDE = np.array([-2.0, -1.0, 1.0, 2.0])
"""Harmonics of a wheel's rotation that are compared with the one on which a line lies [-]."""
NEARLY_ALL = 0.9
"""Share of the power of lines at the harmonics of a wheel's rotation from which they may be these harmonics [-]: a flat of 60 mm had all of
it there, and an inner ring with one harmonic beside such an order 0.65."""
LEAST_BESIDE = 0.1
"""Power of those harmonics over that of the line from which it is one of them [-]."""
HUMP = np.linspace(-0.25, 0.25, 9)
"""Distances from the middle of a hump that are compared [FTF]."""
NOT_OWN = -60.0
"""Excess of lines that belong to another box or to a wheel [dB]."""
UNOPPOSED = "the other box of the wheelset is not judged"
"""Reason for no verdict on one box of a wheelset."""


@dataclass(frozen=True)
class Judgement:
    """The evidence on the bearing of one box at a hop, by itself."""

    evidence: Evidence
    findings: Mapping[Component, Finding]
    """Evidence for a fault of each component."""
    faint: Mapping[Component, Finding]
    """The same at lower thresholds of the modulation depth, which count if no other box has the lines, or has them later."""
    envelopes: TurnEnvelopes

    @property
    def shaft_frequency(self) -> float:
        """Mean within the window [Hz]."""
        return self.evidence.shaft_frequency


class Compared(NamedTuple):
    """The evidence for a fault of one component in one box, after a comparison with the other boxes."""

    finding: Finding
    """What was compared."""
    excess: float
    """Evidence relative to the threshold [dB]."""
    undecided: float
    """Evidence that may as well belong to another box [dB]; `NOT_OWN` if it does not."""
    contrast: float
    """Contrast to the other box that has these lines most [dB]."""
    rival: str
    """Name of that box; empty without one."""
    lead: float = 0.0
    """By how much earlier the impacts are here than in that box [s]; 0 where it does not matter."""
    healthy: float = 0.0
    """Evidence that the lines of a healthy bearing may have [dB]; a verdict needs more of it."""
    unopposed: bool = False
    """Whether it is undecided because the other box of the wheelset is not judged."""


def unopposed(judged: Container[str], partners: Mapping[str, str]) -> set[str]:
    """Return the boxes whose partner, the other box of the wheelset, is not judged."""
    return {name for name, partner in partners.items() if partner not in judged}


def compare(
    judgements: Mapping[str, Judgement],
    parameters: VehicleDetectorParameters,
    partners: Mapping[str, str],
    confirmed: Mapping[str, Container[Component]] = MappingProxyType({}),
) -> dict[str, dict[Component, Compared]]:
    """Return the evidence for every component of every box that was judged; ``partners`` are the other boxes of the wheelsets.

    Components with a ``confirmed`` fault, by box, have been compared with the partner before, and are judged without it.
    """
    alone = unopposed(judgements, partners)
    return {
        name: {
            component: _compared(name, component, judgements, parameters, opposed=name not in alone or component in confirmed.get(name, ()))
            for component in COMPONENTS
        }
        for name in judgements
    }


def _compared(
    name: str, component: Component, judged: Mapping[str, Judgement], parameters: VehicleDetectorParameters, *, opposed: bool
) -> Compared:
    own = judged[name]
    finding, faint = own.findings[component], own.faint[component]
    usual = _attributed(name, finding, judged, parameters)._replace(healthy=_healthy(finding, own))
    if not opposed:
        return usual._replace(excess=NOT_OWN, undecided=usual.excess, unopposed=True) if usual.excess >= 0.0 else usual
    if faint.excess <= max(finding.excess, 0.0):
        return usual
    alone = _attributed(name, faint, judged, parameters)._replace(healthy=_healthy(faint, own))
    # Without another box, nothing shows how deep the lines of a healthy bearing are.
    clear = alone.rival and (alone.contrast >= parameters.contrast or alone.lead > 0.0)
    return alone if clear and alone.excess - alone.healthy > usual.excess - usual.healthy else usual


def _healthy(finding: Finding, own: Judgement) -> float:
    """Return the evidence that a healthy bearing may have [dB]; a rule that blames another component has considered its own."""
    rule = finding.rule
    return rule.healthy_evidence(own.evidence.orders) if rule is not None and rule.component == finding.component else 0.0


def _attributed(name: str, finding: Finding, judged: Mapping[str, Judgement], parameters: VehicleDetectorParameters) -> Compared:
    """Return the evidence of a finding in one box after the comparison of its lines with those in the other boxes."""
    own = judged[name]
    excess = finding.excess
    if finding.lines.order <= 0.0 or excess < -LIMIT:
        return Compared(finding, excess, NOT_OWN, 0.0, "")
    if _of_wheel(finding, own, judged):
        return Compared(finding, NOT_OWN, NOT_OWN, 0.0, "")
    orders = _orders(finding, own)
    noise = NOISE if finding.lines.lines else 0.0
    contrasts = {other: contrast(orders, own, judged[other], noise) for other in judged if other != name}
    if not contrasts:
        return Compared(finding, excess, NOT_OWN, LIMIT, "")
    rival = min(contrasts, key=lambda other: contrasts[other])
    least = contrasts[rival]
    if least >= parameters.contrast:
        return Compared(finding, excess, NOT_OWN, least, rival)
    if least <= -parameters.contrast:
        return Compared(finding, NOT_OWN, NOT_OWN, least, rival)
    alike = sum(value < parameters.contrast for value in contrasts.values())
    earlier = _lead(name, rival, orders, judged) if alike == 1 else 0.0
    if abs(earlier) < LEAST:
        return Compared(finding, NOT_OWN, excess, least, rival)
    return Compared(finding, excess if earlier > 0.0 else NOT_OWN, NOT_OWN, least, rival, earlier)


def _orders(finding: Finding, own: Judgement) -> Floats:
    """Return the orders that are compared: the harmonics found, with their sidebands if the first lies on a whole order [-].

    The search leaves out whole orders, which are those of the wheels. There, only sidebands are evidence. A hump has no harmonics, and is
    compared over its width.
    """
    lines, comb, band = finding.lines, finding.comb, finding.band
    if not lines.lines:
        return np.asarray(lines.order + own.evidence.orders.ftf * HUMP, np.float64)
    harmonics = np.array(lines.lines)
    if comb is None or band is None:
        return harmonics
    hidden = abs(harmonics[0] - round(harmonics[0])) <= GUARD * band.step
    return np.asarray(np.add.outer(harmonics, comb.sidebands).ravel(), np.float64) if hidden else harmonics


def _lead(name: str, rival: str, orders: Floats, judged: Mapping[str, Judgement]) -> float:
    """Return by how much earlier the impacts are in a box than in the other one of its wheelset [s]; 0 in one of another wheelset."""
    if name.rpartition("/")[0] != rival.rpartition("/")[0]:
        return 0.0
    return lead(judged[name].envelopes, judged[rival].envelopes, orders, judged[name].shaft_frequency)


def contrast(orders: Floats, own: Judgement, other: Judgement, noise: float) -> float:
    """Return by how much lines at ``orders`` of one box are larger there than in another one, in the median of bands [dB].

    Lines up to a share ``noise`` of the limit of their noise count as none [-].
    """
    # The other wheelset may turn faster or more slowly; its spectrum is over its own orders.
    elsewhere = orders * own.shaft_frequency / max(other.shaft_frequency, 1e-9)
    ratios = []
    bands = zip(own.evidence.bands, other.evidence.bands, own.evidence.depths(orders), other.evidence.depths(elsewhere), strict=True)
    for here, there, first, second in bands:
        if here not in own.evidence.within or max(first, second) < FAINTEST:
            continue
        depths = [
            depth if depth >= noise * math.sqrt(float(band.noise(lines).sum())) else 0.0
            for depth, band, lines in ((first, here, orders), (second, there, elsewhere))
        ]
        if max(depths) < FAINTEST:
            continue
        size = _decibels(depths[0] * here.spectrum.mean, depths[1] * there.spectrum.mean)
        ratios.append(size if max(depths) > SATURATED else 0.5 * (size + _decibels(*(_modulation(depth) for depth in depths))))
    return float(np.median(ratios)) if ratios else 0.0


def _modulation(depth: float) -> float:
    return depth / max(SHARPEST - depth, LEAST_NOISE) + LEAST_MODULATION


def _decibels(first: float, second: float) -> float:
    """Return the ratio of two squared amplitudes [dB], limited."""
    tiny = 1e-12
    return min(max(float(10.0 * np.log10((first + tiny) / (second + tiny))), -LIMIT), LIMIT)


def _of_wheel(finding: Finding, own: Judgement, judged: Mapping[str, Judgement]) -> bool:
    """Return whether the lines found for a bearing are harmonics of the rotation of a wheel.

    A flat makes a line at every order of its wheelset. Lines of a bearing that lie on such orders have none of that size beside them, or
    sidebands elsewhere.
    """
    band, orders = finding.band, _orders(finding, own)
    if band is None:
        return False
    power = band.at(orders)
    for turn in {judgement.shaft_frequency / max(own.shaft_frequency, 1e-9) for judgement in judged.values()}:
        harmonics = np.rint(orders / max(turn, 1e-9))
        # A line reaches as far as its main lobe, and the search takes the largest of three values.
        near = np.abs(orders - harmonics * turn) <= (GUARD + 1) * band.step
        if float(power[near].sum()) <= NEARLY_ALL * float(power.sum()):
            continue
        largest = int(np.argmax(np.where(near, power, -1.0)))
        beside = turn * np.maximum(harmonics[largest] + BESIDE, 1.0)
        # The search leaves out what is near whole orders of its own wheelset, where a flat of another one has lines, too.
        around = np.maximum(band.largest(beside) - band.noise(beside), 0.0)
        if float(np.median(around)) >= LEAST_BESIDE * float(power[largest]):
            return True
    return False
