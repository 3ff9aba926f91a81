"""From evidence, judgement by judgement, to a verdict that does not flicker, and how a fault grows."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from dcrb_ros.diagnosis.evidence import KINDS, Kind
from dcrb_ros.diagnosis.parameters import DetectorParameters

Verdict = Literal["waiting", "healthy", "outer_ring", "inner_ring", "compound", "cage", "roller", "sensor"]


@dataclass
class Suspicion:
    """How long a fault has been seen, or not."""

    seen: int = 0
    """Judgements in a row with evidence beyond the threshold."""
    gone: int = 0
    """Judgements in a row with evidence clearly below it."""
    named: bool = False


class Judge:
    """Hysteresis: several judgements in a row name a fault, more of them clear it."""

    def __init__(self, parameters: DetectorParameters) -> None:
        self._parameters = parameters
        self._suspicions: dict[Kind, Suspicion] = {}
        self.forget()

    def forget(self) -> None:
        """Begin anew."""
        self._suspicions = {kind: Suspicion() for kind in KINDS}
        self._clear = 0

    def weigh(self, excess: Mapping[Kind, float]) -> Verdict:
        """Take the excess of evidence over the thresholds [dB]; return the verdict."""
        p = self._parameters
        for kind, suspicion in self._suspicions.items():
            suspicion.seen = suspicion.seen + 1 if excess[kind] >= 0.0 else 0
            suspicion.gone = suspicion.gone + 1 if excess[kind] < -p.release_margin else 0
            suspicion.named = (suspicion.named or suspicion.seen >= p.confirm) and suspicion.gone < p.release
        named = self.named
        if len(named) > 1:
            return "compound"
        if named:
            return named[0]
        self._clear = 0 if any(s.seen for s in self._suspicions.values()) and self._clear < p.confirm else self._clear + 1
        return "healthy" if self._clear >= p.confirm else "waiting"

    @property
    def named(self) -> list[Kind]:
        """Faults that are named now."""
        return [kind for kind, suspicion in self._suspicions.items() if suspicion.named]

    @property
    def suspected(self) -> list[Kind]:
        """Faults with evidence that is not confirmed yet."""
        return [kind for kind, suspicion in self._suspicions.items() if suspicion.seen and not suspicion.named]


def confidence(verdict: Verdict, named: list[Kind], excess: Mapping[Kind, float]) -> float:
    """Return the confidence in a verdict: 0.5 at a threshold, towards 1 far beyond it, 0 without a verdict on the bearing."""
    if verdict in ("waiting", "sensor"):
        return 0.0
    margin = min(excess[kind] for kind in named) if named else -max(excess.values())
    return float(1.0 - 0.5 * 10.0 ** (-max(0.0, margin) / 10.0))


FEWEST_POINTS = 4
"""Judgements that a trend is fitted to at least."""


class Trend:
    """The growth of a fault: a straight line through its severity in decibels."""

    def __init__(self, seconds: float, hop: float) -> None:
        """Look back over ``seconds``, a judgement every ``hop`` [s]."""
        self._points: deque[tuple[float, float]] = deque(maxlen=max(FEWEST_POINTS, round(seconds / hop)))
        self._verdict: Verdict = "waiting"

    def slope(self, time: float, verdict: Verdict, severity: float) -> float:
        """Take the severity [m/s^2] at a time [s]; return its growth since this verdict began [dB/min]."""
        if verdict != self._verdict or severity <= 0.0:
            self._points.clear()
            self._verdict = verdict
        if severity > 0.0:
            self._points.append((time, 20.0 * float(np.log10(severity))))
        if len(self._points) < FEWEST_POINTS:
            return 0.0
        times, levels = np.array(self._points).T
        spread = times - times.mean()
        return float(60.0 * (spread @ levels) / (spread @ spread))
