"""The rules of the detector. A new rule needs its own file and one line here."""

from __future__ import annotations

from pkgutil import resolve_name
from typing import Any

from dcrb_ros.diagnosis.heat_rule import HeatRule
from dcrb_ros.diagnosis.rule import BearingRule, LevelRule, Rule, SampleRule


def _rules(*names: str) -> tuple[Any, ...]:
    """Return rules by module and class below ``dcrb_ros.diagnosis.rules``."""
    return tuple(resolve_name(f"dcrb_ros.diagnosis.rules.{name}") for name in names)


BEARING_RULES: tuple[type[BearingRule[Any]], ...] = _rules(
    "outer_ring:OuterRing",
    "inner_ring:InnerRing",
    "roller:Roller",
    "cage:Cage",
)
"""Rules for the bearing; their findings are combined."""

SAMPLE_RULES: tuple[type[SampleRule[Any]], ...] = _rules(
    "not_finite:NotFinite",
    "constant:Constant",
    "magnitude:Magnitude",
    "silence:Silence",
    "stuck:Stuck",
    "saturation:Saturation",
    "dead:Dead",
    "spikes:Spikes",
    "rattling_mount:RattlingMount",
)
"""Rules for the samples of the sensor in the order in which they are asked; the first flaw counts."""

LEVEL_RULES: tuple[type[LevelRule[Any]], ...] = _rules(
    "gain_drift:GainDrift",
    "loose_mount:LooseMount",
)
"""Rules for the levels of the sensor, asked after those for the samples; the first flaw counts."""

HEAT_RULES: tuple[type[HeatRule[Any]], ...] = _rules(
    "overheating:Overheating",
    "lubrication:Lubrication",
)
"""Rules for the temperature; of two with equal evidence the last counts."""

NOISE_RULES: tuple[type[Rule[Any]], ...] = _rules("starved_noise:StarvedNoise")
"""Rules for the level of vibration that name no damage."""

RULES = (*BEARING_RULES, *SAMPLE_RULES, *LEVEL_RULES, *HEAT_RULES, *NOISE_RULES)
