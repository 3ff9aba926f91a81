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
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d

from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum, medians
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
LARGEST_DEPTH = 1e6
"""Modulation depth to which a line is limited [-]."""
TINY = 1e-30
"""Mean squared envelope up to which there is no signal [unit^2], and smallest number of which a logarithm is taken."""
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
    """Orders at which the harmonics were found [-]; none of a hump, which has no sharp lines."""
    width: int = 1
    """Lines that make a harmonic: itself and its sidebands [-]."""

    @property
    def depth_per_line(self) -> float:
        """Modulation depth of a single line if all of them are as deep, which compares families with and without sidebands [-]."""
        return self.depth / math.sqrt(self.width)


NO_LINES = LineFamily(0.0, 0.0, 0.0, 0.0)


class LineSearch:
    """Spectra over the same orders, prepared for the search: those of all bands are searched together.

    Amplitudes are divided by the mean squared envelope, so that the search has no unit and single precision suffices.
    """

    def __init__(self, *spectra: OrderSpectrum, without: npt.NDArray[np.bool_] | None = None) -> None:
        """Search ``spectra``; the values marked in ``without``, shape (lines,), are no evidence."""
        self.spectra = spectra
        self.orders = spectra[0].orders
        self.step = float(self.orders[1])
        """Distance of two values [orders]."""
        self._without = without

    @cached_property
    def _depth(self) -> npt.NDArray[np.float32]:
        """Amplitudes over the mean squared envelope, shape (spectra, lines) [-]."""
        scaled = [spectrum.amplitude * np.float32(1.0 / spectrum.mean if spectrum.mean > TINY else 0.0) for spectrum in self.spectra]
        return np.asarray(np.minimum(np.stack(scaled), np.float32(LARGEST_DEPTH)), np.float32)

    @cached_property
    def squared_depth(self) -> npt.NDArray[np.float32]:
        """Squared modulation depth with its noise, shape (spectra, lines) [-]."""
        return np.asarray(np.square(self._depth), np.float32)

    @cached_property
    def local_mean(self) -> npt.NDArray[np.float32]:
        """Local mean of the squared depth, from the median of the neighbours: exponential values have a median of ln 2 means.

        Shape (spectra, lines).
        """
        return local_mean(self.squared_depth, max(FEWEST_NEIGHBOURS, math.ceil(NEIGHBOURHOOD / self.step)))

    @cached_property
    def _values(self) -> npt.NDArray[np.float32]:
        """Scores of all spectra beside their squared depths without noise, shape (lines, 2 * spectra).

        The score is -ln of the probability that noise alone is as strong in one of three neighbours, limited; exponential in noise.
        """
        power, mean = self.squared_depth, self.local_mean
        ratio = np.divide(power * self._kept, mean, out=np.zeros_like(power), where=mean > 0.0)
        scores = _largest_of_three(ratio)
        scores -= np.float32(math.log(PLACES))
        count = len(self.spectra)
        values = np.empty((len(self.orders), 2 * count), np.float32)
        values[:, :count] = np.clip(scores, 0.0, LARGEST_SCORE, out=scores).T
        values[:, count:] = self._power.T
        return values

    @cached_property
    def _power(self) -> npt.NDArray[np.float32]:
        """Squared depths without noise, shape (spectra, lines) [-]."""
        excess = (self.squared_depth - np.float32(NOISE_FLOOR) * self.local_mean) * self._kept
        return np.asarray(np.maximum(_largest_of_three(excess), 0.0), np.float32)

    @cached_property
    def _kept(self) -> npt.NDArray[np.float32]:
        """1 for the values that are evidence, 0 for the others, shape (lines,)."""
        orders = self.orders
        masked = np.abs(orders - np.rint(orders)) <= GUARD * self.step
        # In a short window the guards would cover the whole spectrum; then the shaft's harmonics remain.
        masked = masked if 2 * GUARD * self.step < 0.25 else orders <= GUARD * self.step
        masked = masked if self._without is None else masked | self._without
        return np.asarray(np.where(masked, 0.0, 1.0), np.float32)

    def at(self, lines: npt.ArrayLike, number: int | slice = 0) -> Floats:
        """Return the squared depth of ``lines`` [orders] in one of the spectra without the noise, same shape; 0 above the spectrum [-].

        For a slice of the spectra it has one more axis, the first.
        """
        wanted = np.asarray(lines, np.float64)
        values = self._power[number].take(self._nearest(wanted), axis=-1, mode="clip")
        return np.asarray(np.where(wanted < self.orders[-1], values, 0.0), np.float64)

    def _nearest(self, lines: Floats) -> npt.NDArray[np.int64]:
        """Return the index of the value next to each of ``lines`` [orders], which may be none, same shape."""
        return np.rint(lines / self.step).astype(np.int64)

    def noise(self, lines: npt.ArrayLike, number: int = 0) -> Floats:
        """Return the squared depth up to which each of ``lines`` [orders] of one of the spectra is noise, same shape [-]."""
        near = self._nearest(np.asarray(lines, np.float64))
        return np.asarray(NOISE_FLOOR * self.local_mean[number].take(near, mode="clip"), np.float64)

    def best(self, comb: Comb, slip: float) -> LineFamily:
        """Return the strongest family of the first spectrum; see `families`."""
        return self.families(comb, slip)[0]

    def families(self, comb: Comb, slip: float) -> list[LineFamily]:
        """Return the strongest family of each spectrum within ``slip`` (relative) of the kinematic order.

        The significance is corrected for that search.
        """
        count = len(self.spectra)
        limit = self.orders[-1] - 2.0 * self.step
        if comb.order * comb.harmonics[0] * (1.0 + slip) >= limit:
            return [NO_LINES] * count
        trials = trials_of(comb, slip, self.step, len(self.orders), limit)
        total, power = self._sums(trials, comb.leading)
        best = _best_of(trials, total, power)
        each = np.arange(count)
        near = trials.near[best].reshape(count, -1)
        independent = max(1.0, 2.0 * slip * trials.highest / (2.0 * self.step))
        significance = -(log10_gamma_tail(total[best, each].astype(np.float64), near.shape[1]) + math.log10(independent))
        line_power = self._values[near, count + each[:, None]].mean(axis=1, dtype=np.float64)
        around = self.local_mean[each[:, None], near].mean(axis=1, dtype=np.float64)
        level = 10.0 * np.log10(np.clip(line_power / np.maximum(around, np.finfo(np.float64).tiny), 1.0, 1e12))
        depth = np.sqrt(power[best, each].astype(np.float64))
        orders = trials.orders[best]
        return [
            LineFamily(order, modulation * spectrum.mean, modulation, above, probability, tuple(lines), len(comb.sidebands))
            for order, modulation, above, probability, lines, spectrum in zip(
                orders.tolist(),
                depth.tolist(),
                level.tolist(),
                significance.tolist(),
                (orders[:, None] * trials.harmonics).tolist(),
                self.spectra,
                strict=True,
            )
        ]

    def _sums(self, trials: Trials, leading: int) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Return the scores of all lines and the power of a harmonic, both of shape (orders, spectra)."""
        total = np.zeros((len(trials.orders), len(self.spectra)), np.float32)
        groups = []
        for harmonic in range(trials.near.shape[1]):
            both = self._values.take(trials.near[:, harmonic, 0], axis=0)
            for line in range(1, trials.near.shape[2]):
                both += self._values.take(trials.near[:, harmonic, line], axis=0)
            total += both[:, : len(self.spectra)]
            groups.append(both[:, len(self.spectra) :])
        # A harmonic counts up to the leading one: a single line at a multiple belongs to another family.
        most = functools.reduce(np.maximum, groups[:leading])
        limited = [np.minimum(group, most) for group in groups]
        if len(groups) < MANY:
            return total, sum(limited[1:], limited[0]) / np.float32(len(groups))
        roots = [np.sqrt(group) for group in limited]
        return total, np.square(sum(roots[1:], roots[0]) / np.float32(len(groups)))


def _best_of(trials: Trials, total: npt.NDArray[np.float32], power: npt.NDArray[np.float32]) -> npt.NDArray[np.intp]:
    """Return the index of the order to report for each spectrum, shape (spectra,), from sums of shape (orders, spectra)."""
    within = (np.abs(trials.steps) <= trials.half)[:, None]
    # Near the end of the range, the slope of a line beyond it is no line.
    inside = within & (power >= maximum_filter1d(power, 2 * BEYOND + 1, axis=0))
    inside = np.where(inside.any(axis=0), inside, within)
    strong = inside & (total >= np.float32(0.9) * np.where(inside, total, np.float32(-1.0)).max(axis=0))
    first = np.argmax(np.where(strong, power, np.float32(-1.0)), axis=0)
    # The largest of three neighbours makes a plateau, in whose middle the line is.
    top = power[first, np.arange(power.shape[1])]
    after = (np.arange(len(power))[:, None] > first) & (power < np.float32(PLATEAU) * top)
    steps = np.where(after.any(axis=0), np.argmax(after, axis=0) - first - 1, 0)
    return np.asarray(first + steps // 2, np.intp)


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
    lines = tried[:, None, None] * harmonics[:, None] + np.asarray(comb.sidebands)
    near = np.clip(np.rint(lines / step).astype(np.int64), 1, values - 1)
    return Trials(harmonics, count, steps, tried, near, float(lines[count + BEYOND].max()))


def _largest_of_three(values: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return the largest of each value and its two neighbours in its row, shape (rows, values)."""
    largest: npt.NDArray[np.float32] = values.copy()
    np.maximum(largest[:, 1:], values[:, :-1], out=largest[:, 1:])
    np.maximum(largest[:, :-1], values[:, 1:], out=largest[:, :-1])
    return largest


