"""Overheating: the bearing is hotter than its speed, load and surroundings explain."""

from __future__ import annotations

from dcrb_ros.diagnosis.heat_rule import HeatEvidence, HeatFinding, HeatParameters, HeatRule, hot_excess


class Overheating(HeatRule[HeatParameters]):
    """An excess over the expected temperature, whatever its cause."""

    parameters, trouble = HeatParameters, "overheating"

    def finding(self, evidence: HeatEvidence) -> HeatFinding:
        return HeatFinding("overheating", hot_excess(evidence, self.p), f"{evidence.sentence}: it overheats")
