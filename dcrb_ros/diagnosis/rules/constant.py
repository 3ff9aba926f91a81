"""A dead sensor: an acceleration that does not change at all."""

from __future__ import annotations

import numpy as np

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.fields import Group


class Constant(SampleRule[Group]):
    """A hop with one and the same value in an axis."""

    def flaw(self, evidence: SampleEvidence) -> str:
        for axis, column in evidence.axes:
            if float(np.ptp(column)) == 0.0:
                return f"the acceleration in {axis} does not change: the sensor is dead"
        return ""
