"""Search for families of lines in a squared envelope spectrum, with the probability that noise alone shows as much.

A family is a fundamental, its harmonics and their sidebands. Two quantities rate it, and neither has a unit:

* its **significance**: the squared amplitude of each line over the local mean of the spectrum has an exponential distribution in noise, so
  the sum over the n lines of a family has a gamma distribution (Johnson, Kotz and Balakrishnan 1994, ch. 17). The best of many places is
  reported, so the probability is multiplied by their number (Bonferroni);
* its **modulation depth**: the amplitude of the lines over the mean squared envelope, 2 for sharp impacts without noise. Long recordings
  make the faintest modulation significant, and only the depth says whether it matters.
"""

from __future__ import annotations

import functools
import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d

from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum
from dcrb_ros.schema.arrays import Floats

FEWEST_NEIGHBOURS = 128
"""Least number of neighbours from which the local mean is taken: some 40 of them are independent."""
NEIGHBOURHOOD = 1.0
"""Width of the neighbourhood [orders]: the envelope of noise has no structure as narrow as that, and the gap between lines is smaller."""
LARGEST_SCORE = 12.0
"""Largest score of a line: at exp(-12), no single line makes a family significant."""
BEYOND = 6
"""Steps beyond the range that are looked at: half the main lobe of a Hann window at the highest harmonic has 8."""
MANY = 5
"""Harmonics from which their mean amplitude represents them, not their power: among many, some lie on lines of other families."""
PLATEAU = 0.999
"""Power of a plateau relative to its first value [-]."""
PLACES = 2.0
"""Independent values among the three neighbouring ones of which the largest counts, in a spectrum padded to twice its length."""
NOISE_FLOOR = 3.0
"""Squared amplitude over the local mean up to which a value is noise: it exceeds 3 with a probability of 5 %."""
GUARD = 4
"""Values on either side of a line that belong to it: half the main lobe of a Hann window, padded to twice its length."""


class Comb(NamedTuple):
    """The lines of a family: harmonics of a fundamental, each with sidebands."""

    order: float
    """Kinematic order of the fundamental [-]."""
    harmonics: tuple[int, ...] = (1, 2, 3)
    sidebands: tuple[float, ...] = (0.0,)
    """Distances of the sidebands from a harmonic, with 0 for the harmonic itself [orders]."""
    leading: int = 1
    """How many of the first harmonics may lead: the others count up to the largest of these."""


class LineFamily(NamedTuple):
    """A family of lines found in a spectrum."""

    order: float
    """Order of the fundamental [-]."""
    amplitude: float
    """Root mean square of its harmonics, each with its sidebands; the mean if they are many [unit^2]."""
    depth: float
    """Amplitude over the mean squared envelope: 0 without modulation, 2 for sharp impacts without noise, more with sidebands [-]."""
    level: float
    """Mean power of the lines over the local mean of the spectrum [dB]."""
    significance: float = 0.0
    """-log10 of the probability that noise alone has as strong a family within the range searched; negative without evidence [-]."""
    lines: tuple[float, ...] = ()
    """Orders at which the harmonics were found [-]."""
    width: int = 1
    """Lines that make a harmonic: itself and its sidebands [-]."""

    @property
    def depth_per_line(self) -> float:
        """Modulation depth of a single line if all of them are as deep, which compares families with and without sidebands [-]."""
        return self.depth / math.sqrt(self.width)


NO_LINES = LineFamily(0.0, 0.0, 0.0, 0.0)


