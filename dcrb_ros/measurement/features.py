"""Statistical features of a block, the simplest quantities of condition monitoring."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.schema.arrays import Samples


def features(acceleration: Samples, clipped: int) -> dict[str, float]:
    """Return rms and peak [m/s^2], crest factor and kurtosis [-] of the vertical axis, and the number of clipped samples.

    ``acceleration`` has shape (samples, 2) [m/s^2]. The mean is removed; crest factor and kurtosis of a constant signal are zero.
    """
    y = acceleration[:, 1].astype(np.float64)
    y -= y.mean()
    power = y * y
    rms = math.sqrt(power.mean())
    peak = float(np.abs(y).max())
    constant = rms == 0.0
    return {
        "rms": rms,
        "peak": peak,
        "crest": 0.0 if constant else peak / rms,
        "kurtosis": 0.0 if constant else float(np.mean(power * power)) / rms**4,
        "clipped": float(clipped),
    }
