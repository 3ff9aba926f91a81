"""A loose mount: the sensor has lost the high frequencies."""

from __future__ import annotations

from dcrb_ros.diagnosis.evidence import LevelEvidence
from dcrb_ros.diagnosis.rule import LevelRule
from dcrb_ros.schema.fields import Group, quantity


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
    firm_level: float = quantity(
        -60.0, "dB", "That level for a firm mount, if the first seconds must not define it; a rigid mount has -10", -120.0, 60.0
    )


class LooseMount(LevelRule[LooseMountParameters]):
    """Level of the third quarter of the detector's band relative to the band below it, compared with its highest value so far."""

    parameters = LooseMountParameters

    def __init__(self, parameters: LooseMountParameters) -> None:
        super().__init__(parameters)
        self._highest = parameters.firm_level

    def flaw(self, evidence: LevelEvidence) -> str:
        if evidence.levels is None or evidence.third is None:
            return ""
        level = float(evidence.levels.level[evidence.third] - evidence.levels.level[-1])
        self._highest = max(self._highest, level)
        if level > self.p.loose_level or level > self._highest - self.p.loose_drop:
            return ""
        change = f"from {-self._highest:.1f} to {-level:.1f} dB below the band under the detector's"
        return f"the third quarter of the band has decreased {change}: the mount of the sensor is loose"
