"""Scenarios that change nothing in their run: empty ones, and those that begin after its end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from dcrb_ros.schema.refusal import Refusal


def refuse_late(tree: Any, end: float | None, scenario: str, remedy: str) -> None:
    """Refuse a scenario that changes nothing in a run of ``end`` [s]: it has no ``start``, and no entry before the end; it may be longer.

    Args:
        tree: the scenario as parsed from YAML; an invalid one is left to `dcrb_ros.simulation.scenario`.
        end: length of the run [s]; None for an endless one.
        scenario: its name, as the beginning of a sentence.
        remedy: what to change.
    """
    timeline = tree.get("timeline") if isinstance(tree, Mapping) and not tree.get("start") else None
    entries = timeline if isinstance(timeline, list) else []
    if tree is None or timeline == []:
        raise Refusal(f"{scenario} changes nothing: it has no 'start', and its timeline has no entry; give one, or leave the scenario out")
    times = [entry.get("at") if isinstance(entry, Mapping) else None for entry in entries]
    late = [] if end is None else [at for at in times if isinstance(at, (int, float)) and end <= at < math.inf]
    if times and len(late) == len(times):
        raise Refusal(f"{scenario} changes nothing in a run of {end:g} s, its first entry is at {min(late):g} s: {remedy}")
