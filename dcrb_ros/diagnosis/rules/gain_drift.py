"""A gain that drifts: all bands have fallen together at the same speed."""

from __future__ import annotations

import numpy as np

from dcrb_ros.diagnosis.evidence import LevelEvidence
from dcrb_ros.diagnosis.rule import LevelRule
from dcrb_ros.schema.fields import Group, quantity


class GainDriftParameters(Group):
    """Thresholds for a common fall of all bands."""

    gain_drop: float = quantity(3.0, "dB", "Decrease of all bands at the same speed that indicates a falling gain of the sensor", 0.5, 60.0)
    gain_spread: float = quantity(
        0.25,
        "-",
        "Largest difference between the decreases of the bands relative to their mean; a gain causes 0.2, a change of load 0.3",
        0.01,
        10.0,
    )


class GainDrift(LevelRule[GainDriftParameters]):
    """A fall of the mean level with little difference between the bands."""

    parameters = GainDriftParameters

    def __init__(self, parameters: GainDriftParameters) -> None:
        super().__init__(parameters)
        self._low = False
        """Whether the levels fell together and have stayed low."""

    def flaw(self, evidence: LevelEvidence) -> str:
        if evidence.levels is None:
            return ""
        change = evidence.levels.change
        fall = -float(change.mean())
        together = len(change) > 1 and fall >= self.p.gain_drop and float(np.ptp(change)) <= self.p.gain_spread * fall
        # Further down the noise of the sensor dominates in the weaker bands, and they no longer fall together.
        self._low = together or (self._low and float(change.max()) <= -self.p.gain_drop)
        return f"all bands have decreased by {fall:.1f} dB at the same speed: the gain of the sensor drifts" if self._low else ""
