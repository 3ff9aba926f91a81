"""Levels of third-octave bands, which show the path from the bearing to the sensor and the noise.

The mid-band frequencies are 1000 Hz times 10^(k/10), the edges lie a factor of 10^(1/20) beside them (IEC 61260-1:2014, 5.2 to 5.4).
"""

from __future__ import annotations

import numpy as np

from dcrb_ros.diagnosis.features.family import FeatureFamily, Windows
from dcrb_ros.schema.arrays import Floats

LOWEST, HIGHEST = -15, 13
"""Numbers k of the lowest and the highest band: 31.6 Hz and 20 kHz."""
EDGE = 10.0**0.05
FLOOR = 1e-12
"""Least power of a band [(m/s^2)^2]: -120 dB."""


def middles(rate: int) -> Floats:
    """Return the mid-band frequencies of the bands below half the sampling ``rate`` [Hz], shape (bands,) [Hz]."""
    nominal = 1000.0 * 10.0 ** (np.arange(LOWEST, HIGHEST + 1) / 10.0)
    return np.asarray(nominal[nominal * EDGE <= 0.5 * rate], np.float64)


def levels(cumulative: Floats, spacing: float, rate: int) -> Floats:
    """Return 10 lg of the mean square in each band over 1 (m/s^2)^2, shape (bands,) [dB].

    ``cumulative``, shape (lines + 1,) [(m/s^2)^2], is the power below each line of a spectrum with a ``spacing`` [Hz]. Each line is spread
    evenly over its interval, so that the edge of a band may lie within one.
    """
    middle, borders = middles(rate), (np.arange(len(cumulative)) - 0.5) * spacing
    power = np.interp(middle * EDGE, borders, cumulative) - np.interp(middle / EDGE, borders, cumulative)
    return np.asarray(10.0 * np.log10(np.maximum(power, FLOOR)), np.float64)


def names(rate: int) -> tuple[str, ...]:
    """Return the names of the features, such as ``level_1000_Hz``."""
    return tuple(f"level_{middle:.3g}_Hz" if middle < 1000.0 else f"level_{middle:.0f}_Hz" for middle in middles(rate))


def compute(windows: Windows) -> Floats:
    """Return 10 lg of the mean square in each band over 1 (m/s^2)^2, shape (windows, bands) [dB]."""
    cumulative = np.pad(np.cumsum(windows.spectrum, axis=1), ((0, 0), (1, 0)))
    return np.array([levels(power, windows.rate / windows.shape[1], windows.rate) for power in cumulative])


BAND_LEVELS = FeatureFamily("band_levels", names, compute)
