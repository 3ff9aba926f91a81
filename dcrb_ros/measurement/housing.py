"""The response of a housing with many overlapping modes, drawn once per machine, and changed by every mounting of a bearing."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dcrb_ros.measurement.filter_cache import cached_at_start
from dcrb_ros.measurement.filters import HIGHEST_SHARE, Filter, resonance
from dcrb_ros.measurement.housing_priors import PRIORS, HousingName
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.arrays import Floats

FIRST_HOUSINGS = 8
"""Impulse responses of a process that are cached on disk [-]: two for each box of a bogie."""
DURATION = 0.1
"""Length of an impulse response [s]."""
HIGHEST_MODE = 40000.0
"""Frequency up to which modes are drawn [Hz]."""
LEAST_STEP_RATE = 80000
"""Lowest step rate of a housing [Hz]: 0.45 of it is twice the typical frequency of the ring in its seat."""
SEAT_DAMPING = 0.5
"""Damping ratio of the ring in its seat [-]."""
REFERENCE = 1000.0
"""Frequency at which densities, losses and participations are given [Hz]."""
FADED = 0.125
"""Share of the impulse response that is faded out at its end [-]."""
SMOOTHING = 2.0 ** (1.0 / 6.0)
"""Half a third octave [-]."""


class DenseModes(NamedTuple):
    """Modes of a housing, in the order of their frequencies; X and Y share frequencies and losses."""

    frequency: Floats
    """Natural frequencies, shape (modes,) [Hz]."""
    loss: Floats
    """Loss factors, twice the damping ratios, shape (modes,) [-]."""
    participation: Floats
    """Participation factors in X and Y, of either sign, shape (2, modes) [-]."""
    seat: float
    """Natural frequency of the ring in its seat [Hz]."""


def dense_modes(housing: HousingName, stream: str, seed: int, lowest: float = 0.0, mounting: int = 0) -> DenseModes:
    r"""Return the modes of a housing above ``lowest`` [Hz], drawn by a seed from the random numbers of a ``stream``.

    One frequency is drawn uniformly in each unit of the integral of the modal density, so that levels repel:

    .. math:: n(f) = n_1 (f/f_1)^a, \quad \eta(f) = \eta_1 (f/f_1)^{-b}, \quad
              \gamma_k = \frac{g (f_k/f_1)^\rho}{\sqrt{1 + f_k/f_1}} \xi_k, \quad \xi_k \sim N(0, 1), \quad f_1 = 1 \text{ kHz} .

    A ``mounting`` other than 0 is a seed of :math:`\zeta_k \sim N(0, 1)`, and :math:`\sqrt{c}\,\xi_k + \sqrt{1 - c}\,\zeta_k` takes the
    place of :math:`\xi_k`, so that c is the correlation of two mountings. Another step rate changes none of these values.
    """
    prior, random = PRIORS[housing], random_stream(seed, stream)
    density, loss, first, participation, rise, seat = (
        quantity.drawn(random) for quantity in (prior.density, prior.loss, prior.first, prior.participation, prior.rise, prior.seat)
    )
    power = prior.growth + 1.0
    start, end = (max(edge / REFERENCE, 0.0) ** power for edge in (max(first, lowest), HIGHEST_MODE))
    units = density * REFERENCE / power
    count = math.floor(units * (end - start))
    places = np.arange(count) + random_stream(seed, f"{stream} frequencies").random(count)
    ratio = (start + places / units) ** (1.0 / power)
    normal = np.stack([random_stream(seed, f"{stream} {axis}").standard_normal(count) for axis in "xy"])
    if mounting:
        mounted = np.stack([random_stream(seed, f"{stream} {axis} {mounting}").standard_normal(count) for axis in "xy"])
        normal = math.sqrt(prior.mounting) * normal + math.sqrt(1.0 - prior.mounting) * mounted
    scale = participation * ratio**rise / np.sqrt(1.0 + ratio)
    return DenseModes(REFERENCE * ratio, loss * ratio**-prior.fall, scale * normal, seat)


def seat_sections(modes: DenseModes, rate: float) -> Floats:
    """Return the low-pass of the ring in its seat as second-order sections at a rate [Hz]."""
    return resonance(min(modes.seat, HIGHEST_SHARE * rate), SEAT_DAMPING, rate)


@cached_at_start(FIRST_HOUSINGS)
def impulse_response(modes: DenseModes, rate: float, direct: Floats) -> Floats:
    r"""Return the causal impulse response of a housing at a rate [Hz], shape (2, taps).

    .. math:: H(s) = \Big[D(s) + \sum_k \gamma_k \frac{s^2}{s^2 + \eta_k \omega_k s + \omega_k^2}\Big]
              \frac{\omega_j^2}{s^2 + \omega_j s + \omega_j^2} ,

    with the impulse response ``direct``, shape (2, taps), of D(s): a single 1 at the start for the rigid mass line. The modes are
    discretised by the bilinear transform with their frequency, width and peak at every rate.
    """
    from dcrb_ros.measurement.kernels import add_modes  # importing numba takes long

    known = modes.frequency < HIGHEST_SHARE * rate
    angle = math.pi * modes.frequency[known] / rate
    # The bilinear transform compresses the width of a mode by sin(2x)/(2x).
    stretch = 2.0 * angle / np.sin(2.0 * angle)
    response = np.ascontiguousarray(direct, dtype=float).copy()
    add_modes(np.tan(angle), modes.loss[known] * stretch, modes.participation[:, known] * stretch, response)
    return _faded(Filter(seat_sections(modes, rate)).process(np.ascontiguousarray(response.T)).T)


def unit_impulse(rate: float) -> Floats:
    """Return an impulse of one step in both axes at a rate [Hz], shape (2, taps)."""
    impulse = np.zeros((2, round(DURATION * rate)))
    impulse[:, 0] = 1.0
    return impulse


def flattened(response: Floats) -> Floats:
    """Return an impulse response, shape (taps,), divided by its third-octave envelope of minimum phase: fine structure and decay remain."""
    size = 4 << (len(response) - 1).bit_length()
    spectrum = np.fft.rfft(response, size)
    bins = np.arange(len(spectrum))
    power = np.concatenate([[0.0], np.cumsum(np.abs(spectrum) ** 2)])
    low, high = np.floor(bins / SMOOTHING).astype(int), np.minimum(np.ceil(bins * SMOOTHING).astype(int), bins[-1]) + 1
    log_envelope = 0.5 * np.log((power[high] - power[low]) / (high - low))
    # The cepstrum of a minimum phase is causal: its negative times are folded onto the positive ones.
    cepstrum = np.fft.irfft(log_envelope, size)
    cepstrum[1 : size // 2] *= 2.0
    cepstrum[size // 2 + 1 :] = 0.0
    return _faded(np.fft.irfft(spectrum / np.exp(np.fft.rfft(cepstrum)), size)[: len(response)])


def _faded(response: Floats) -> Floats:
    """Return a response, shape (..., taps), whose end falls linearly to zero."""
    faded: Floats = response.copy()
    count = round(FADED * faded.shape[-1])
    faded[..., -count:] *= np.linspace(1.0, 0.0, count)
    return faded
