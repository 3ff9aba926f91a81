"""The verdicts of a fault detector: one vocabulary for faults, ground truth, diagnosis, exams and sweeps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal, get_args

Component = Literal["outer_ring", "inner_ring", "roller", "cage"]
"""Component of the bearing that a fault damages."""
Trouble = Literal["lubrication", "overheating"]
"""What is wrong with a bearing that is not damaged: its lubricant, or what heats it."""
FaultClass = Literal["healthy", Component, Trouble, "compound", "sensor"]
"""State of a bearing and its sensor: the verdict that is correct for them."""
Verdict = Literal[FaultClass, "waiting"]
"""Verdict of a detector; ``waiting`` until it has received enough signal."""

COMPONENTS: tuple[Component, ...] = get_args(Component)
TROUBLES: tuple[Trouble, ...] = get_args(Trouble)
BEARING_FAULTS: tuple[FaultClass, ...] = (*COMPONENTS, *TROUBLES, "compound")
"""Verdicts that name a fault of the bearing."""
FAULT_CLASSES: tuple[FaultClass, ...] = get_args(FaultClass)
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)

CHARACTERISTIC: dict[Component, str] = {"outer_ring": "BPFO", "inner_ring": "BPFI", "roller": "BSF", "cage": "FTF"}
"""Characteristic frequency that a fault of each component excites; a roller defect strikes at twice BSF."""

TITLES: dict[str, str] = {
    "healthy": "healthy",
    "outer_ring": "outer ring defect",
    "inner_ring": "inner ring defect",
    "roller": "roller defect",
    "cage": "cage fault",
    "lubrication": "lubrication fault",
    "overheating": "overheating",
    "compound": "several faults",
    "sensor": "sensor fault",
    "waiting": "waiting",
}
"""Verdicts in words."""


def title_of(verdict: str, scores: Mapping[str, float]) -> str:
    """Return a verdict in words; several faults are named: those above their thresholds, at least the two with the largest scores [dB]."""
    title = TITLES.get(verdict, verdict)
    if verdict != "compound" or len(scores) < 2:
        return title
    ranked = sorted(scores, key=lambda component: -scores[component])
    named = ranked[: max(2, sum(score >= 0.0 for score in scores.values()))]
    return f"{title}: {', '.join(TITLES.get(component, component) for component in named)}"


def is_alarm(verdict: str) -> bool:
    """Return whether a verdict reports a fault, of the bearing or of the sensor."""
    return verdict not in ("healthy", "waiting")


def fault_class(faults: Iterable[FaultClass]) -> FaultClass:
    """Return the class of a bearing with several faults, given the class of each.

    A faulty sensor hides the bearing; faults of different components make ``compound``; no fault makes ``healthy``.
    """
    found = set(faults) - {"healthy"}
    if "sensor" in found:
        return "sensor"
    return "compound" if len(found) > 1 else next(iter(found), "healthy")
