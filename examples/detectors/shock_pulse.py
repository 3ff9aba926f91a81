"""Shock pulses: the largest pulse and the carpet value in the band of a resonant transducer (Butler 1973)."""

from typing import Literal

import numpy as np
from scipy.signal import butter, sosfilt
from trending import Trending

VARIANTS = {
    "shock pulse": {},
    "shock pulse, 10 dB": {"factor": 3.2},
    "shock pulse, maximum over carpet": {"of": "ratio", "factor": 3.2},
}
"""Settings of each member of the family; the first has the published ones."""


class ShockPulse(Trending):
    """Report the most frequent fault if the largest pulse has grown by 20 dB over the healthy one, the caution limit of the method.

    The band is 32 kHz plus and minus 10 %, or at 0.35 of the sampling rate if that is lower. Amplitude-based: where the gain of the sensor
    differs between recordings, it measures the recording. The member ``of: ratio`` takes maximum over carpet (the level that 200 pulses
    a second exceed) and is independent of the gain. No part is named. No recording was used.
    """

    factor = 10.0
    of: Literal["maximum", "ratio"] = "maximum"
    """The ratio is that of maximum and carpet value."""

    def __init__(self, orders, rate, **settings):
        super().__init__(orders, rate, **settings)
        centre = min(32_000.0, 0.35 * rate)
        self.filter = butter(2, (0.9 * centre, 1.1 * centre), "bandpass", fs=rate, output="sos")

    def features(self, acceleration, angle):
        """Return the largest pulse [m/s^2], or its ratio to the carpet value [-]."""
        pulses = np.abs(sosfilt(self.filter, acceleration))
        held = np.sort(pulses[: len(pulses) // 16 * 16].reshape(-1, 16).max(axis=1))
        carpet = held[-min(int(200.0 * self.window), len(held))]
        return {"outer_ring": held[-1] / (carpet if self.of == "ratio" else 1.0)}
