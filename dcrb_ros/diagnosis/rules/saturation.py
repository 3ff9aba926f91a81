"""A saturated sensor: samples are clipped."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

FEWEST_VALUES = 16
"""Different values below which flat peaks are the steps of a coarse ADC."""
MOSTLY_CLIPPED = 0.8
"""Share of samples at both ends beyond which a coarse ADC is clipped [-]; a sine of 1.5 steps has 0.78."""


class SaturationParameters(Group):
    """Thresholds for clipped samples."""

    most_clipped: float = quantity(
        0.15, "-", "Largest share of clipped samples in a hop; more indicate a sensor fault, impacts of a defect clip up to 0.1", 0.0, 1.0
    )
    least_clipped: float = quantity(
        0.0005, "-", "Largest share of samples clipped below the range in a hop; more indicate a sensor fault", 0.0, 1.0
    )
    range_share: float = quantity(
        0.9, "-", "Clipping level relative to the sensor's range below which it indicates a sensor fault", 0.0, 1.0
    )


class Saturation(SampleRule[SaturationParameters]):
    """Counts consecutive samples at the largest or smallest value; a fault if they are many, or if the limit is below the range."""

    parameters = SaturationParameters
    at_standstill = True

    def flaw(self, evidence: SampleEvidence) -> str:
        for axis, column in evidence.axes:
            clipped = {
                end: int(np.count_nonzero(at))
                for end in (float(column.max()), float(column.min()))
                if np.any((at := column == end)[1:] & at[:-1]) and piles_up(column, at)
            }
            share = sum(clipped.values()) / len(column)
            if not clipped or (is_coarse(column) and not (len(clipped) == 2 and share > MOSTLY_CLIPPED)):
                continue
            self.clipped += sum(clipped.values())
            # Two equal samples by chance are no limit of the signal.
            least, lowest = self.p.least_clipped * len(column), self.p.range_share * evidence.sensor_range
            below = {end: count for end, count in clipped.items() if count > 0.5 * least and abs(end) < lowest}
            limit = min(map(abs, below or clipped))
            if share > self.p.most_clipped or sum(below.values()) > least:
                known = f" where its range is {evidence.sensor_range:g}" if evidence.sensor_range else ""
                level = f"{limit:.3g} m/s^2{known} for {share:.1%} of the time"
                return f"the acceleration in {axis} is clipped at {level}: the sensor is saturated"
        return ""


def is_coarse(column: Floats) -> bool:
    """Return whether a column has fewer than `FEWEST_VALUES` different values; all samples are sorted only if the first ones have."""
    return all(len(np.unique(part)) < FEWEST_VALUES for part in (column[: 16 * FEWEST_VALUES], column))


def piles_up(column: Floats, at: npt.NDArray[np.bool_]) -> bool:
    """Return whether the largest or smallest value of a column, which it has ``at`` some samples, is more frequent than the next one.

    Clipped peaks pile up at the limit. The steps of a coarse ADC become rarer towards the largest value.
    """
    rest = column[~at]
    if not len(rest):
        return True
    following = rest.max() if column[at][0] > rest[0] else rest.min()
    return int(np.count_nonzero(at)) > int(np.count_nonzero(rest == following))
