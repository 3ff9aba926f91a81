"""Spectra by Welch's method, in narrow bins for the estimation and in third octaves for the eye."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dcrb_ros.diagnosis.demodulation import NYQUIST_SHARE
from dcrb_ros.diagnosis.features.band_levels import levels, middles
from dcrb_ros.schema.arrays import Floats

RESOLUTION = 3.125
"""Distance of the lines of a spectrum [Hz]: a mode of 1 % damping at 500 Hz is 10 Hz wide."""
BINS_PER_OCTAVE = 48
"""Bins of the estimation [-]: 1.5 %, narrower than a mode of 1 % damping."""
LOWEST = 5.0
"""Lowest frequency of the bins [Hz]."""
FEWEST_LENGTHS = 4.4
"""Length of a signal over that of its windows [-], with which 7 overlap: signals of 2 s and more have equal windows at every rate."""
HIGHEST_SHARE = 0.4
"""Highest frequency over the sampling rate [-]: the pass band of the anti-alias filters."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """One-sided power density of a signal."""

    frequency: Floats
    """Shape (lines,) [Hz]."""
    density: Floats
    """Shape (lines,) [(m/s^2)^2/Hz]."""
    averages: float
    """Number of independent averages [-]; the variance of the logarithm is its inverse."""


def power_density(signal: Floats, rate: int) -> Spectrum:
    """Return the power density by Welch's method (1967, IEEE Trans. Audio Electroacoust. 15(2), 70-73): Hann windows that overlap by half.

    Half of the overlapping windows and 9/11 of their number are independent (Welch 1967, eq. 17, for a Hann window).
    """
    from scipy.signal import welch

    length = 1 << round(math.log2(rate / RESOLUTION))
    while len(signal) < FEWEST_LENGTHS * length and length > 256:
        length //= 2
    frequency, density = welch(signal, rate, nperseg=length)
    windows = 1 + (len(signal) - length) // (length // 2)
    return Spectrum(frequency, np.maximum(density, np.finfo(np.float64).tiny), max(1.0, windows * 9.0 / 11.0))


@dataclass(frozen=True, eq=False)
class Binned:
    """A spectrum in bins of equal width on a logarithmic frequency axis."""

    frequency: Floats
    """Middles of the bins, shape (bins,) [Hz]."""
    level: Floats
    """Mean of the natural logarithm of the density in each bin, shape (bins,); a line alone counts little in it."""
    variance: Floats
    """Its variance by chance, shape (bins,)."""


def binned(spectrum: Spectrum, rate: int) -> Binned:
    """Return a spectrum in bins of 1/48 octave, wider at low frequencies where the spectrum has fewer lines.

    Neighbouring lines of a Hann window have powers correlated by 4/9, so that m lines are worth m/1.9. The mean logarithm of an average of
    K powers is 1/(2K) below the logarithm of their mean.
    """
    used = (spectrum.frequency >= LOWEST) & (spectrum.frequency <= HIGHEST_SHARE * rate)
    frequency, logarithm = spectrum.frequency[used], np.log(spectrum.density[used])
    bins = np.floor(np.log2(frequency / LOWEST) * BINS_PER_OCTAVE).astype(int)
    _, number, count = np.unique(bins, return_inverse=True, return_counts=True)
    middle = np.bincount(number, frequency) / count
    level = np.bincount(number, logarithm) / count + 0.5 / spectrum.averages
    return Binned(middle, level, 1.0 / (spectrum.averages * np.maximum(1.0, count / 1.9)))


def third_octaves(spectrum: Spectrum, rate: int) -> tuple[Floats, Floats]:
    """Return the mid-band frequencies [Hz] and 10 lg of the mean square in each third octave over 1 (m/s^2)^2, shapes (bands,) [dB]."""
    spacing = float(spectrum.frequency[1])
    return middles(rate), levels(np.concatenate([[0.0], np.cumsum(spectrum.density) * spacing]), spacing, rate)


def fluctuation(signal: Floats, rate: int, low: float, high: float) -> float:
    """Return the variance of the logarithm of the mean power in a band [Hz] that follows from its changes from second to second.

    Spectra of a signal that is not stationary are less certain than chance alone makes them.
    """
    from scipy.signal import butter, sosfilt

    top = min(high, NYQUIST_SHARE * rate)
    filtered = sosfilt(butter(2, [low, top], "bandpass", fs=rate, output="sos"), signal) if low < 0.9 * top else signal
    seconds = len(filtered) // rate
    if seconds < 2:
        return 0.0
    powers = np.mean(filtered[: seconds * rate].reshape(seconds, rate) ** 2, axis=1)
    return float(np.var(np.log(np.maximum(powers, np.finfo(np.float64).tiny)), ddof=1)) / seconds
