"""A loose mount: the sensor has lost the high frequencies."""

from __future__ import annotations

import math

from dcrb_ros.diagnosis.evidence import LevelEvidence, Levels
from dcrb_ros.diagnosis.rule import LevelRule
from dcrb_ros.schema.fields import Group, quantity

LOWER = 2
"""Number of quarters below the third [-]."""


class LooseMountParameters(Group):
    """Thresholds for the level of the high frequencies."""

    loose_level: float = quantity(
        -23.0,
        "dB",
        "Power of the third quarter of the band relative to the band below it, under which a mount may be loose; healthy down to -22",
        -120.0,
        0.0,
    )
    loose_drop: float = quantity(8.0, "dB", "Decrease of that level from its highest value that indicates a loose mount", 1.0, 60.0)
    loose_fall: float = quantity(
        3.0, "dB", "Decrease of a quarter's own power without which a mount is not loose: a defect raises the band below instead", 0.0, 60.0
    )
    firm_level: float = quantity(
        -60.0, "dB", "That level for a firm mount, if the first seconds must not define it; a rigid mount has -10", -120.0, 60.0
    )


class LooseMount(LevelRule[LooseMountParameters]):
    """Levels of the quarters of the detector's band relative to the band below it: the mount does not transmit high frequencies any more.

    The third quarter counts from its highest level so far, which outlasts changes of the speed. The first and the second count from the
    beginning at the present speed, for where a bearing is quiet the third shows the noise of the sensor. In each case the quarter itself
    has to lose power: a defect and a resonance below the band raise what it is compared with.
    """

    parameters = LooseMountParameters

    def __init__(self, parameters: LooseMountParameters) -> None:
        super().__init__(parameters)
        self._highest, self._then = parameters.firm_level, math.inf
        """Highest relative level of the third quarter, and its own level at that time; infinite if the parameters state the former [dB]."""

    def flaw(self, evidence: LevelEvidence) -> str:
        return self._third(evidence.levels, evidence.third) or self._lower_quarters(evidence.levels)

    def _third(self, levels: Levels, third: int | None) -> str:
        if third is None:
            return ""
        power = float(levels.level[third])
        level = power - float(levels.level[-1])
        if level > self._highest:
            self._highest, self._then = level, power
        if level > self.p.loose_level or level > self._highest - self.p.loose_drop or power > self._then - self.p.loose_fall:
            return ""
        change = f"from {-self._highest:.1f} to {-level:.1f} dB below the band under the detector's"
        return f"the third quarter of the band has decreased {change}: the mount of the sensor is loose"

    def _lower_quarters(self, levels: Levels) -> str:
        change = levels.change[:LOWER].max()
        drop = change - levels.change[-1]
        if len(levels.change) <= LOWER or drop > -self.p.loose_drop or change > -self.p.loose_fall:
            return ""
        return f"the first two quarters of the band have lost {-drop:.1f} dB to the band below them: the mount of the sensor is loose"
