"""Base of the rules for the temperature of the bearing, and what they look at."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar, NamedTuple, TypeVar

from dcrb_ros.diagnosis.rule import LEAST_EXCESS, Rule
from dcrb_ros.schema.fields import Group, quantity
from dcrb_ros.schema.verdicts import Trouble


class HeatParameters(Group):
    """What all rules for the temperature share: the model of the healthy rise."""

    heat_rise: float = quantity(
        27.5, "K", "Rise of a healthy bearing above ambient at 15 Hz (156 km/h) before it is learned: 10 to 45 K", 1.0, 200.0
    )
    heat_rise_deviation: float = quantity(9.0, "K", "Standard deviation of that rise between bearings", 0.1, 100.0)
    heat_learn: float = quantity(24.0, "h", "Hours with readings from which the healthy rise is learned; 0 to keep heat_rise", 0.0, 1e4)
    heat_error: float = quantity(2.0, "K", "Standard deviation of the rise at 15 Hz by heat from outside, such as the sun", 0.1, 50.0)
    heat_error_share: float = quantity(0.12, "-", "The same relative to the rise, in addition: by load, wind and rain", 0.0, 1.0)
    heat_confirm: int = quantity(3, "readings", "Consecutive readings with evidence that confirm a verdict by temperature", 1, 10_000)
    heat_release: int = quantity(60, "readings", "Consecutive readings without evidence that clear it", 1, 100_000)
    heat_time_lapse: float = quantity(
        1.0, "-", "How much faster than in reality the bearing stores heat: thermal.acceleration of a bench, 1 for a real one", 1.0, 3000.0
    )
    heat_most: float = quantity(
        45.0, "K", "Largest rise of a healthy bearing at 15 Hz; one with a larger rise was hot from the beginning", 1.0, 400.0
    )
    heat_new_deviations: float = quantity(
        3.0, "-", "Excess in standard deviations that is too hot before the healthy rise is known (after two hours of readings)", 1.0, 20.0
    )
    hotter: float = quantity(12.0, "K", "Excess over the expected temperature that is too hot, at least", 1.0, 200.0)
    hotter_deviations: float = quantity(5.0, "-", "The same in standard deviations of a healthy bearing; the larger one counts", 1.0, 20.0)


Parameters = TypeVar("Parameters", bound=HeatParameters)


class HeatEvidence(NamedTuple):
    """A reading beside what the model of the healthy bearing expects."""

    rise: float
    """Above ambient [K]."""
    expected: float
    """[K]"""
    deviation: float
    """Standard deviation of a healthy bearing from the expected rise [K]."""
    starved: bool
    """Whether the bearing was cooler than expected, as the films of a bearing that loses its lubricant make it, within the last hours."""
    usual: float | None
    """Rise of this bearing at 15 Hz as it was learned, at least [K]; None before it is known."""

    @property
    def residual(self) -> float:
        """How much hotter the bearing is than expected [K]."""
        return self.rise - self.expected

    @property
    def sentence(self) -> str:
        """The evidence in words."""
        expected = f"{self.expected:.1f} K are expected with a deviation of {self.deviation:.1f} K"
        return f"the bearing is {self.rise:.1f} K above ambient, {expected}"


class HeatFinding(NamedTuple):
    """The evidence of a rule."""

    trouble: Trouble
    excess: float
    """Evidence relative to the threshold [dB]."""
    reason: str


class HeatRule(Rule[Parameters]):
    """Looks for one trouble in the temperature of the bearing, once per reading."""

    trouble: ClassVar[Trouble]

    @abstractmethod
    def finding(self, evidence: HeatEvidence) -> HeatFinding:
        """Return the evidence for the trouble."""


def hot_excess(evidence: HeatEvidence, p: HeatParameters) -> float:
    """Return by how much the bearing is hotter than it usually is, or than healthy ones are as long as that is unknown [dB]."""
    deviations = p.heat_new_deviations if evidence.usual is None else p.hotter_deviations
    return heat_excess(evidence.residual, max(p.hotter, deviations * evidence.deviation))


def heat_excess(departure: float, threshold: float) -> float:
    """Return a departure from the expected rise relative to a threshold, both [K], in decibels."""
    return max(LEAST_EXCESS, 20.0 * math.log10(departure / threshold)) if departure > 0.0 else LEAST_EXCESS
