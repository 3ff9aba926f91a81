"""A line that is broad because its frequency wanders: the spin of a ball or an unloaded roller.

A rolling element strikes the raceways at 2 BSF while it passes the load zone. Between two passages its spin slips, and the axis of a ball
turns, so the phase is lost. The line at 2 BSF then becomes a hump that is as wide as a share of FTF, and no single value of the spectrum is
large (Smith and Randall 2015, Mech. Syst. Signal Process. 64-65).

The median of the spectrum within the hump over that of its surroundings shows it. Medians ignore the sharp lines of rings, shaft and
cage: up to half of the values may belong to them. Two quantities rate a hump, as they rate sharp lines:

* its **significance**: the logarithm of the median of n independent exponential values has the standard deviation 1 / (ln 2 sqrt n)
  (asymptotic variance of a median, 1 / (4 n f^2), with the density f = 1/2 at the median ln 2);
* its **modulation depth**: the root of the power of a flat hump with this median, which is at most that of a line that does not wander.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy.special import log_ndtr

from dcrb_ros.diagnosis.line_search import NO_LINES, LineFamily
from dcrb_ros.diagnosis.order_spectrum import medians

HALF_WIDTHS = (0.25, 0.5, 1.0)
"""Half widths of a hump that are tried [FTF]: the phase lasts for four, two or one turn of the cage."""
BESIDE = (2.0, 4.0)
"""Distance of its surroundings on either side [FTF]: beyond the sidebands of one damaged element, whose load zone is half a turn."""
SLIPS = 5
"""Orders of the middle that are tried within the range of a search [-]."""
INDEPENDENT = 3.0
"""Values of a spectrum that share the information of one: the Hann window's noise bandwidth of 1.5 lines, padded to twice its length."""
FEWEST = 24
"""Least number of values in a hump: eight independent ones."""
DEVIATION = 1.0 / math.log(2.0)
"""Standard deviation of the logarithm of a median times the root of the number of independent values [-]."""
TINY = 1e-30
"""Smallest number of which a logarithm is taken."""


def hump(power: npt.NDArray[np.floating], step: float, order: float, ftf: float, slip: float) -> LineFamily:
    """Return the most significant hump within ``slip`` (relative) of an ``order``, or `NO_LINES`.

    ``power`` is the squared modulation depth over equally spaced orders with a ``step``, shape (values,) [-]; ``ftf`` is the order of the
    cage. The significance is corrected for the middles and widths that are tried.
    """
    sides = [_slice(order + sign * BESIDE[0] * ftf, order + sign * BESIDE[1] * ftf, step) for sign in (-1.0, 1.0)]
    around = [power[side] for side in sides]
    if order - BESIDE[1] * ftf <= 0.0 or sides[1].stop > len(power) or min(len(values) for values in around) < FEWEST:
        return NO_LINES
    # The spectrum of an envelope falls or rises over the order: the background in the middle is the geometric mean of both sides.
    background = math.sqrt(max(float(medians(around[0])) * float(medians(around[1])), TINY))
    variance = INDEPENDENT / sum(len(values) for values in around)
    best, chosen = 0.0, NO_LINES
    for middle in order * (1.0 + slip * np.linspace(-1.0, 1.0, SLIPS)):
        for half in HALF_WIDTHS:
            values = power[_slice(middle - half * ftf, middle + half * ftf, step)]
            if len(values) < FEWEST:
                continue
            median = float(medians(values))
            score = math.log(max(median, TINY) / background) / (DEVIATION * math.sqrt(INDEPENDENT / len(values) + variance))
            if score <= best:
                continue
            best, excess = score, (median - background) / math.log(2.0) * len(values) / INDEPENDENT
            level = 10.0 * math.log10(max(median, TINY) / background)
            chosen = LineFamily(float(middle), 0.0, math.sqrt(max(excess, 0.0)), level, _significance(score))
    return chosen


def _significance(score: float) -> float:
    """Return -log10 of the probability that noise has a normal ``score`` as large in one of the humps that are tried [-]."""
    return -float(log_ndtr(-score)) / math.log(10.0) - math.log10(SLIPS * len(HALF_WIDTHS))


def _slice(first: float, second: float, step: float) -> slice:
    """Return the values between two orders."""
    low, high = sorted((first, second))
    return slice(max(0, math.ceil(low / step)), math.floor(high / step) + 1)
