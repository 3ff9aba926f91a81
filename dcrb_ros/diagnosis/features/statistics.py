"""Statistics of the samples: level, peak and moments.

Dyer and Stewart 1978, "Detection of rolling element bearing damage by statistical vibration analysis", introduced the kurtosis: 3 for
noise, more for impacts.
"""

from __future__ import annotations

import numpy as np

from dcrb_ros.diagnosis.features.family import FeatureFamily, Windows
from dcrb_ros.schema.arrays import Floats

NAMES = ("rms", "peak", "crest_factor", "kurtosis", "skewness")
LEAST = float(np.finfo(np.float64).tiny) ** 0.5
"""Least power of a window [(m/s^2)^2]: its square is not zero."""


def compute(windows: Windows) -> Floats:
    """Return rms and peak [m/s^2], crest factor peak/rms, kurtosis and skewness [-], shape (windows, 5)."""
    signal = windows.acceleration
    squared = signal * signal
    power = np.maximum(squared.mean(axis=1), LEAST)
    rms, peak = np.sqrt(power), np.sqrt(squared.max(axis=1))
    third, fourth = (np.einsum("ws,ws->w", squared, factor) / signal.shape[1] for factor in (signal, squared))
    return np.column_stack([rms, peak, peak / rms, fourth / power**2, third / power**1.5])


STATISTICS = FeatureFamily("statistics", lambda _: NAMES, compute)
