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
        "Power of the band's third quarter over that of the band below it, under which a mounting may be loose; healthy down to -22",
        -120.0,
        0.0,
    )
    loose_drop: float = quantity(8.0, "dB", "Fall of that level since it was highest from which the mounting is loose", 1.0, 60.0)
    firm_level: float = quantity(
        -60.0, "dB", "That level of a firm sensor, where the first seconds must not decide; a rigid mount has -10", -120.0, 60.0
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
        return (
            f"the high band has fallen to {-level:.1f} dB below the low one, from {-self._highest:.1f} dB: the sensor's mounting is loose"
        )
