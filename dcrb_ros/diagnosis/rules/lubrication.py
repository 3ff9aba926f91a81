"""Loss of lubricant: starved films resist rolling less, so that the bearing first is cooler than expected, and hot when they are gone."""

from __future__ import annotations

from dcrb_ros.diagnosis.heat_rule import HeatEvidence, HeatFinding, HeatParameters, HeatRule, heat_excess, hot_excess
from dcrb_ros.diagnosis.rule import LEAST_EXCESS
from dcrb_ros.schema.fields import quantity


class LubricationParameters(HeatParameters):
    """Threshold of the lack of temperature."""

    cooler: float = quantity(8.0, "K", "Lack of temperature below the expected one that is a starved bearing, at least", 1.0, 200.0)
    cooler_deviations: float = quantity(4.5, "-", "The same in standard deviations of a healthy bearing; the larger one counts", 1.0, 20.0)


class Lubrication(HeatRule[LubricationParameters]):
    """A bearing that is too cool, or too hot after it was too cool."""

    parameters, trouble = LubricationParameters, "lubrication"

    def finding(self, evidence: HeatEvidence) -> HeatFinding:
        cool = heat_excess(-evidence.residual, max(self.p.cooler, self.p.cooler_deviations * evidence.deviation))
        hot = hot_excess(evidence, self.p) if evidence.starved else LEAST_EXCESS
        if hot > cool:
            return HeatFinding("lubrication", hot, f"{evidence.sentence}, and it was too cool before: its lubricant is lost")
        return HeatFinding("lubrication", cool, f"{evidence.sentence}: starved films resist rolling less")
