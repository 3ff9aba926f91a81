"""From findings to a verdict that does not flicker."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from dcrb_ros.schema.verdicts import COMPONENTS, Component, Verdict


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
    """Return the confidence in a verdict: 0.5 at a threshold, approaching 1 far from it, 0 without a verdict on the bearing."""
    if verdict in ("waiting", "sensor"):
        return 0.0
    margin = min(excess[component] for component in confirmed) if confirmed else -max(excess.values())
    return probability(max(0.0, margin))


def probability(excess: float) -> float:
    """Return the probability of a fault from its evidence relative to the threshold [dB]: 0.5 at 0, 0.9 at 7 and 0.1 at -7."""
    rare = 0.5 * 10.0 ** (-abs(excess) / 10.0)
    return float(1.0 - rare if excess >= 0.0 else rare)