class LineSearch:
    """One spectrum, prepared for the search."""

    def __init__(self, spectrum: OrderSpectrum, *, without: npt.NDArray[np.bool_] | None = None) -> None:
        """Search ``spectrum``; the values marked in ``without``, shape (lines,), are no evidence."""
        self.spectrum = spectrum
        self.step = float(spectrum.orders[1])
        """Distance of two values [orders]."""
        self._without = without

    @cached_property
    def _power(self) -> Floats:
        return np.square(self.spectrum.amplitude, dtype=np.float64)

    @cached_property
    def local_mean(self) -> Floats:
        """Local mean of the squared amplitude, from the median of the neighbours: exponential values have a median of ln 2 means."""
        return local_mean(self._power, max(FEWEST_NEIGHBOURS, math.ceil(NEIGHBOURHOOD / self.step)))

    @cached_property
    def _excess(self) -> Floats:
        """Squared amplitude of lines without the noise in it, largest of three neighbours."""
        excess = np.maximum(self._power - NOISE_FLOOR * self.local_mean, 0.0)
        excess[self._masked] = 0.0
        return _largest_of_three(excess)

    @cached_property
    def _scores(self) -> Floats:
        """-ln of the probability that noise alone is as strong in one of three neighbours, limited; exponential in noise."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(self.local_mean > 0.0, self._power / self.local_mean, 0.0)
        ratio[self._masked] = 0.0
        return np.clip(_largest_of_three(ratio) - math.log(PLACES), 0.0, LARGEST_SCORE)

    @cached_property
    def _masked(self) -> npt.NDArray[np.bool_]:
        orders = self.spectrum.orders
        masked = np.abs(orders - np.rint(orders)) <= GUARD * self.step
        # In a short window the guards would cover the whole spectrum; then the harmonics of the shaft cannot be told from their neighbours.
        masked = masked if 2 * GUARD * self.step < 0.25 else orders <= GUARD * self.step
        return masked if self._without is None else masked | self._without

    def at(self, lines: npt.ArrayLike) -> Floats:
        """Return the power of ``lines`` [orders] without the noise, same shape; 0 above the spectrum [unit^4]."""
        places = np.asarray(lines, np.float64)
        near = np.clip(np.rint(places / self.step).astype(np.int64), 0, len(self._excess) - 1)
        return np.asarray(np.where(places < self.spectrum.orders[-1], self._excess[near], 0.0), np.float64)

    def best(self, comb: Comb, slip: float) -> LineFamily:
        """Return the strongest family within ``slip`` (relative) of the kinematic order; the significance has paid for that search."""
        limit = self.spectrum.orders[-1] - 2.0 * self.step
        if comb.order * comb.harmonics[0] * (1.0 + slip) >= limit:
            return NO_LINES
        trials = trials_of(comb, slip, self.step, len(self.spectrum.orders), limit)
        harmonics, count, steps, tried, near = trials.harmonics, trials.half, trials.steps, trials.orders, trials.near
        total = self._scores[near].sum(axis=(1, 2))
        groups = self._excess[near].sum(axis=2)  # power of a harmonic with its sidebands
        # A harmonic counts up to the leading one: a single line at a multiple belongs to another family.
        limited = np.minimum(groups, groups[:, : comb.leading].max(axis=1, keepdims=True))
        power = limited.mean(axis=1) if len(harmonics) < MANY else np.square(np.sqrt(limited).mean(axis=1))
        # Near the end of the range, the slope of a line beyond it is no line.
        inside = (np.abs(steps) <= count) & (power >= maximum_filter1d(power, 2 * BEYOND + 1))
        inside = inside if inside.any() else np.abs(steps) <= count
        strong = inside & (total >= 0.9 * total[inside].max())
        first = int(np.argmax(np.where(strong, power, -1.0)))
        # The largest of three neighbours makes a plateau, in whose middle the line is.
        differs = np.flatnonzero(power[first:] < PLATEAU * power[first])
        best = first + int(differs[0] - 1 if len(differs) else 0) // 2
        amplitude, mean = math.sqrt(power[best]), self.spectrum.mean
        independent = max(1.0, 2.0 * slip * trials.highest / (2.0 * self.step))
        significance = -(log10_gamma_tail(float(total[best]), near[best].size) + math.log10(independent))
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = self._excess[near[best]].mean() / max(float(self.local_mean[near[best]].mean()), np.finfo(np.float64).tiny)
        level = 10.0 * math.log10(min(max(ratio, 1e-12), 1e12)) if ratio > 0.0 else 0.0
        depth = min(amplitude / mean, 1e6) if mean > 0.0 else 0.0
        lines = tuple((harmonics * tried[best]).tolist())
        return LineFamily(float(tried[best]), amplitude, depth, max(level, 0.0), significance, lines, len(comb.sidebands))


class Trials(NamedTuple):
    """The orders of the fundamental that a search tries, and where the lines would be."""

    harmonics: npt.NDArray[np.int64]
    """Harmonics within the spectrum, shape (harmonics,)."""
    half: int
    """Orders tried on either side of the kinematic one [-]."""
    steps: npt.NDArray[np.int64]
    """Number of each order tried, 0 for the kinematic one, shape (orders,)."""
    orders: Floats
    """Shape (orders,) [-]."""
    near: npt.NDArray[np.int64]
    """Index of the nearest value of the spectrum, shape (orders, harmonics, lines)."""
    highest: float
    """Highest line of the kinematic order [-]."""


@functools.lru_cache(maxsize=64)
def trials_of(comb: Comb, slip: float, step: float, values: int, limit: float) -> Trials:
    """Return what a search for a comb tries within ``slip`` in a spectrum of ``values`` with a ``step`` up to a ``limit`` [orders].

    All bands of a hop have the same spectrum, so that this is found once for all of them.
    """
    harmonics = np.array([h for h in comb.harmonics if h * comb.order * (1.0 + slip) + max(comb.sidebands) < limit] or [comb.harmonics[0]])
    count = max(1, math.ceil(slip * float(harmonics[-1]) * comb.order / (0.5 * step)))
    steps = np.arange(-count - BEYOND, count + BEYOND + 1)
    tried = comb.order * (1.0 + slip * steps / count)
    places = tried[:, None, None] * harmonics[:, None] + np.asarray(comb.sidebands)
    near = np.clip(np.rint(places / step).astype(np.int64), 1, values - 1)
    return Trials(harmonics, count, steps, tried, near, float(places[count + BEYOND].max()))


def _largest_of_three(values: Floats) -> Floats:
    largest = values.copy()
    np.maximum(largest[1:], values[:-1], out=largest[1:])
    np.maximum(largest[:-1], values[1:], out=largest[:-1])
    return np.asarray(largest, np.float64)


def local_mean(power: Floats, width: int) -> Floats:
    """Return the mean of exponentially distributed ``power`` around each value, shape (values,), from medians over ``width`` values.

    Up to half of the neighbours may be lines. Medians of half-overlapping blocks are interpolated.
    """
    if len(power) <= width:
        return np.full(len(power), float(np.median(power)) / math.log(2.0))
    half = max(1, width // 2)
    halves = len(power) // half
    blocks = power[: halves * half].reshape(halves, half)
    medians = np.median(np.concatenate([blocks[:-1], blocks[1:]], axis=1), axis=1)
    centres = half * (np.arange(halves - 1) + 1.0)
    return np.asarray(np.interp(np.arange(len(power)), centres, medians) / math.log(2.0), np.float64)


def log10_gamma_tail(total: float, count: int) -> float:
    """Return log10 of the probability that ``count`` exponential variables of mean 1 sum to more than ``total``.

    It is exp(-t) times the sum of t^k / k! for k < count (Erlang distribution).
    """
    if total <= 0.0:
        return 0.0
    k = np.arange(count)
    terms = k * math.log(total) - np.array([math.lgamma(j + 1.0) for j in range(count)])
    top = float(terms.max())
    return (top + math.log(float(np.exp(terms - top).sum())) - total) / math.log(10.0)


def covered(spectrum: OrderSpectrum, lines: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return which values lie within the resolution of one of the ``lines`` [orders], shape (values,)."""
    middle = np.rint(np.asarray(lines, np.float64).ravel() / float(spectrum.orders[1])).astype(np.int64)
    near = (middle[:, None] + np.arange(-GUARD, GUARD + 1)).ravel()
    marked = np.zeros(len(spectrum.orders), np.bool_)
    marked[near[(near >= 0) & (near < len(marked))]] = True
    return marked
