"""The spectrum of a squared envelope over orders of the shaft, and how far a line stands out.

Antoni 2007, "Cyclic spectral analysis of rolling-element bearing signals: Facts and fictions", says why the squared
envelope is the quantity to look at; Randall and Antoni 2011, "Rolling element bearing diagnostics - A tutorial", how.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import fft

Floats = npt.NDArray[np.float64]

SMALLEST = np.finfo(np.float64).tiny
CANDIDATES = np.linspace(-1.0, 1.0, 41)
"""Fundamentals tried, as shares of the tolerance for slip."""
FITTED_HARMONICS = np.array([1.0, 2.0, 3.0])
"""Harmonics that a fundamental is fitted to; later ones are too faint to trust."""
NEAR = np.arange(-2, 3)
"""Steps of a spectrum padded to twice its length that the resolution reaches to."""
BESIDE = 0.3
"""Orders beyond the last line of a family that its background is taken from [-]."""
FLOOR_FROM = 0.3
"""Order from which the background is taken [-]: below it lies what changes over the window."""


def median(values: npt.NDArray[Any]) -> Any:
    """Return what `numpy.median` does of numbers, bit by bit, in a fifth of its time: that looks for a NaN and selects three times."""
    middle = len(values) // 2
    parted = np.partition(values, middle)
    return parted[middle] if len(values) % 2 else (parted[:middle].max() + parted[middle]) / 2


class OrderSpectrum(NamedTuple):
    """Squared envelope of one band over orders."""

    orders: Floats
    """Orders of the shaft, equally spaced from 0 [-]."""
    amplitude: npt.NDArray[np.float32]
    """One-sided amplitudes [unit^2]."""
    mean: float
    """Mean of the squared envelope: twice the power in the band [unit^2]."""

    def background(self, highest: float) -> float:
        """Return the median amplitude up to the ``highest`` order [unit^2]: a spectrum of impacts falls with the order."""
        first, last = np.searchsorted(self.orders, [FLOOR_FROM, highest + BESIDE])
        return float(median(self.amplitude[first:last])) if last > first else 0.0

    def lines(self, orders: npt.ArrayLike) -> Floats:
        """Return the largest amplitude within the resolution of each of ``orders`` [unit^2]."""
        middle = np.rint(np.asarray(orders) / self.orders[1]).astype(np.int64)
        near = np.clip(middle[:, None] + NEAR, 1, len(self.amplitude) - 1)
        return np.asarray(self.amplitude[near].max(axis=1), np.float64)


class Comb(NamedTuple):
    """A family of lines as one, by its median, which a single foreign line cannot move."""

    order: float
    """Fundamental as found [-]."""
    amplitude: float
    """Amplitude in the squared envelope [unit^2]."""
    depth: float
    """Amplitude over the mean squared envelope: 0 without modulation, towards 2 for sharp strikes [-]."""
    level: float
    """Amplitude over the background [dB]."""


NO_COMB = Comb(0.0, 0.0, 0.0, 0.0)


def order_spectra(envelopes: npt.NDArray[np.floating], missing: npt.NDArray[np.bool_], bins_per_turn: float) -> list[OrderSpectrum]:
    """Return the spectrum of each row of squared envelopes over ``bins_per_turn``; ``missing`` bins take their row's mean.

    A Hann window keeps a strong line out of its neighbourhood, padding to twice the length halves the scalloping of a line
    between two orders to 0.4 dB, so that two orders' steps are the resolution.
    """
    bins = envelopes.shape[1]
    known = envelopes[:, ~missing] if missing.any() else envelopes
    means = known.mean(axis=1, dtype=np.float64) if known.shape[1] else np.zeros(len(envelopes))
    window = np.where(missing, 0.0, np.hanning(bins + 1)[:-1]).astype(np.float32)
    values = (envelopes - means.astype(np.float32)[:, None]) * window
    length = fft.next_fast_len(2 * bins, real=True)
    amplitude = np.abs(fft.rfft(values, length, axis=1)) * np.float32(2.0 / (float(window.sum()) or 1.0))
    orders = np.arange(amplitude.shape[1]) * (bins_per_turn / length)
    amplitude /= np.sinc(orders / bins_per_turn).astype(np.float32)  # what averaging within a bin took
    return [OrderSpectrum(orders, row, float(mean)) for row, mean in zip(amplitude, means, strict=True)]


def decibels(ratio: float) -> float:
    """Return a ratio of squared amplitudes [dB], held within 120 dB."""
    return float(10.0 * np.log10(min(max(ratio, 1e-12), 1e12)))


def ratio(value: float, reference: float) -> float:
    """Return a ratio of squared amplitudes, held within 120 dB; 0 where there is nothing to compare with."""
    return min(value / reference, 1e12) if reference > 0.0 else 0.0


def fitted_orders(spectrum: OrderSpectrum, orders: npt.ArrayLike, slip: float) -> Floats:
    """Return for each of ``orders`` the one within ``slip`` (relative) of it whose first harmonics are largest together.

    Rollers slip a little, and pins at the pitch circle make them roll 0.2 % off the kinematic order. The product of the
    harmonics is compared, so that one strong foreign line does not decide.
    """
    candidates = np.multiply.outer(np.asarray(orders, np.float64), 1.0 + slip * CANDIDATES)
    found = np.interp(np.multiply.outer(FITTED_HARMONICS, candidates), spectrum.orders, spectrum.amplitude)
    best = np.argmax(np.log(np.maximum(found, SMALLEST)).sum(axis=0), axis=1)
    return np.asarray(candidates[np.arange(len(best)), best], np.float64)


def combs(spectrum: OrderSpectrum, families: Sequence[tuple[float, Floats]]) -> list[Comb]:
    """Return each family of lines, given by its fundamental and its teeth [orders]."""
    lines, end = spectrum.lines(np.concatenate([teeth for _, teeth in families])), 0
    found = []
    for order, teeth in families:
        begin, end = end, end + len(teeth)
        found.append(_comb(order, float(median(lines[begin:end])), spectrum.background(float(teeth.max())), spectrum.mean))
    return found


def _comb(order: float, amplitude: float, background: float, mean: float) -> Comb:
    level = decibels(ratio(amplitude, background)) if amplitude > 0.0 and background > 0.0 else 0.0
    return Comb(order, amplitude, ratio(amplitude, mean), level)
