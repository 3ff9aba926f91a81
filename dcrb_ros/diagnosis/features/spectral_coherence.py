r"""The fast spectral coherence over orders of the shaft, and the fault lines of the enhanced envelope spectrum.

The spectral correlation $S(\alpha, f)$ is the correlation of the components at $f$ and $f - \alpha$. With the short-time Fourier transform
$X(i, f_k)$ in windows $w$ of $N_w$ samples every $R$ samples, referred to the middle of each window,

    S(alpha, f_k; p) = 1/(K |w|^2 F_s) sum_i X(i, f_k) X(i, f_(k-p))^* exp(-j 2 pi alpha t_i)

covers cyclic frequencies near $p \, \Delta f$, with $\Delta f = F_s / N_w$. The sum over p, divided by the sum of the window's
autocorrelation, $S = R_w(0) \sum_p S(\alpha, f; p) / \sum_p R_w(\alpha - p \Delta f)$, has them all (Antoni, Xin and Hamzaoui 2017, "Fast
computation of the spectral correlation", eqs. 20 to 27). Here $\alpha$ is an order: the products are resampled over the angle of the shaft
before their Fourier transform, so that a varying speed does not smear the lines (Abboud et al. 2015, "Order-frequency analysis of machine
signals"). The coherence is $\gamma = S(\alpha, f) / \sqrt{S(0, f) S(0, f - \alpha)}$, and the enhanced envelope spectrum is the mean of
$|\gamma|^2$ over f.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import fft

from dcrb_ros.diagnosis.features.family import FAULTS, SLIP, FeatureFamily, Windows, fault_orders
from dcrb_ros.diagnosis.line_search import local_mean
from dcrb_ros.schema.arguments import checked_arguments, number, numbers
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal

RESOLUTION = 800.0
"""Resolution of the carrier frequency in the features [Hz]."""
HARMONICS = 3
FRAMES = 4.0
"""Frames per period of the highest cyclic frequency [-]."""
STEADY = 1e-6
"""Distance from a frame at which it needs no interpolation, relative to that of two frames [-]."""
NEIGHBOURHOOD = 1.0
"""Width over which the local mean of the enhanced envelope spectrum is taken [orders]."""


class SpectralCoherence(NamedTuple):
    """Spectral coherence of a signal."""

    order: Floats
    """Cyclic order alpha, shape (orders,) [-]; the first is 0."""
    frequency: Floats
    """Carrier frequency f, shape (frequencies,) [Hz]."""
    coherence: npt.NDArray[np.complex64]
    """gamma, shape (frequencies, orders) [-]: 0 without a correlation, at most about 1; its phase is that of the modulation at turn 0."""

    @checked_arguments(low=number, high=number)
    def enhanced_envelope_spectrum(self, low: float = 0.0, high: float = math.inf) -> Floats:
        """Return the mean of ``|gamma|^2`` over the carriers from ``low`` to ``high`` [Hz], shape (orders,) [-].

        Raises
        ------
        Refusal
            There is no carrier between them.
        """
        inside = (self.frequency >= low) & (self.frequency <= high)
        if not inside.any():
            raise Refusal(f"no carrier lies within {low:g} .. {high:g} Hz: the spectrum has 0 .. {self.frequency[-1]:g} Hz")
        return np.asarray(np.mean(np.abs(self.coherence[inside]) ** 2, axis=0, dtype=np.float64), np.float64)


@checked_arguments(signal=numbers, turns=numbers, highest_order=number)
def spectral_coherence(
    signal: npt.ArrayLike, sampling_rate: float, turns: npt.ArrayLike, highest_order: float, *, resolution: float | None = None
) -> SpectralCoherence:
    """Return the fast spectral coherence of a signal up to a cyclic order.

    With the spectral correlation S(alpha, f) of the components at f and f - alpha, it is

        gamma(alpha, f) = S(alpha, f) / sqrt(S(0, f) S(0, f - alpha))

    Source: Antoni, Xin and Hamzaoui 2017, "Fast computation of the spectral correlation"; orders as in Abboud et al. 2015.

    Parameters
    ----------
    signal
        Shape (samples,) [m/s^2].
    sampling_rate
        Sampling rate [Hz].
    turns
        Turns of the shaft, rising, shape (samples,) [-]. With ``numpy.arange(samples) / sampling_rate`` orders are frequencies in Hz.
    highest_order
        Highest cyclic order [-].
    resolution
        Resolution of the carrier frequency [Hz]; by default 800, or a sixteenth of a sampling rate below 12.8 kHz.

    Returns
    -------
    SpectralCoherence
        Cyclic orders [-], carrier frequencies [Hz] and coherence, shape (frequencies, orders) [-]. A line halfway between two orders is
        lower by 15 %, the loss of a Hann window.

    Raises
    ------
    Refusal
        Shapes that differ, samples that are not finite, turns that fall, a signal of fewer than 16 windows, a resolution outside
        0 .. a sixteenth of the sampling rate, or an order of a quarter of the sampling rate or more.

    Examples
    --------
    Noise modulated 100 times a second, (1 + 0.8 cos) n, has a coherence of 0.8 / (1 + 0.8^2 / 2) = 0.61 there:

    >>> import numpy as np
    >>> import dcrb_ros
    >>> t = np.arange(51200) / 12800.0
    >>> noise = np.random.default_rng(1).standard_normal(len(t))
    >>> found = dcrb_ros.spectral_coherence((1.0 + 0.8 * np.cos(2 * np.pi * 100 * t)) * noise, 12800, t, 150.0)
    >>> line = np.abs(found.order - 100.0).argmin()
    >>> bool(abs(np.abs(found.coherence[2:-2, line]).mean() - 0.61) < 0.05)
    True
    """
    values, angle, length, fastest = _checked(signal, sampling_rate, turns, highest_order, resolution)
    hop = max(1, min(length // 4, math.floor(sampling_rate / (FRAMES * fastest))))
    window = np.hanning(length + 1)[:-1]
    frames = np.lib.stride_tricks.sliding_window_view(values, length)[::hop] * window
    transform = fft.rfft(frames.astype(np.float32), axis=1)
    middle = np.arange(len(frames)) * hop + length // 2
    spacing = sampling_rate / length
    steps = math.ceil(fastest / spacing) + 1
    spectrum, orders = _over_orders(_summed_products(transform, steps), angle[middle], highest_order)
    alpha = orders * (float(angle[-1] - angle[0]) * sampling_rate / (len(values) - 1))
    correlation = _autocorrelation(window, alpha / sampling_rate, np.arange(steps) / length)
    summed = spectrum.T * (correlation[0, 0] / correlation.sum(axis=1)).astype(np.float32)
    power = np.maximum(np.mean(np.abs(transform) ** 2, axis=0, dtype=np.float64), np.finfo(np.float32).tiny)
    frequency = np.arange(transform.shape[1]) * spacing
    shifted = np.interp(np.abs(frequency[:, None] - alpha), frequency, power)
    coherence = summed / np.sqrt(power[:, None] * shifted)
    return SpectralCoherence(orders, np.asarray(frequency, np.float64), coherence.astype(np.complex64))


def _checked(
    signal: npt.ArrayLike, sampling_rate: float, turns: npt.ArrayLike, highest_order: float, resolution: float | None
) -> tuple[Floats, Floats, int, float]:
    """Return signal and turns, shape (samples,), the samples of a window, and the highest cyclic frequency [Hz].

    Raises:
        Refusal: see `spectral_coherence`.
    """
    rate = finite_number("sampling_rate =", sampling_rate, "Hz")
    width = min(RESOLUTION, rate / 16.0) if resolution is None else finite_number("resolution =", resolution, "Hz")
    if not 0.0 < width <= rate / 16.0:
        raise Refusal(f"resolution = {width:g} Hz is outside 0 .. {rate / 16.0:g} Hz, a sixteenth of the sampling rate")
    values, angle = np.asarray(signal, np.float64), np.asarray(turns, np.float64)
    if values.ndim != 1 or values.shape != angle.shape:
        raise Refusal(f"a signal of shape {values.shape} and turns of shape {angle.shape} do not fit: give (samples,) and (samples,)")
    length = 2 * max(8, round(0.5 * sampling_rate / width))
    if not np.isfinite(values).all():
        raise Refusal("the signal has values that are not finite: leave these samples out, and take the stretch before or after them")
    if len(values) < 16 * length:
        raise Refusal(f"{len(values)} samples are too few for a resolution of {width:g} Hz: give at least {16 * length}")
    if not (angle[-1] > angle[0] and (np.diff(angle) >= 0.0).all()):
        raise Refusal("the turns of the shaft must rise from the first sample to the last: leave out standstill and reversal")
    fastest = highest_order * float(np.diff(angle[:: max(1, length // 2)]).max()) / max(1, length // 2) * sampling_rate
    if not 0.0 < fastest < 0.25 * sampling_rate:
        raise Refusal(f"a cyclic order of {highest_order:g} reaches {fastest:.4g} Hz: give one below {0.25 * sampling_rate:.4g} Hz")
    return values, angle, length, fastest


def _summed_products(transform: npt.NDArray[np.complexfloating[Any, Any]], steps: int) -> npt.NDArray[np.complex64]:
    """Return the sum over p < ``steps`` of X(i, f_k) X(i, f_(k-p))^*, shape (frames, carriers) [(m/s^2)^2].

    The Fourier transform of the sum is the sum of the Fourier transforms.
    """
    products = np.zeros(transform.shape, np.complex64)
    for p in range(steps):
        # Referred to the middle of the window, half its length later, line k has the sign (-1)^k.
        products[:, p:] += (1 - 2 * (p % 2)) * transform[:, p:] * transform[:, : transform.shape[1] - p].conj()
    return products


def _over_orders(products: npt.NDArray[np.complex64], angle: Floats, highest: float) -> tuple[npt.NDArray[np.complex64], Floats]:
    """Return the Fourier coefficients of products of shape (frames, carriers) over the angle [turns], up to an order, and the orders."""
    count = len(products)
    even = np.linspace(angle[0], angle[-1], count)
    position = np.interp(even, angle, np.arange(count, dtype=np.float64))
    position = np.where(np.abs(position - np.rint(position)) < STEADY, np.rint(position), position)
    before = np.minimum(position.astype(np.int64), count - 2)
    share = position - before
    weight = share.astype(np.float32)[:, None]
    resampled = products[before] * (1.0 - weight) + products[before + 1] * weight
    taper = np.hanning(count + 1)[:-1]
    taper /= taper.sum()
    resampled *= taper.astype(np.float32)[:, None]
    turns = float(angle[-1] - angle[0]) * count / (count - 1)
    wanted = min(count // 2, math.ceil(highest * turns) + 1)
    orders = np.arange(wanted) / turns
    spectrum = fft.fft(resampled, axis=0)[:wanted]
    gain = _interpolation_gain(orders, share, np.diff(angle)[before], taper)
    spectrum *= (np.exp(-2j * math.pi * orders * angle[0]) / gain).astype(np.complex64)[:, None]
    return spectrum, orders


def _interpolation_gain(orders: Floats, share: Floats, step: Floats, taper: Floats) -> Floats:
    """Return by how much linear interpolation attenuates each order, shape (orders,) [-].

    A line exp(j 2 pi a theta) between two frames, ``step`` [turns] apart, becomes (1 - s) exp(-j a s) + s exp(j a (1 - s)) of itself at the
    ``share`` s of the way; the mean over the frames counts, 1 at constant speed, at which the frames need no interpolation.
    """
    if not (share % 1.0).any():
        return np.ones(len(orders))
    some = np.linspace(0.0, float(orders[-1]), 17)
    way = 2.0 * math.pi * some[:, None] * step
    gain = ((1.0 - share) * np.cos(way * share) + share * np.cos(way * (1.0 - share))) @ taper
    return np.asarray(np.interp(orders, some, gain), np.float64)


def _autocorrelation(window: Floats, alpha: Floats, shifts: Floats) -> Floats:
    """Return R_w(alpha - shift), the Fourier transform of the squared window about its middle, shape (alphas, shifts); per sample."""
    position = np.arange(len(window)) - len(window) // 2
    some = np.linspace(-shifts[-1], alpha[-1], 16 * len(shifts) + 17)
    values = np.cos(2.0 * math.pi * some[:, None] * position) @ window**2
    return np.asarray(np.interp(alpha[:, None] - shifts, some, values), np.float64)


def compute(windows: Windows) -> Floats:
    """Return 10 lg of the lines of each fault in the enhanced envelope spectrum over its local mean, shape (windows, 4) [dB]."""
    fundamentals = fault_orders(windows.orders)
    levels = np.zeros((windows.shape[0], len(FAULTS)))
    for k, (signal, turns) in enumerate(zip(windows.acceleration, windows.turns, strict=True)):
        mean_frequency = float(windows.shaft_frequency[k])
        highest = min(HARMONICS * max(fundamentals.values()) * (1.0 + SLIP) + NEIGHBOURHOOD, 0.2 * windows.rate / mean_frequency)
        coherence = spectral_coherence(signal, windows.rate, turns, highest)
        spectrum, spacing = coherence.enhanced_envelope_spectrum(), float(coherence.order[1])
        mean = local_mean(spectrum, max(32, math.ceil(NEIGHBOURHOOD / spacing)))
        ratio = spectrum / np.maximum(mean, np.finfo(np.float64).tiny)
        for n, order in enumerate(fundamentals.values()):
            levels[k, n] = 10.0 * math.log10(_strength(ratio, order / spacing))
    return levels


def _strength(ratio: Floats, fundamental: float) -> float:
    """Return the mean over the harmonics of the largest ratio within `SLIP` of each; ``place`` is the fundamental [lines]."""
    largest = []
    for harmonic in range(1, HARMONICS + 1):
        first = int(harmonic * fundamental * (1.0 - SLIP))
        last = math.ceil(harmonic * fundamental * (1.0 + SLIP)) + 1
        if first >= len(ratio):
            break
        largest.append(float(ratio[max(1, first) : last].max(initial=1e-3)))
    return float(np.mean(largest)) if largest else 1.0


SPECTRAL_COHERENCE = FeatureFamily("spectral_coherence", lambda _: tuple(f"coherence_{fault}" for fault in FAULTS), compute)
