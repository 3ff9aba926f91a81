"""Features of a block that condition monitoring starts from."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.runtime.arrays import Samples


def features(acceleration: Samples, clipped: int) -> dict[str, float]:
    """Return rms and peak [m/s^2], crest factor and kurtosis [-] of the vertical axis of ``acceleration``, shape (samples, 2), and
    the number of clipped samples.

    The mean is removed; a block without motion has a crest factor and a kurtosis of zero.
    """
    y = acceleration[:, 1].astype(np.float64)
    y -= y.mean()
    power = y * y
    rms = math.sqrt(power.mean())
    peak = float(np.abs(y).max())
    still = rms == 0.0
    return {
        "rms": rms,
        "peak": peak,
        "crest": 0.0 if still else peak / rms,
        "kurtosis": 0.0 if still else float(np.mean(power * power)) / rms**4,
        "clipped": float(clipped),
    }
