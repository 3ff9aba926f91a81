"""A dead sensor: only noise is left."""

from __future__ import annotations

import math

import numpy as np
from scipy import fft

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

LOW = (200.0, 2000.0)
"""Band in which a turning bearing is always louder than the noise of a sensor: rollers pass the load line [Hz]."""
HIGH_SHARES = (0.2, 0.45)
"""Band to compare with, as shares of the sampling rate [-]."""


class DeadParameters(Group):
    """Thresholds for noise."""

    dead_level: float = quantity(
        6.0,
        "dB",
        "Power density at 200 to 2000 Hz relative to that near the Nyquist frequency, below which it is noise; bearings have 12",
        0.0,
        60.0,
    )
    dead_kurtosis: float = quantity(4.0, "-", "Kurtosis below which a flat spectrum is noise, which has 3; impacts have 6", 3.0, 100.0)


class Dead(SampleRule[DeadParameters]):
    """A flat spectrum without impacts."""

    parameters = DeadParameters

    def flaw(self, evidence: SampleEvidence) -> str:
        for axis, column in evidence.axes:
            level = self._level_of_noise(column, evidence.rate)
            if level is not None and level < self.p.dead_level:
                return f"the acceleration in {axis} is noise, only {level:.1f} dB stronger at 200 to 2000 Hz: the sensor is dead"
        return ""

    def _level_of_noise(self, column: Floats, rate: int) -> float | None:
        """Return the power density of the low band over that of the high band [dB], or none if the samples have impacts."""
        centred = column - column.mean()
        squared = np.square(centred)
        if float(np.mean(np.square(squared))) / float(np.mean(squared)) ** 2 >= self.p.dead_kurtosis:
            return None
        power = np.abs(fft.rfft(centred)) ** 2
        high_band = HIGH_SHARES[0] * rate, HIGH_SHARES[1] * rate
        low, high = (power[slice(*(round(edge * len(column) / rate) for edge in band))] for band in (LOW, high_band))
        return 10.0 * math.log10(max(float(low.mean()), 1e-30) / max(float(high.mean()), 1e-30))
