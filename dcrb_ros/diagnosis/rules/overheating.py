"""Overheating: the bearing is hotter than its speed, load and surroundings explain."""

from __future__ import annotations

from dcrb_ros.diagnosis.heat_rule import HeatEvidence, HeatFinding, HeatParameters, HeatRule, heat_excess, hot_excess


class Overheating(HeatRule[HeatParameters]):
    """An excess over the expected temperature, whatever its cause, or a usual temperature that no healthy bearing has."""

    parameters, trouble = HeatParameters, "overheating"

    def finding(self, evidence: HeatEvidence) -> HeatFinding:
        hot = hot_excess(evidence, self.p)
        always = heat_excess(evidence.usual, self.p.heat_most) if evidence.usual is not None else hot
        if always > hot:
            usual = f"it usually has {evidence.usual:.1f} K at 15 Hz or more, a healthy one has {self.p.heat_most:g} K at most"
            return HeatFinding("overheating", always, f"{evidence.sentence}, but {usual}: it was hot from the beginning")
        return HeatFinding("overheating", hot, f"{evidence.sentence}: it overheats")
