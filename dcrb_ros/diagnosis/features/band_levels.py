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
    found = 1000.0 * 10.0 ** (np.arange(LOWEST, HIGHEST + 1) / 10.0)
    return np.asarray(found[found * EDGE <= 0.5 * rate], np.float64)


def names(rate: int) -> tuple[str, ...]:
    """Return the names of the features, such as ``level_1000_Hz``."""
    return tuple(f"level_{middle:.3g}_Hz" if middle < 1000.0 else f"level_{middle:.0f}_Hz" for middle in middles(rate))


def compute(windows: Windows) -> Floats:
    """Return 10 lg of the mean square in each band over 1 (m/s^2)^2, shape (windows, bands) [dB]."""
    samples, middle = windows.shape[1], middles(windows.rate)
    spacing = windows.rate / samples
    # Integrated from line to line, each line spread evenly over its own interval, so that an edge may lie within one.
    total = np.concatenate([np.zeros((len(windows.spectrum), 1)), np.cumsum(windows.spectrum, axis=1)], axis=1)
    borders = (np.arange(total.shape[1]) - 0.5) * spacing
    power = np.array([np.interp(middle * EDGE, borders, row) - np.interp(middle / EDGE, borders, row) for row in total])
    return np.asarray(10.0 * np.log10(np.maximum(power, FLOOR)), np.float64)


BAND_LEVELS = FeatureFamily("band_levels", names, compute)
