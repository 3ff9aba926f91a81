"""Features of a block that condition monitoring starts from."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.block import Block


def features(block: Block) -> dict[str, float]:
    """Return rms and peak [m/s^2], crest factor and kurtosis [-] of the vertical axis, and the clipped samples [-].

    The mean is left out; a block without motion has a crest factor and kurtosis of zero.
    """
    y = block.acceleration[:, 1].astype(np.float64)
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
        "clipped": float(block.clipped),
    }
