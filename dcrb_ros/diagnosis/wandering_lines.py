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

from dcrb_ros.diagnosis.line_search import NO_LINES, TINY, LineFamily
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


def humps(power: npt.NDArray[np.floating], step: float, order: float, ftf: float, slip: float) -> list[LineFamily]:
    """Return the most significant hump within ``slip`` (relative) of an ``order`` in each spectrum, or `NO_LINES`.

    ``power`` is the squared modulation depth over equally spaced orders with a ``step``, shape (spectra, values) [-]; ``ftf`` is the order
    of the cage. The significance is corrected for the middles and widths that are tried.
    """
    sides = [_slice(order + sign * BESIDE[0] * ftf, order + sign * BESIDE[1] * ftf, step) for sign in (-1.0, 1.0)]
    around = [power[:, side] for side in sides]
    middles = order * (1.0 + slip * np.linspace(-1.0, 1.0, SLIPS))
    windows = [(middle, power[:, _slice(middle - half * ftf, middle + half * ftf, step)]) for middle in middles for half in HALF_WIDTHS]
    windows = [(middle, values) for middle, values in windows if values.shape[1] >= FEWEST]
    outside = order - BESIDE[1] * ftf <= 0.0 or sides[1].stop > power.shape[1]
    if outside or not windows or min(values.shape[1] for values in around) < FEWEST:
        return [NO_LINES] * len(power)
    # The spectrum of an envelope falls or rises over the order: the background in the middle is the geometric mean of both sides.
    before, after = (medians(values).astype(np.float64) for values in around)
    background = np.sqrt(np.maximum(before * after, TINY))
    variance = INDEPENDENT / sum(values.shape[1] for values in around)
    sizes = np.array([[values.shape[1]] for _, values in windows])
    median = np.array([medians(values) for _, values in windows], np.float64)
    ratios = np.maximum(median, TINY) / background
    scores = np.log(ratios) / (DEVIATION * np.sqrt(INDEPENDENT / sizes + variance))
    depths = np.sqrt(np.maximum((median - background) / math.log(2.0) * sizes / INDEPENDENT, 0.0))
    chosen = [(int(best), k) for k, best in enumerate(scores.argmax(axis=0))]
    return [
        LineFamily(float(windows[n][0]), 0.0, float(depths[n, k]), 10.0 * math.log10(ratios[n, k]), _significance(float(scores[n, k])))
        if scores[n, k] > 0.0
        else NO_LINES
        for n, k in chosen
    ]


def _significance(score: float) -> float:
    """Return -log10 of the probability that noise has a normal ``score`` as large in one of the humps that are tried [-]."""
    return -float(log_ndtr(-score)) / math.log(10.0) - math.log10(SLIPS * len(HALF_WIDTHS))


def _slice(first: float, second: float, step: float) -> slice:
    """Return the values between two orders."""
    low, high = sorted((first, second))
    return slice(max(0, math.ceil(low / step)), math.floor(high / step) + 1)
