"""From findings to a verdict that does not flicker."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from dcrb_ros.schema.verdicts import COMPONENTS, Component, Verdict

ALARM_DECADE = 4.0
"""Evidence above the threshold that makes a wrong alarm ten times as rare [dB]: 3.8 fits 391 alarms, 2.2 to 3.9 those without one rig."""
HEALTHY_DECADE = 10.0
"""Distance below the threshold that makes a missed fault ten times as rare [dB]."""
MOST_PROBABILITY = 0.99
"""Largest probability of a fault [-]: of 209 alarms with more evidence than that, two have a wrong name."""
LEAST_PROBABILITY = 0.1
"""Least probability of a fault [-]: a tenth to a fifth of the verdicts healthy are wrong where half of the bearings have faint faults."""

STRONG = 2.8
"""Evidence above the threshold of which nine of ten alarms are right [dB]; see `probability`."""
LONG_ENOUGH = 2.5
"""Length of a signal from which it is named at the threshold if it is judged once, as a whole [s]."""
SCATTER = 1.2
"""Evidence that a shorter signal needs [dB]: its lines scatter by a decibel."""


@dataclass
class Suspicion:
    """Consecutive judgements with and without evidence, and whether they confirm a fault."""

    seen: int = 0
    """Consecutive judgements with evidence above the threshold."""
    gone: int = 0
    """Consecutive judgements with evidence clearly below the threshold."""
    confirmed: bool = False
    evidence: float = 0.0
    """Sum of the evidence above the threshold since the fault was first suspected [dB]."""

    def count(self, *, present: bool, absent: bool, confirm: float, release: int) -> bool:
        """Count a judgement; return whether ``confirm`` in a row confirm the fault and no ``release`` in a row have cleared it since."""
        self.seen = self.seen + 1 if present else 0
        self.gone = self.gone + 1 if absent else 0
        self.confirmed = (self.confirmed or self.seen >= confirm) and self.gone < release
        return self.confirmed


class Hysteresis:
    """A fault is confirmed by several consecutive judgements and cleared by more of them.

    Consecutive windows share most of their samples, so that weak evidence must last. At the threshold, where an alarm is as often wrong as
    right, it must last until the window has been renewed; from strong evidence on, whose alarms are right nine times out of ten, it need
    not; and in proportion between them. Two faults are both present only if they are suspected in the same judgement: where one
    explains the lines of the other and the next judgement has it the other way around, the one with more evidence counts.
    """

    def __init__(self, confirm: int, release: int, release_margin: float, persist: int = 1, related: Sequence[Component] = ()) -> None:
        """Confirm after ``confirm`` judgements with evidence, or up to ``persist`` with weak evidence.

        Clear after ``release`` judgements, ``release_margin`` [dB] below the evidence that counts. Judgements that suspect one or another
        of the ``related`` components confirm the one with more evidence in all of them.
        """
        self._confirm, self._release, self._margin, self._persist = confirm, release, release_margin, max(confirm, persist)
        self._related = tuple(related)
        self.reset()

    def reset(self) -> None:
        """Discard all judgements."""
        self._suspicions: dict[Component, Suspicion] = {component: Suspicion() for component in COMPONENTS}
        self._pairs = {frozenset(pair): Suspicion() for pair in itertools.combinations(COMPONENTS, 2)}
        self._any_related, self._shares = Suspicion(), dict.fromkeys(self._related, 0.0)
        """Whether any of the related components is suspected, and the evidence for each of them since [dB]."""
        self._clear = 0

    def verdict(self, excess: Mapping[Component, float], least: Mapping[Component, float] = MappingProxyType({})) -> Verdict:
        """Take the evidence for each component relative to its threshold and the ``least`` that counts [dB]; return the verdict."""
        required = {component: least.get(component, 0.0) for component in COMPONENTS}
        for component, suspicion in self._suspicions.items():
            self._update(suspicion, excess[component], required[component])
        for pair, suspicion in self._pairs.items():
            self._update(suspicion, min(excess[component] for component in pair), max(required[component] for component in pair))
        if self._related:
            self._update_related(excess, required)
        confirmed = self.confirmed
        if len(confirmed) > 1:
            return "compound"
        if confirmed:
            return confirmed[0]
        suspected = any(suspicion.seen for suspicion in self._suspicions.values())
        self._clear = 0 if suspected and self._clear < self._confirm else self._clear + 1
        return "healthy" if self._clear >= self._confirm else "waiting"

    def _update(self, suspicion: Suspicion, excess: float, least: float) -> None:
        """Count a judgement with that evidence, of which ``least`` counts [dB]."""
        present, absent = excess >= least, excess < least - self._margin
        suspicion.evidence += excess if present else 0.0
        weakness = max(0.0, 1.0 - suspicion.evidence / (suspicion.seen + 1) / STRONG)
        confirm = self._confirm + weakness * (self._persist - self._confirm)
        if not suspicion.count(present=present, absent=absent, confirm=confirm, release=self._release) and not suspicion.seen:
            suspicion.evidence = 0.0

    def _update_related(self, excess: Mapping[Component, float], required: Mapping[Component, float]) -> None:
        """Count a judgement of the related components by the one with most evidence above what it requires."""
        largest = max(self._related, key=lambda component: excess[component] - required[component])
        self._update(self._any_related, excess[largest], required[largest])
        for component in self._related:
            share = self._shares[component] + max(excess[component], 0.0)
            self._shares[component] = share if self._any_related.seen or self._any_related.confirmed else 0.0

    @property
    def confirmed(self) -> list[Component]:
        """Components with a confirmed fault, which were suspected together if there are several."""
        alone = [component for component, suspicion in self._suspicions.items() if suspicion.confirmed]
        if not alone and self._any_related.confirmed:
            return [max(self._shares, key=lambda component: self._shares[component])]
        if len(alone) < 2:
            return alone
        strongest = max(alone, key=lambda component: self._suspicions[component].evidence)
        return [component for component in alone if component == strongest or self._pairs[frozenset({component, strongest})].confirmed]

    @property
    def suspected(self) -> list[Component]:
        """Components with evidence that is not confirmed yet."""
        return [component for component, suspicion in self._suspicions.items() if suspicion.seen and not suspicion.confirmed]


def least_evidence(confirm: int, window: float, alarm_evidence: float) -> float:
    """Return the evidence above the threshold that counts [dB]: ``alarm_evidence`` while a bearing is watched.

    If a single judgement of a ``window`` [s] confirms a fault, as in a signal that is judged as a whole, weak evidence does so, too.
    """
    if confirm > 1:
        return alarm_evidence
    return 0.0 if window >= LONG_ENOUGH else min(SCATTER, alarm_evidence)


def strongest_of(excess: Mapping[Component, float], least: Mapping[Component, float]) -> Component:
    """Return the component with most evidence, among those with the ``least`` that counts if there are some [dB]."""
    return max(excess, key=lambda component: (excess[component] >= least.get(component, 0.0), excess[component]))


def shortfall(excess: float, least: float) -> str:
    """Return why the strongest evidence relative to its threshold names no fault, in words; ``least`` counts [dB]."""
    if excess < 0.0:
        return "no lines exceed all limits for a defect"
    if excess < least:
        return f"lines exceed all limits for a defect by {excess:.1f} dB, less than the {least:.1f} dB required"
    return "lines that exceed all limits for a defect are not confirmed yet"


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
