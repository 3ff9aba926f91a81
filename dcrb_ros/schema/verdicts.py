"""The verdicts of a fault detector: one vocabulary for faults, ground truth, diagnosis, exams and sweeps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias


class FaultVerdict(NamedTuple):
    """A verdict that names a fault."""

    kind: Literal["component", "trouble", "several", "sensor"]
    """Whether a component is damaged, the bearing is in trouble without damage, it has several faults, or the sensor is faulty."""
    title: str
    """The verdict in words."""
    delay: float
    """Longest detection delay that an exam allows by default [s]."""
    colour: str
    """Colour in figures."""
    frequency: str = ""
    """Characteristic frequency that a damaged component excites; a roller defect strikes at twice BSF."""


FAULTS: dict[str, FaultVerdict] = {
    "outer_ring": FaultVerdict("component", "outer ring defect", 5.0, "#1f6fb4", "BPFO"),
    "inner_ring": FaultVerdict("component", "inner ring defect", 5.0, "#e07b00", "BPFI"),
    "roller": FaultVerdict("component", "roller defect", 5.0, "#2a9d5c", "BSF"),
    "cage": FaultVerdict("component", "cage fault", 20.0, "#a23b72", "FTF"),
    "lubrication": FaultVerdict("trouble", "lubrication fault", 20.0, "#b8860b"),
    "overheating": FaultVerdict("trouble", "overheating", 20.0, "#c1292e"),
    "compound": FaultVerdict("several", "several faults", 5.0, "#6b5b95"),
    "sensor": FaultVerdict("sensor", "sensor fault", 5.0, "#8a8a8a"),
}
"""Every verdict that names a fault. Limits, colours, titles and the lists below follow from this table."""


def _of_kind(*kinds: str) -> tuple[str, ...]:
    return tuple(name for name, fault in FAULTS.items() if fault.kind in kinds)


COMPONENTS = _of_kind("component")
TROUBLES = _of_kind("trouble")
BEARING_FAULTS = _of_kind("component", "trouble", "several")
"""Verdicts that name a fault of the bearing."""
FAULT_CLASSES = ("healthy", *FAULTS)
VERDICTS = (*FAULT_CLASSES, "waiting")

if TYPE_CHECKING:  # literals for a type checker cannot follow from a table
    Component: TypeAlias = str
    Trouble: TypeAlias = str
    FaultClass: TypeAlias = str
    Verdict: TypeAlias = str
else:
    Component = Literal[COMPONENTS]
    """Component of the bearing that a fault damages."""
    Trouble = Literal[TROUBLES]
    """What is wrong with a bearing that is not damaged: its lubricant, or what heats it."""
    FaultClass = Literal[FAULT_CLASSES]
    """State of a bearing and its sensor: the verdict that is correct for them."""
    Verdict = Literal[VERDICTS]
    """Verdict of a detector; ``waiting`` until it has received enough signal."""

CHARACTERISTIC = {name: FAULTS[name].frequency for name in COMPONENTS}
"""Characteristic frequency of each component."""
TITLES = {"healthy": "healthy", **{name: fault.title for name, fault in FAULTS.items()}, "waiting": "waiting"}
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
    present = set(faults) - {"healthy"}
    if "sensor" in present:
        return "sensor"
    return "compound" if len(present) > 1 else next(iter(present), "healthy")


def contradicts(verdict: FaultClass, correct: Iterable[FaultClass]) -> bool:
    """Return whether faults of some classes contradict a verdict that an exam expects.

    A sound bearing may be in trouble or have a sensor that misreads, and an exam may give a trouble another name.
    """
    faults = set(correct) - {"healthy"}
    if verdict == "healthy":
        return bool(faults)
    if verdict in TROUBLES:
        return bool(faults) and faults.isdisjoint(TROUBLES)
    return verdict not in faults and (bool(faults) or verdict in COMPONENTS)
