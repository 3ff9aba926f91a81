"""A stuck sensor: the same value is repeated."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

FEWEST_SAMPLES = 16
"""Equal samples in a row below which a value repeats by chance in a quiet signal of a coarse ADC [-]."""


class StuckParameters(Group):
    """Thresholds for repeated values."""

    stuck_time: float = quantity(0.001, "s", "Time for which a value must repeat to count as stuck", 1e-5, 1.0)
    stuck_share: float = quantity(0.03, "-", "Largest share of stuck samples in a hop; more indicate a sensor fault", 0.0, 1.0)


class Stuck(SampleRule[StuckParameters]):
    """Share of the hop in long runs of equal samples; runs at the largest magnitude are clipping."""

    parameters = StuckParameters

    def flaw(self, evidence: SampleEvidence) -> str:
        least = max(FEWEST_SAMPLES, round(self.p.stuck_time * evidence.rate))
        for axis, column in evidence.axes:
            ends, lengths = runs_of_one_value(column)
            long = (lengths >= least) & (np.abs(column[ends]) < max(float(column.max()), -float(column.min())))
            share = float(lengths[long].sum()) / len(column)
            if share > self.p.stuck_share:
                return f"the acceleration in {axis} repeats the same value for {share:.0%} of the time: the sensor is stuck"
        return ""


def runs_of_one_value(column: Floats) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the last index and the length of every run of two or more equal samples."""
    equal = np.flatnonzero(column[1:] == column[:-1])
    if not len(equal):
        return equal, equal
    border = np.diff(equal) != 1
    first, last = equal[np.concatenate([[True], border])], equal[np.concatenate([border, [True]])]
    return last + 1, last - first + 2
