"""From findings to a verdict that does not flicker."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from dcrb_ros.schema.verdicts import COMPONENTS, Component, Verdict

ALARM_DECADE = 4.0
"""Evidence above the threshold that makes a wrong alarm ten times as rare [dB]: 3.8 fits 391 alarms, 2.2 to 3.9 those without one rig."""
HEALTHY_DECADE = 10.0
"""Distance below the threshold that makes a missed fault ten times as rare [dB]."""
MOST_PROBABILITY = 0.99
"""Largest probability of a fault [-]: of 209 alarms with more evidence than that, two have a wrong name."""
LEAST_PROBABILITY = 0.1
"""Least probability of a fault [-]: a tenth to a fifth of the verdicts healthy are wrong where half of the bearings have faint faults."""


@dataclass
class Suspicion:
    """How long a fault has been suspected, or not."""

    seen: int = 0
    """Consecutive judgements with evidence above the threshold."""
    gone: int = 0
    """Consecutive judgements with evidence clearly below the threshold."""
    confirmed: bool = False


class Hysteresis:
    """A fault is confirmed by several consecutive judgements and cleared by more of them."""

    def __init__(self, confirm: int, release: int, release_margin: float) -> None:
        """Confirm after ``confirm`` judgements; clear after ``release`` of them, ``release_margin`` [dB] below the threshold."""
        self._confirm, self._release, self._margin = confirm, release, release_margin
        self.reset()

    def reset(self) -> None:
        """Forget all judgements."""
        self._suspicions: dict[Component, Suspicion] = {component: Suspicion() for component in COMPONENTS}
        self._clear = 0

    def verdict(self, excess: Mapping[Component, float]) -> Verdict:
        """Take the evidence for each component relative to its threshold [dB]; return the verdict."""
        for component, suspicion in self._suspicions.items():
            suspicion.seen = suspicion.seen + 1 if excess[component] >= 0.0 else 0
            suspicion.gone = suspicion.gone + 1 if excess[component] < -self._margin else 0
            suspicion.confirmed = (suspicion.confirmed or suspicion.seen >= self._confirm) and suspicion.gone < self._release
        confirmed = self.confirmed
        if len(confirmed) > 1:
            return "compound"
        if confirmed:
            return confirmed[0]
        suspected = any(suspicion.seen for suspicion in self._suspicions.values())
        self._clear = 0 if suspected and self._clear < self._confirm else self._clear + 1
        return "healthy" if self._clear >= self._confirm else "waiting"

    @property
    def confirmed(self) -> list[Component]:
        """Components with a confirmed fault."""
        return [component for component, suspicion in self._suspicions.items() if suspicion.confirmed]

    @property
    def suspected(self) -> list[Component]:
        """Components with evidence that is not confirmed yet."""
        return [component for component, suspicion in self._suspicions.items() if suspicion.seen and not suspicion.confirmed]


def confidence(verdict: Verdict, confirmed: list[Component], excess: Mapping[Component, float]) -> float:
    """Return the confidence in a verdict: 0.5 at a threshold, 0 without a verdict on the bearing; see `probability`."""
    if verdict in ("waiting", "sensor"):
        return 0.0
    if confirmed:
        return probability(max(0.0, min(excess[component] for component in confirmed)))
    return 1.0 - probability(min(0.0, max(excess.values())))


def probability(excess: float) -> float:
    """Return the probability of a fault from its evidence relative to the threshold [dB].

    It is 1 - 10^(-e/4) / 2 above the threshold, 0.9 at 2.8 dB, up to 0.99; and 10^(e/10) / 2 below it, but at least 0.1: a fault whose
    impacts are too faint for every band leaves no lines, however far the evidence is from the threshold. The page on the
    detector has the figures.
    """
    if excess >= 0.0:
        return min(MOST_PROBABILITY, float(1.0 - 0.5 * 10.0 ** (-excess / ALARM_DECADE)))
    return max(LEAST_PROBABILITY, float(0.5 * 10.0 ** (excess / HEALTHY_DECADE)))
