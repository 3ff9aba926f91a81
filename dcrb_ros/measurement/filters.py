"""Recursive filters in second-order sections; the result does not depend on how the samples are split into blocks.

Resonances and low-passes are discretised by the bilinear transform, prewarped at their own frequency.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, cast

import numpy as np
import scipy  # its subpackages are imported on first use

from dcrb_ros.measurement.filter_cache import cached_on_disk
from dcrb_ros.schema.arrays import Floats

PINK_LOWEST = 0.05
"""Corner below which pink noise is white [Hz]."""
PINK_PER_DECADE = 2
"""Poles of the pink filter per decade [-]; two keep the density within 0.3 dB of 1/f from 0.2 Hz to 0.2 of the rate."""
HIGHEST_SHARE = 0.45
"""Highest frequency of a filter at the step rate, as a share of that rate [-]."""


class Filter:
    """A recursive filter for columns of samples; the input before the start is zero."""

    def __init__(self, *cascade: Floats, columns: int = 2) -> None:
        """Prepare for second-order sections in series, each array of shape (sections, 6)."""
        self._sections = np.concatenate(cascade)
        self._memory = np.zeros((len(self._sections), 2, columns))

    def continue_from(self, inputs: Floats, outputs: Floats) -> None:
        """Continue a filter of one section after its last two inputs and outputs, each of shape (2, columns)."""
        ((_, b1, b2, _, a1, a2),) = self._sections
        self._memory[0, 1] = b2 * inputs[1] - a2 * outputs[1]
        self._memory[0, 0] = b1 * inputs[1] - a1 * outputs[1] + b2 * inputs[0] - a2 * outputs[0]

    def process(self, samples: Floats) -> Floats:
        """Return ``samples``, shape (samples, columns), after the filter."""
        # The configuration imports this module for its limits, and numba takes longer to load than anything else.
        from dcrb_ros.measurement.kernels import filtered

        return filtered(self._sections, self._memory, samples)


def above_step_rate(key: str, frequency: float, step_rate: int) -> Iterator[str]:
    """Yield a sentence if a filter with a frequency [Hz], given by a parameter, cannot run at a step rate [Hz]."""
    highest = HIGHEST_SHARE * step_rate
    if frequency > highest:
        yield f"{key} = {frequency:g} Hz is above {highest:g} Hz, {HIGHEST_SHARE:g} of the step rate: give less or a shorter step"


def resonance(frequency: float, damping: float, rate: float) -> Floats:
    """Return the sections of w^2 / (s^2 + 2 zeta w s + w^2): gain 1 at rest, 1/(2 zeta) at ``frequency`` [Hz]."""
    return _second_order(frequency, damping, rate, [0.0, 0.0, 1.0])


def transmissibility(frequency: float, damping: float, rate: float) -> Floats:
    """Return the sections of (2 zeta w s + w^2) / (s^2 + 2 zeta w s + w^2), the transmissibility of a base-excited oscillator."""
    return _second_order(frequency, damping, rate, [0.0, 2.0 * damping, 1.0])


@cached_on_disk
def pole_zero_pair(pole: tuple[float, float], zero: tuple[float, float], rate: float) -> Floats:
    """Return the section (s^2/z^2 + 2 a s/z + 1) / (s^2/p^2 + 2 b s/p + 1) of a pair of poles and one of zeros, shape (1, 6).

    Each pair has a frequency [Hz] and a damping ratio [-]. The gain is 1 at rest and (p/z)^2 far above both.
    """
    top, bottom = (
        [math.tan(math.pi * frequency / rate) ** -2, 2.0 * damping / math.tan(math.pi * frequency / rate), 1.0]
        for frequency, damping in (zero, pole)
    )
    section: Floats = np.concatenate(scipy.signal.bilinear(top, bottom, fs=0.5))[None, :]
    return section


@cached_on_disk
def _second_order(frequency: float, damping: float, rate: float, numerator: list[float]) -> Floats:
    """Return the section of a prototype with natural frequency 1, moved to ``frequency`` at a rate [Hz], shape (1, 6)."""
    tangent = math.tan(math.pi * frequency / rate)
    top, bottom = scipy.signal.bilinear(numerator, [1.0, 2.0 * damping, 1.0], fs=0.5 / tangent)
    section: Floats = np.concatenate([top, bottom])[None, :]
    return section


@cached_on_disk
def side_by_side(bank: Sequence[Floats], shares: Sequence[float], straight: float) -> Floats:
    """Return the sections in series that equal ``straight`` times the signal plus ``shares`` times each section of a bank in parallel.

    The zeros of the sum are the eigenvalues of A - B C / D of its state space.
    """
    systems = [scipy.signal.tf2ss(section[0, :3], section[0, 3:]) for section in bank]
    a = scipy.linalg.block_diag(*(system[0] for system in systems))
    b = np.concatenate([system[1] for system in systems])
    c = np.concatenate([share * system[2] for share, system in zip(shares, systems, strict=True)], axis=1)
    gain = straight + sum(share * float(system[3][0, 0]) for share, system in zip(shares, systems, strict=True))
    # The type stubs of zpk2sos allow only real zeros and poles.
    zeros, poles = (cast(Any, scipy.linalg.eigvals(matrix)) for matrix in (a - b @ c / gain, a))
    sections: Floats = scipy.signal.zpk2sos(zeros, poles, gain)
    return sections


@cached_on_disk
def low_pass(frequency: float, rate: float) -> Floats:
    """Return the sections of a second-order Butterworth low-pass, -3 dB at ``frequency`` [Hz]."""
    sections: Floats = scipy.signal.butter(2, frequency, fs=rate, output="sos")
    return sections


@cached_on_disk
def high_pass(frequency: float, rate: float) -> Floats:
    """Return the sections of a first-order high-pass, -3 dB at ``frequency`` [Hz]."""
    sections: Floats = scipy.signal.butter(1, frequency, "highpass", fs=rate, output="sos")
    return sections


@cached_on_disk
def band_of_noise(low: float, high: float, rate: float) -> Floats:
    """Return the sections of a band-pass from ``low`` to ``high`` [Hz] that turns white noise of rms 1 into noise of rms 1."""
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


@cached_on_disk
def pink(rate: float) -> Floats:
    """Return the sections that turn white noise of rms 1 into 1/f noise with a density of 1/sqrt(Hz) at 1 Hz.

    Poles and zeros alternate at equal intervals of the logarithm of the frequency, so that the gain falls by 20 dB per decade on half
    of the way (Oustaloup et al. 2000, IEEE Trans. Circuits Syst. I 47(1), 25-39).
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
