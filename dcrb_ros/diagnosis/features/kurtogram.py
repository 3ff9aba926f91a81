"""The fast kurtogram: the most impulsive band among those of a 1/3-binary tree, by the spectral kurtosis of its complex envelope.

Antoni 2007, "Fast computation of the kurtogram for the detection of transient faults". Each level divides the frequencies up to 0.45 of the
sampling rate into 2, 3, 4, 6, 8, 12 ... bands of equal width. The complex envelope of a band is the inverse Fourier transform of its part
of the spectrum, which gives one value for each line.

The Fourier transform repeats a window, so its two ends meet in a jump. Above an anti-alias filter, where a recording has little power, this
jump is the strongest impact of the window. The ends of the envelopes therefore do not count, and the bands end below the filter.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import fft

from dcrb_ros.diagnosis.demodulation import NYQUIST_SHARE, tukey
from dcrb_ros.diagnosis.features.family import FeatureFamily, Windows
from dcrb_ros.schema.arrays import Floats

NAMES = ("kurtogram_kurtosis", "kurtogram_frequency", "kurtogram_bandwidth")
DIVISIONS = (2, 3, 4, 6, 8, 12, 16, 24)
"""Numbers of bands of the levels."""
FEWEST = 256
"""Least number of values of an envelope: that of noise then has a kurtosis of 0 +- 0.13."""
TAPER = 0.25
"""Share of a band's width taken by its two edges [-]; abrupt ones would ring and hide impacts."""
ENDS = 0.05
"""Share of a window at each of its ends that does not count [-]: 13 values of the shortest envelope, in which a jump has decayed."""


class ImpulsiveBand(NamedTuple):
    """The most impulsive band of each window, arrays of shape (windows,)."""

    kurtosis: Floats
    """Spectral kurtosis K = <|c|^4> / <|c|^2>^2 - 2 of the complex envelope c [-]: 0 for noise, for silence, and without a band."""
    low: Floats
    """Lower edge [Hz]."""
    high: Floats
    """Upper edge [Hz]."""


def impulsive_band(acceleration: npt.ArrayLike, rate: float) -> ImpulsiveBand:
    """Return the band with the largest spectral kurtosis of each window of shape (windows, samples), sampled at ``rate`` [Hz]."""
    signal = np.atleast_2d(np.asarray(acceleration, np.float64))
    windows, samples = signal.shape
    count = int(NYQUIST_SHARE * samples)
    lines = fft.rfft(signal.astype(np.float32), axis=1)[:, 1 : count + 1]
    best, low, high = np.full(windows, -np.inf), np.zeros(windows), np.zeros(windows)
    for divisions in DIVISIONS:
        width = count // divisions
        if width < FEWEST:
            break
        parts = lines[:, : divisions * width].reshape(windows, divisions, width) * tukey(width, TAPER).astype(np.float32)
        ends = math.ceil(ENDS * width)
        squared = _squared(fft.ifft(parts, axis=2, overwrite_x=True)[:, :, ends:-ends])
        mean = squared.mean(axis=2)
        kurtosis = np.divide((squared**2).mean(axis=2), mean**2, out=np.full(mean.shape, 2.0), where=mean > 0.0) - 2.0
        number = kurtosis.argmax(axis=1)
        largest = kurtosis[np.arange(windows), number]
        better = largest > best
        step = rate * width / samples
        best, low = np.where(better, largest, best), np.where(better, number * step, low)
        high = np.where(better, (number + 1) * step, high)
    return ImpulsiveBand(np.where(high > 0.0, best, 0.0), low, high)


def _squared(envelope: npt.NDArray[np.complexfloating[Any, Any]]) -> Floats:
    return np.asarray(np.square(envelope.real, dtype=np.float64) + np.square(envelope.imag, dtype=np.float64))


def compute(windows: Windows) -> Floats:
    """Return the largest spectral kurtosis [-], and middle and width of its band [Hz], shape (windows, 3)."""
    band = impulsive_band(windows.acceleration, windows.rate)
    windows.shared["impulsive_band"] = band
    return np.column_stack([band.kurtosis, 0.5 * (band.low + band.high), band.high - band.low])


KURTOGRAM = FeatureFamily("kurtogram", lambda _: NAMES, compute)
