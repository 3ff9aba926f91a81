"""The faults of a run over time, and the verdicts that they make correct."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from dcrb_ros.bearing.runtime_change import altered
from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import FaultClass, contradicts
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.scenario import ScheduledChange

ROUNDING = 1e-3
"""Time by which a change at the onset may precede it because changes are at steps [s]."""


@dataclass(frozen=True)
class FaultHistory:
    """Which faults are present, and from when on."""

    faults: tuple[tuple[float, tuple[str, ...]], ...]
    """Names of the faults that are present from a time on [s], in the order of time."""

    @property
    def is_healthy(self) -> bool:
        """Whether there is no fault at any time."""
        return not any(names for _, names in self.faults)

    @property
    def first_of_bearing(self) -> float | None:
        """Time from which a fault of the bearing is present [s]; None without one."""
        return next((time for time, names in self.faults if any(class_of([name]) != "sensor" for name in names)), None)

    def first(self, otherwise: float) -> float:
        """Return the time from which any fault is present [s], or another time without one."""
        return next((time for time, names in self.faults if names), otherwise)

    def onset_of(self, verdict: FaultClass, where: str) -> float:
        """Return the time from which a verdict is correct [s].

        Raises:
            Refusal: it never is.
        """
        onset = next((time for time, names in self.faults if class_of(names) == verdict), None)
        if onset is None:
            raise Refusal(f"{where}: nothing in it makes {verdict} correct: give 'fault', a timeline with a fault, or 'onset'")
        return onset

    def refuse_contradiction(self, verdict: FaultClass, onset: float, where: str) -> None:
        """Refuse a verdict that the faults contradict from the onset on [s]."""
        ends = [*(time for time, _ in self.faults[1:]), math.inf]
        present = [(time, class_of(names)) for (time, names), end in zip(self.faults, ends, strict=True) if end >= onset]
        correct = dict.fromkeys(now for _, now in present)
        if contradicts(verdict, correct):
            classes = " and then ".join(now for now in correct if now != "healthy") or "healthy"
        else:
            changed = (f"{now} from {time:g} s on" for time, now in present if time > onset - ROUNDING and contradicts(verdict, [now]))
            classes = next(changed, "")
        if classes:
            raise Refusal(
                f"{where}: verdict = {verdict} contradicts its faults, which make {classes} correct: change the verdict, or the faults in "
                "base, set, fault, scenario and timeline"
            )


def fault_history(configuration: Configuration, events: Sequence[ScheduledChange], where: str) -> FaultHistory:
    """Return the faults of a configuration with changes; ``where`` begins the sentence of an error.

    Raises:
        Refusal: a change is invalid.
    """
    present, faults = configuration, [(0.0, tuple(configuration.described_faults()))]
    pending: dict[str, Any] = {}
    for event in events:
        pending |= event.changes
        # Intermediate steps of a gradual change neither bring faults nor take them away.
        if event.event is not None and any(key.startswith(("faults.", "sensor.")) for key in pending):
            present, pending = altered(present, pending, where), {}
            faults.append((event.step / present.step_rate, tuple(present.described_faults())))
    return FaultHistory(tuple(faults))