def local_mean(power: npt.NDArray[Any], width: int) -> npt.NDArray[Any]:
    """Return the mean of exponentially distributed ``power``, shape (..., values), around each value, same shape.

    It follows from medians over ``width`` values, up to half of which may be lines. Medians of half-overlapping blocks are interpolated.
    """
    values = power.shape[-1]
    if values <= width:
        return np.asarray(np.broadcast_to(medians(power)[..., None], power.shape) / power.dtype.type(math.log(2.0)))
    half = max(1, width // 2)
    halves = values // half
    blocks = power[..., : halves * half].reshape(*power.shape[:-1], halves, half)
    means = medians(np.concatenate([blocks[..., :-1, :], blocks[..., 1:, :]], axis=-1)) / power.dtype.type(math.log(2.0))
    # From the middle of one block to that of the next, the mean rises linearly; beyond the first and the last it is constant.
    rise = np.diff(means, axis=-1)[..., None] * (np.arange(half) / half).astype(power.dtype)
    mean = np.empty_like(power)
    mean[..., :half], mean[..., (halves - 1) * half :] = means[..., :1], means[..., -1:]
    mean[..., half : (halves - 1) * half] = (means[..., :-1, None] + rise).reshape(*power.shape[:-1], -1)
    return mean


def log10_gamma_tail(total: npt.ArrayLike, count: int) -> Floats:
    """Return log10 of the probability that ``count`` exponential variables of mean 1 sum to more than each ``total``, same shape.

    It is exp(-t) times the sum of t^k / k! for k < count (Erlang distribution).
    """
    sums = np.asarray(total, np.float64)
    terms = np.arange(count) * np.log(np.maximum(sums, TINY))[..., None] - _log_factorials(count)
    top = terms.max(axis=-1)
    tail = (top + np.log(np.exp(terms - top[..., None]).sum(axis=-1)) - sums) / math.log(10.0)
    return np.asarray(np.where(sums > 0.0, tail, 0.0))


@functools.cache
def _log_factorials(count: int) -> Floats:
    return np.array([math.lgamma(j + 1.0) for j in range(count)])


def covered(spectrum: OrderSpectrum, lines: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return which values lie within the resolution of one of the ``lines`` [orders], shape (values,)."""
    middle = np.rint(np.asarray(lines, np.float64).ravel() / float(spectrum.orders[1])).astype(np.int64)
    near = (middle[:, None] + np.arange(-GUARD, GUARD + 1)).ravel()
    marked = np.zeros(len(spectrum.orders), np.bool_)
    marked[near[(near >= 0) & (near < len(marked))]] = True
    return marked
