"""A scenario: what happens to a bench, as a timeline in simulated time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dcrb_ros.alteration import altered, spoken
from dcrb_ros.configuration import Configuration
from dcrb_ros.configuration_file import flatten, read_yaml, shipped_folder
from dcrb_ros.refusal import Refusal, nearest

TICK = 0.05
"""Simulated time between two sizes of what grows [s]; longer where that made more than `MOST_TICKS`."""
MOST_TICKS = 20_000
LONGEST = 1e6
"""Latest time of an event [s]."""
MOST_EVENTS = 10_000
KEYS = ("at", "over", "set")


@dataclass(frozen=True)
class Event:
    """A change of parameters at a time step."""

    step: int
    """It takes effect from this step on, whatever the block size."""
    changes: Mapping[str, Any]
    """Dotted keys and their new values."""
    words: str
    """What the ground truth says of it; empty for the steps of a growth between its ends."""


@dataclass(frozen=True)
class _Entry:
    """An entry of the file: at a time, a set of values, reached at once or linearly over a time."""

    at: float
    over: float
    values: Mapping[str, Any]
    source: str


def read_scenario(path: Path, configuration: Configuration) -> list[Event]:
    """Return the events of a scenario, a file or a shipped name, for a bench, in the order of time.

    Raises:
        Refusal: the file cannot be read or is no scenario, or the bench refuses what it asks for at some time.
    """
    return timeline(read_story(path), configuration, str(path))


def read_story(path: Path) -> Any:
    """Return a scenario, a file or a shipped name, as YAML gives it: what a recording keeps of it, and `timeline` takes."""
    return read_yaml(_found(path))


def _found(path: Path) -> Path:
    """Return the file of a scenario given by its path or a shipped name."""
    shipped = {file.stem: file for file in sorted((shipped_folder() / "scenarios").glob("*.yaml"))}
    if not path.is_file() and str(path) not in shipped:
        raise Refusal(f"there is no scenario '{path}': give a YAML file or one of {', '.join(shipped)}{nearest(str(path), shipped)}")
    return path if path.is_file() else shipped[str(path)]


def timeline(tree: Any, configuration: Configuration, source: str) -> list[Event]:
    """Return the events of a scenario as YAML gives it; see `read_scenario`."""
    if not isinstance(tree, Mapping) or set(tree) != {"timeline"} or not isinstance(tree["timeline"], list):
        raise Refusal(f"{source} is not a scenario: it must hold 'timeline:' and below it a list of entries with 'at' and 'set'")
    if len(tree["timeline"]) > MOST_EVENTS:
        raise Refusal(f"{source} has {len(tree['timeline'])} entries; a scenario has at most {MOST_EVENTS}")
    entries = [_entry(item, f"{source}, entry {number}") for number, item in enumerate(tree["timeline"], 1)]
    events: list[Event] = []
    moments = sorted({entry.at for entry in entries} | {entry.at + entry.over for entry in entries})
    present = configuration
    for moment in moments:
        for entry in entries:
            # What ends comes before what begins.
            if entry.over and entry.at + entry.over == moment:
                present = altered(present, entry.values, f"{entry.source} (at {moment:g} s)")
        for entry in entries:
            if entry.at == moment:
                events += _events(entry, present, configuration.step_rate)
                present = present if entry.over else altered(present, entry.values, f"{entry.source} (at {moment:g} s)")
    return sorted(events, key=lambda event: event.step)


def _entry(item: Any, source: str) -> _Entry:
    if not isinstance(item, Mapping) or not {"at", "set"} <= set(item):
        raise Refusal(f"{source}: it must have 'at' [s] and 'set', and may have 'over' [s]")
    for key in item:
        if key not in KEYS:
            raise Refusal(f"{source}: unknown key '{key}'{nearest(str(key), KEYS)}; an entry has 'at', 'set' and 'over'")
    if not isinstance(item["set"], Mapping) or not item["set"]:
        raise Refusal(f"{source}: 'set' must name parameters and their values, such as faults.outer_1.width: 0.002")
    values = {str(key): value for key, value in flatten(item["set"]).items()}
    if "time_scale" in values:
        raise Refusal(f"{source}: time_scale is no part of a scenario, which goes by simulated time; give it to the bench")
    return _Entry(_seconds(item["at"], "at", source), _seconds(item.get("over", 0.0), "over", source), values, source)


def _seconds(value: Any, key: str, source: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= LONGEST:
        raise Refusal(f"{source}: {key} = {value!r} is not a simulated time within 0 .. {LONGEST:g} s")
    return float(value)


def first_step(seconds: float, step_rate: int) -> int:
    """Return the first time step at or after a simulated time [s]."""
    exact = seconds * step_rate
    near = round(exact)
    return near if abs(exact - near) < 1e-3 else math.ceil(exact)


def _events(entry: _Entry, present: Configuration, step_rate: int) -> Iterator[Event]:
    """Yield an entry's events, the bench being as it is at its beginning."""
    first, last = first_step(entry.at, step_rate), first_step(entry.at + entry.over, step_rate)
    if last <= first:
        yield Event(first, entry.values, f"scenario: {spoken(entry.values)}")
        return
    before = flatten(present.model_dump())
    altered(present, entry.values, f"{entry.source} (at {entry.at + entry.over:g} s)")
    for key, value in entry.values.items():
        if not isinstance(value, float) or key.startswith("operating."):
            raise Refusal(
                f"{entry.source}: {key} cannot change 'over' {entry.over:g} s: "
                + ("operating.speed_ramp and load_ramp say how it follows" if key.startswith("operating.") else "it is no decimal number")
            )
    count = max(1, min(MOST_TICKS, math.floor(entry.over / TICK)))
    for k in range(1, count):
        share = k / count
        sizes = {key: before[key] + share * (value - before[key]) for key, value in entry.values.items()}
        step = first + (last - first) * k // count
        yield Event(step, sizes, f"scenario: {spoken(entry.values)} over {entry.over:g} s begins" if k == 1 else "")
    yield Event(last, entry.values, f"scenario: {spoken(entry.values)}")
