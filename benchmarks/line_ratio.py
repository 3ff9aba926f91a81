"""The lines of an envelope relative to the spectrum around them, and their growth from a healthy bearing to a faulty one.

``squared`` is a squared envelope and ``signal`` a signal of shape (samples,), ``rate`` its sampling rate [Hz], ``frequency`` that of the
fundamental of the line [Hz] and ``shaft_frequency`` that of the shaft [Hz].
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy import fft

from dcrb_ros.diagnosis.demodulation import Band, Demodulator, kurtosis
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

WINDOW, HOP = 1.0, 0.5
"""Length and distance of the windows [s]."""
HARMONICS = (1, 2, 3)
NEAR = 0.02
"""Relative distance from a harmonic within which the largest line counts [-]."""
AROUND = 1.5
"""Distance from a harmonic within which the median is taken [turns of the shaft]."""
LARGEST_SHARE = 0.43
"""Highest edge of the bands of a kurtogram relative to the sampling rate [-]: anti-alias filters act above it."""
LEVELS = 5
"""Levels of the tree of bands; each divides into two or into three [-]."""


def line_ratio(squared: Floats, rate: float, frequency: float, shaft_frequency: float) -> float:
    """Return R [-], the sum over three harmonics of a line over the median of the spectrum around it; the median of windows of 1 s.

    Raises:
        Refusal: the envelope is shorter than a window.
    """
    count = round(WINDOW * rate)
    if len(squared) < count:
        raise Refusal(f"an envelope of {len(squared) / rate:.3g} s is shorter than the window of {WINDOW:g} s: analyse a longer recording")
    starts = range(0, len(squared) - count + 1, round(HOP * rate))
    return float(np.median([window_ratio(squared[start : start + count], rate, frequency, shaft_frequency) for start in starts]))


def window_ratio(squared: Floats, rate: float, frequency: float, shaft_frequency: float) -> float:
    """Return R [-] of one window."""
    amplitude = np.abs(fft.rfft((squared - squared.mean()) * np.hanning(len(squared))))
    axis, ratio = np.arange(len(amplitude)) * rate / len(squared), 0.0
    for harmonic in HARMONICS:
        apart = np.abs(axis - harmonic * frequency)
        ratio += float(amplitude[apart <= NEAR * harmonic * frequency].max() / np.median(amplitude[apart <= AROUND * shaft_frequency]))
    return ratio


def kurtogram_ratio(signal: npt.NDArray[np.floating], rate: float, frequency: float, shaft_frequency: float) -> float:
    """Return R [-] in the band with the largest spectral kurtosis, chosen anew in each window of 1 s; the median of the windows.

    The bands are those of a 1/3-binary tree that ends at 0.43 of the sampling rate (Antoni 2007, "Fast computation of the kurtogram for
    the detection of transient faults", Mech. Syst. Signal Process. 21). A band is wide enough for three harmonics of the line.

    Raises:
        Refusal: the signal is shorter than a window, or no band contains three harmonics.
    """
    count, narrowest = round(WINDOW * rate), (HARMONICS[-1] + 1) * frequency
    tree = kurtogram_bands(rate, narrowest)
    if len(signal) < count or not tree:
        raise Refusal(
            f"{len(signal) / rate:.3g} s at {rate:g} Hz have no window of {WINDOW:g} s with a band of {narrowest:.4g} Hz: analyse a "
            "longer recording or one with a higher sampling rate"
        )
    demodulator, ratios = Demodulator(tree, round(rate), count), []
    for start in range(0, len(signal) - count + 1, round(HOP * rate)):
        part = signal[start : start + count]
        envelopes = demodulator.squared_envelopes((part - part.mean())[:, None])
        positions, squared = max(envelopes, key=lambda one: float(kurtosis(one[1][None])[0]))
        ratios.append(window_ratio(squared, rate / float(positions[1]), frequency, shaft_frequency))
    return float(np.median(ratios))


def kurtogram_bands(rate: float, narrowest: float) -> tuple[Band, ...]:
    """Return the bands of the tree of a sampling rate [Hz] that are at least as wide as ``narrowest`` [Hz]."""
    counts = [count for level in range(1, LEVELS + 1) for count in (2**level, 3 * 2 ** (level - 1))]
    edges = (pairwise(np.linspace(0.0, LARGEST_SHARE * rate, count + 1)) for count in counts)
    return tuple(Band(float(low), float(high)) for pairs in edges for low, high in pairs if high - low >= narrowest)
