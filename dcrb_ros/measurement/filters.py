"""Filters in second-order sections, fed stretch by stretch: the same bits for any block size.

Resonances and low-passes are made discrete by the bilinear transform, warped so that their own frequency is exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, cast

import numpy as np
import scipy  # whose parts are imported when they are first used

from dcrb_ros.measurement.designs import kept
from dcrb_ros.measurement.kernels import filtered
from dcrb_ros.runtime.arrays import Floats

PINK_LOWEST = 0.05
"""Lowest frequency at which pink noise falls as it should [Hz]; below it is white."""
PINK_PER_DECADE = 2
"""Poles of the pink filter per decade [-]; with two the density is within 0.3 dB of its law."""


class Filter:
    """A recursive filter for columns of samples; before the start the input is taken as zero."""

    def __init__(self, *cascade: Floats, columns: int = 2) -> None:
        """Prepare for sections in a row."""
        self._sections = np.concatenate(cascade)
        self._memory = np.zeros((len(self._sections), 2, columns))

    def feed(self, samples: Floats) -> Floats:
        """Filter ``samples`` of shape (samples, columns)."""
        return filtered(self._sections, self._memory, samples)


def resonance(frequency: float, damping: float, rate: float) -> Floats:
    """Return the sections of w^2 / (s^2 + 2 zeta w s + w^2): gain 1 at rest, 1/(2 zeta) at ``frequency`` [Hz]."""
    return _second_order(frequency, damping, rate, [0.0, 0.0, 1.0])


def transmissibility(frequency: float, damping: float, rate: float) -> Floats:
    """Return the sections of (2 zeta w s + w^2) / (s^2 + 2 zeta w s + w^2), what a mass on spring and damper takes of its base."""
    return _second_order(frequency, damping, rate, [0.0, 2.0 * damping, 1.0])


@kept
def _second_order(frequency: float, damping: float, rate: float, numerator: list[float]) -> Floats:
    """Return the section of a prototype of natural frequency 1 at a rate [Hz]."""
    tangent = math.tan(math.pi * frequency / rate)
    top, bottom = scipy.signal.bilinear(numerator, [1.0, 2.0 * damping, 1.0], fs=0.5 / tangent)
    section: Floats = np.concatenate([top, bottom])[None, :]
    return section


@kept
def side_by_side(bank: Sequence[Floats], shares: Sequence[float], straight: float) -> Floats:
    """Return the sections of a sum: ``shares`` of single sections, and ``straight`` of the signal itself.

    The zeros of the sum are the eigenvalues of A - B C / D of its modes as one system.
    """
    systems = [scipy.signal.tf2ss(section[0, :3], section[0, 3:]) for section in bank]
    a = scipy.linalg.block_diag(*(system[0] for system in systems))
    b = np.concatenate([system[1] for system in systems])
    c = np.concatenate([share * system[2] for share, system in zip(shares, systems, strict=True)], axis=1)
    gain = straight + sum(share * float(system[3][0, 0]) for share, system in zip(shares, systems, strict=True))
    # The stubs of zpk2sos know real zeros and poles only.
    zeros, poles = (cast(Any, scipy.linalg.eigvals(matrix)) for matrix in (a - b @ c / gain, a))
    sections: Floats = scipy.signal.zpk2sos(zeros, poles, gain)
    return sections


@kept
def low_pass(frequency: float, rate: float) -> Floats:
    """Return the sections of a second-order Butterworth low-pass, -3 dB at ``frequency`` [Hz]."""
    sections: Floats = scipy.signal.butter(2, frequency, fs=rate, output="sos")
    return sections


@kept
def high_pass(frequency: float, rate: float) -> Floats:
    """Return the sections of a first-order high-pass, -3 dB at ``frequency`` [Hz]."""
    sections: Floats = scipy.signal.butter(1, frequency, "highpass", fs=rate, output="sos")
    return sections


@kept
def band_of_noise(low: float, high: float, rate: float) -> Floats:
    """Return the sections of a band-pass from ``low`` to ``high`` [Hz] that makes noise of rms 1 out of noise of rms 1."""
    sections: Floats = scipy.signal.butter(2, [low, high], "bandpass", fs=rate, output="sos")
    sections[0, :3] /= math.sqrt(noise_gain(sections))
    return sections


def noise_gain(sections: Floats) -> float:
    """Return the power of filtered white noise of power 1, from the impulse response."""
    poles = scipy.signal.sos2zpk(sections)[1]
    settled = math.ceil(math.log(1e-9) / math.log(float(np.abs(poles).max())))
    impulse = np.zeros(settled)
    impulse[0] = 1.0
    return float(np.sum(scipy.signal.sosfilt(sections, impulse) ** 2))


@kept
def pink(rate: float) -> Floats:
    """Return the sections that make noise falling with 1/f in power, of density 1/sqrt(Hz) at 1 Hz, out of noise of rms 1.

    Poles and zeros alternate at equal distances of the logarithm of the frequency, a step of 20 dB per decade half of the
    way (Oustaloup et al. 2000, IEEE Trans. Circuits Syst. I 47(1), 25-39).
    """
    count = math.ceil(PINK_PER_DECADE * math.log10(0.5 * rate / PINK_LOWEST))
    ratio = (0.5 * rate / PINK_LOWEST) ** (1.0 / count)
    poles = 2.0 * math.pi * PINK_LOWEST * ratio ** (np.arange(count) + 0.25)
    zeros = poles * math.sqrt(ratio)
    zpk = scipy.signal.bilinear_zpk(-zeros, -poles, 1.0, fs=rate)
    sections: Floats = scipy.signal.zpk2sos(*zpk)
    _, at_one = scipy.signal.sosfreqz(sections, [1.0], fs=rate)
    # White noise of rms 1 has a one-sided density of sqrt(2/rate).
    sections[0, :3] /= float(np.abs(at_one[0])) * math.sqrt(2.0 / rate)
    return sections
