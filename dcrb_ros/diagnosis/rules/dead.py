"""A dead sensor: only noise is left."""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy import fft

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

LOWEST = 200.0
"""Lowest frequency that counts [Hz]: below it the noise of amplifiers is pink, and the mains hum."""
HIGHEST_SHARE = 0.4
"""Highest frequency that counts, as a share of the sampling rate [-]: anti-alias filters act above it."""
BLOCKS = 16
"""Blocks of equal width in which the power density is compared."""
FEWEST_LINES = 64
"""Lines of the spectrum in a block: the level of noise then scatters by half a decibel."""


class DeadParameters(Group):
    """Thresholds for noise."""

    dead_level: float = quantity(
        9.0,
        "dB",
        "Largest difference between the power densities of 16 parts of the spectrum up to which it is noise, which has 2",
        0.0,
        60.0,
    )
    dead_kurtosis: float = quantity(4.0, "-", "Kurtosis below which a flat spectrum is noise, which has 3; impacts have 6", 3.0, 100.0)


class Dead(SampleRule[DeadParameters]):
    """A white spectrum without impacts: no structure transmits vibration equally at all frequencies."""

    parameters = DeadParameters

    def flaw(self, evidence: SampleEvidence) -> str:
        for axis, column in evidence.axes:
            spread = self._spread_of_noise(column, evidence.rate)
            if spread is not None and spread < self.p.dead_level:
                return f"the acceleration in {axis} is white noise, whose power density varies by {spread:.1f} dB only: the sensor is dead"
        return ""

    def _spread_of_noise(self, column: Floats, rate: int) -> float | None:
        """Return the range of the power density over frequency [dB], or none if the samples have impacts or are too few."""
        centred = column - column.mean()
        squared = np.square(centred)
        if float(np.mean(np.square(squared))) / float(np.mean(squared)) ** 2 >= self.p.dead_kurtosis:
            return None
        edges = np.linspace(LOWEST, HIGHEST_SHARE * rate, BLOCKS + 1) * len(column) / rate
        if edges[1] - edges[0] < FEWEST_LINES:
            return None
        power = np.abs(fft.rfft(centred)) ** 2
        levels = [float(power[round(low) : round(high)].mean()) for low, high in itertools.pairwise(edges)]
        return 10.0 * math.log10(max(*levels, 1e-30) / max(min(levels), 1e-30))
