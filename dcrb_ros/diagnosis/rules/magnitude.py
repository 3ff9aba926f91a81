"""A magnitude that no accelerometer has: samples in another unit, or damaged ones."""

from __future__ import annotations

import numpy as np

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.fields import Group

SMALLEST, LARGEST = 1e-9, 1e9
"""Range of a vibration [m/s^2]: the quietest accelerometers have more noise, those for shocks end at 1e6. The squared envelopes of
signals within it lie far inside the range in which they are calculated."""


class Magnitude(SampleRule[Group]):
    """The largest sample of an axis, and its change within a hop."""

    def flaw(self, evidence: SampleEvidence) -> str:
        for axis, column in evidence.axes:
            largest, change = float(np.abs(column).max()), float(np.ptp(column))
            if largest > LARGEST:
                return f"the acceleration in {axis} reaches {largest:.3g} m/s^2, above {LARGEST:g}: check the unit and the samples"
            if 0.0 < change < SMALLEST:
                return f"the acceleration in {axis} changes by {change:.3g} m/s^2 only, below {SMALLEST:g}: check the unit and the sensor"
        return ""
