"""The spectrum of a squared envelope over orders of the shaft, and how far a line stands out.

Antoni 2007, "Cyclic spectral analysis of rolling-element bearing signals: Facts and fictions", says why the squared
envelope is the quantity to look at; Randall and Antoni 2011, "Rolling element bearing diagnostics - A tutorial", how.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import fft

Floats = npt.NDArray[np.float64]

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
        return float(np.median(self.amplitude[first:last])) if last > first else 0.0

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
    return float(10.0 * np.log10(np.clip(ratio, 1e-12, 1e12)))


def ratio(value: float, reference: float) -> float:
    """Return a ratio of squared amplitudes, held within 120 dB; 0 where there is nothing to compare with."""
    return min(value / reference, 1e12) if reference > 0.0 else 0.0


def fitted_order(spectrum: OrderSpectrum, order: float, slip: float) -> float:
    """Return the order within ``slip`` (relative) of ``order`` whose first harmonics are largest together.

    Rollers slip a little, and pins at the pitch circle make them roll 0.2 % off the kinematic order. The product of the
    harmonics is compared, so that one strong foreign line does not decide.
    """
    candidates = order * (1.0 + slip * CANDIDATES)
    places = FITTED_HARMONICS[:, None] * candidates
    found = np.interp(places, spectrum.orders, spectrum.amplitude)
    return float(candidates[np.argmax(np.log(np.maximum(found, np.finfo(np.float64).tiny)).sum(axis=0))])


def comb(spectrum: OrderSpectrum, order: float, teeth: npt.ArrayLike) -> Comb:
    """Return the lines at ``teeth`` [orders] of a family whose fundamental is ``order``."""
    amplitude = float(np.median(spectrum.lines(teeth)))
    background = spectrum.background(float(np.max(teeth)))
    level = decibels(ratio(amplitude, background)) if amplitude > 0.0 and background > 0.0 else 0.0
    return Comb(order, amplitude, ratio(amplitude, spectrum.mean), level)
