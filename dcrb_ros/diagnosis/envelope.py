"""Squared envelope of a band, its spectrum over orders of the shaft, and how far a line stands out.

Antoni 2007, "Cyclic spectral analysis of rolling-element bearing signals: Facts and fictions", says why the squared
envelope is the quantity to look at; Randall and Antoni 2011, "Rolling element bearing diagnostics - A tutorial", how.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import fft

Floats = npt.NDArray[np.float64]

BINS_PER_ORDER = 4
"""Angle bins per turn and highest order; 2 would be Nyquist's."""


class Line(NamedTuple):
    """A line of an order spectrum."""

    order: float
    """Where it was found [-]."""
    amplitude: float
    """Its amplitude, in the unit of the spectrum."""
    level: float
    """Amplitude over background [dB]."""


def squared_envelope(signal: npt.NDArray[Any], rate: int, band: tuple[float, float]) -> Floats:
    """Return the squared envelope of ``signal`` within ``band`` [Hz], summed over its columns [unit^2].

    The mean of a row is twice the power in the band. The first and last few periods of the band's lower edge wrap
    round into each other; leave them out.
    """
    samples = len(signal)
    axes = np.ascontiguousarray(np.asarray(signal, np.float64).reshape(samples, -1).T)
    spectrum = fft.rfft(axes) * (2.0 * _band_pass(fft.rfftfreq(samples, 1.0 / rate), band))
    analytic = fft.ifft(spectrum, samples)  # padded with the negative frequencies' zeros
    return np.asarray((analytic.real**2 + analytic.imag**2).sum(axis=0), np.float64)


def _band_pass(frequency: Floats, band: tuple[float, float]) -> Floats:
    """Return the gain of a band at frequencies [Hz] with raised-cosine edges a tenth of the lower edge wide."""
    low, high = band
    edge = 0.1 * low
    rise = np.clip((frequency - low + edge) / edge, 0.0, 1.0)
    fall = np.clip((high + edge - frequency) / edge, 0.0, 1.0)
    return np.asarray(np.sin(0.5 * math.pi * rise) ** 2 * np.sin(0.5 * math.pi * fall) ** 2, np.float64)


def per_turn(envelope: Floats, shaft_angle: npt.NDArray[Any], bins_per_turn: int) -> Floats:
    """Return the mean of ``envelope`` in angle bins of equal width; ``shaft_angle`` [rad] rises once unwrapped.

    Bins share the samples at their borders in proportion, which is an anti-alias filter that keeps the energy.
    """
    angle = np.maximum.accumulate(np.unwrap(np.asarray(shaft_angle, np.float64)))
    turns = (angle - angle[0]) / (2.0 * math.pi)
    borders = np.arange(math.floor(turns[-1] * bins_per_turn) + 1) / bins_per_turn
    middles = 0.5 * (envelope[1:] + envelope[:-1])
    energy = np.interp(borders, turns, np.concatenate([[0.0], np.cumsum(middles)]))
    ticks = np.interp(borders, turns, np.arange(len(turns), dtype=np.float64))
    return np.asarray(np.diff(energy) / np.diff(ticks), np.float64)


def order_spectrum(envelope: Floats, shaft_angle: npt.NDArray[Any], highest_order: float) -> tuple[Floats, Floats]:
    """Return orders [-] and one-sided amplitudes of ``envelope`` over the shaft's angle [rad], up to ``highest_order``.

    The amplitude at order 0 is the mean. A Hann window keeps a strong line out of its neighbourhood.
    """
    bins = math.ceil(BINS_PER_ORDER * highest_order)
    values = per_turn(envelope, shaft_angle, bins)
    window = np.hanning(len(values) + 1)[:-1]
    mean = float(values.mean())
    # Padding to twice the length halves the scalloping of a line between two orders to 0.4 dB.
    spectrum = fft.rfft((values - mean) * window, 2 * len(values)) * (2.0 / float(window.sum()))
    amplitude = np.asarray(np.abs(spectrum), np.float64)
    orders = np.arange(len(amplitude), dtype=np.float64) * (bins / (2.0 * len(values)))
    amplitude = amplitude / np.sinc(orders / bins)
    amplitude[0] = mean
    kept = orders <= highest_order
    return orders[kept], amplitude[kept]


def comb_order(orders: Floats, amplitude: Floats, order: float, *, search: float = 0.015, harmonics: int = 3) -> float:
    """Return the order within ``search`` (relative) of ``order`` whose first harmonics are largest together.

    Rollers slip a little, and pins at the pitch circle make them roll 0.2 % off the kinematic order. The product of the
    harmonics is compared, so that one strong foreign line does not decide.
    """
    candidates = order * (1.0 + search * np.linspace(-1.0, 1.0, 61))
    least = np.finfo(np.float64).tiny
    score = sum(np.log(np.maximum(np.interp(k * candidates, orders, amplitude), least)) for k in range(1, harmonics + 1))
    return float(candidates[np.argmax(score)])


def line_level(
    orders: Floats, amplitude: Floats, order: float, *, search: float = 0.015, background: float = 1.0, resolution: float = 0.0
) -> Line:
    """Return the largest line within ``search`` (relative) of ``order`` and its level over the background.

    The background is the median within ``background`` orders on either side. ``resolution`` [orders] is the least
    half-width searched.
    """
    half = max(search * order, resolution, 0.5 * float(orders[1] - orders[0]))
    first, last = np.searchsorted(orders, [order - half, order + half])
    if last <= first:
        return Line(order, 0.0, 0.0)
    peak = int(first + np.argmax(amplitude[first:last]))
    floor = float(np.median(amplitude[np.abs(orders - orders[peak]) <= max(background, half)]))
    top = float(amplitude[peak])
    level = 20.0 * math.log10(top / floor) if floor > 0.0 and top > 0.0 else 0.0
    return Line(float(orders[peak]), top, level)
