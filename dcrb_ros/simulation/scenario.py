"""A scenario: what happens to a bench, as a timeline in simulated time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dcrb_ros.bearing.runtime_change import altered, spoken
from dcrb_ros.runtime.refusal import Refusal, nearest
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import COMMANDED, flatten, overlaid, shipped_folder, validated
from dcrb_ros.settings.vehicle_speed import SPEED, replaced
from dcrb_ros.settings.yaml import read_yaml

TICK = 0.05
"""Simulated time between two sizes of what grows [s]; longer where that made more than `MOST_TICKS`."""
MOST_TICKS = 20_000
LONGEST = 1e6
"""Latest time of an event [s]."""
MOST_EVENTS = 10_000
RAMPS = {SPEED: "operating.speed_ramp", "operating.load": "operating.load_ramp", "operating.lateral_load": "operating.load_ramp"}
"""The slope at which each command is followed."""
KEYS = ("at", "over", "set")
STARTS = ("operating", "faults", "structure", "background", "sensor")
"""Groups of parameters that a scenario may begin with."""


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
    first: int
    """Time step at which it begins."""
    last: int
    """Time step at which it ends."""
    values: Mapping[str, Any]
    source: str

    @property
    def moving(self) -> bool:
        """Whether it takes its time."""
        return self.last > self.first

    @property
    def keys(self) -> set[str]:
        """What it sets, the ramps of speed and load among it."""
        return {*self.values, *(RAMPS[key] for key in self.values if key in RAMPS)}


def read_scenario(path: Path, configuration: Configuration) -> list[Event]:
    """Return the events of a scenario, a file or a shipped name, for a bench, in the order of time.

    Raises:
        Refusal: the file cannot be read or is no scenario, or the bench refuses what it asks for at some time.
    """
    story = read_story(path)
    return timeline(story, begun(story, configuration, str(path)), str(path))


def read_story(path: Path) -> Any:
    """Return a scenario, a file or a shipped name, as YAML gives it: what a recording keeps of it, and `timeline` takes."""
    return read_yaml(_found(path))


def _found(path: Path) -> Path:
    """Return the file of a scenario given by its path or a shipped name."""
    shipped = {file.stem: file for file in sorted((shipped_folder() / "scenarios").glob("*.yaml"))}
    if not path.is_file() and str(path) not in shipped:
        raise Refusal(f"there is no scenario '{path}': give a YAML file or one of {', '.join(shipped)}{nearest(str(path), shipped)}")
    return path if path.is_file() else shipped[str(path)]


def begun(tree: Any, configuration: Configuration, source: str) -> Configuration:
    """Return a bench as a scenario begins it: with the parameters that stand below ``start``, if any.

    Raises:
        Refusal: they are no parameters of operation, faults or sensor, or not possible.
    """
    start = tree.get("start", {}) if isinstance(tree, Mapping) else {}
    if not isinstance(start, Mapping):
        raise Refusal(f"{source}: 'start' must name parameters and their values, such as operating.speed_kmh: 20.0")
    values = {str(key): value for key, value in flatten(start).items()}
    for key in values:
        if not key.startswith(tuple(f"{group}." for group in STARTS)):
            raise Refusal(f"{source}: start: {key} is no part of a scenario; it may begin with {', '.join(STARTS)}")
    values = replaced(values, configuration.operating.wheel_diameter, f"{source}: start")
    return validated(overlaid(flatten(configuration.model_dump()), values), Configuration, f"{source}: start") if values else configuration


def timeline(tree: Any, configuration: Configuration, source: str) -> list[Event]:
    """Return the events of a scenario as YAML gives it, for a bench as `begun`; see `read_scenario`."""
    if not isinstance(tree, Mapping) or set(tree) - {"start"} != {"timeline"} or not isinstance(tree["timeline"], list):
        raise Refusal(
            f"{source} is not a scenario: it must hold 'timeline:' and below it a list of entries with 'at' and 'set'; it may hold 'start:'"
        )
    if len(tree["timeline"]) > MOST_EVENTS:
        raise Refusal(f"{source} has {len(tree['timeline'])} entries; a scenario has at most {MOST_EVENTS}")
    told = [_entry(item, configuration, f"{source}, entry {number}") for number, item in enumerate(tree["timeline"], 1)]
    # What is set at once comes before what begins to move from there.
    entries = sorted(told, key=lambda entry: (entry.first, entry.moving))
    _refuse_overlaps(entries)
    events: list[Event] = []
    present = configuration
    for moment in sorted({entry.first for entry in entries} | {entry.last for entry in entries}):
        for entry in entries:
            # What ends comes before what begins.
            if entry.moving and entry.last == moment:
                present = altered(present, entry.values, f"{entry.source} (at {entry.at + entry.over:g} s)")
        for entry in entries:
            if entry.first == moment:
                events += _events(entry, present)
                present = present if entry.moving else altered(present, entry.values, f"{entry.source} (at {entry.at:g} s)")
    return sorted(events, key=lambda event: event.step)


def _refuse_overlaps(entries: Sequence[_Entry]) -> None:
    """Refuse an entry, of all in their order, that sets what another still moves: one of them would be lost."""
    moved: dict[str, _Entry] = {}
    for entry in entries:
        for key in sorted(entry.keys & set(moved)):
            other = moved[key]
            if entry.first < other.last:
                raise Refusal(
                    f"{entry.source}: it sets {key} at {entry.at:g} s, which another entry moves from {other.at:g} s to "
                    f"{other.at + other.over:g} s; begin this one when that one ends, or let it end sooner"
                )
        if entry.moving:
            moved.update(dict.fromkeys(entry.keys, entry))


def _entry(item: Any, configuration: Configuration, source: str) -> _Entry:
    if not isinstance(item, Mapping) or not {"at", "set"} <= set(item):
        raise Refusal(f"{source}: it must have 'at' [s] and 'set', and may have 'over' [s]")
    for key in item:
        if key not in KEYS:
            raise Refusal(f"{source}: unknown key '{key}'{nearest(str(key), KEYS)}; an entry has 'at', 'set' and 'over'")
    if not isinstance(item["set"], Mapping) or not item["set"]:
        raise Refusal(f"{source}: 'set' must name parameters and their values, such as faults.outer_1.width: 0.002")
    given = {str(key): value for key, value in flatten(item["set"]).items()}
    values = replaced(given, configuration.operating.wheel_diameter, source)
    if "time_scale" in values:
        raise Refusal(f"{source}: time_scale is no part of a scenario, which goes by simulated time; give it to the bench")
    at, over = _seconds(item["at"], "at", source), _seconds(item.get("over", 0.0), "over", source)
    first, last = (first_step(seconds, configuration.step_rate) for seconds in (at, at + over))
    return _Entry(at, over, first, last, values, source)


def _seconds(value: Any, key: str, source: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= LONGEST:
        raise Refusal(f"{source}: {key} = {value!r} is not a simulated time within 0 .. {LONGEST:g} s")
    return float(value)


def first_step(seconds: float, step_rate: int) -> int:
    """Return the first time step at or after a simulated time [s]."""
    exact = seconds * step_rate
    near = round(exact)
    return near if abs(exact - near) < 1e-3 else math.ceil(exact)


def _events(entry: _Entry, present: Configuration) -> Iterator[Event]:
    """Yield an entry's events, the bench being as it is at its beginning."""
    if not entry.moving:
        yield Event(entry.first, entry.values, f"scenario: {spoken(entry.values)}")
        return
    before = flatten(present.model_dump())
    altered(present, entry.values, f"{entry.source} (at {entry.at + entry.over:g} s)")
    for key, value in entry.values.items():
        if not isinstance(value, float) or (key.startswith("operating.") and key not in COMMANDED):
            raise Refusal(f"{entry.source}: {key} cannot change 'over' {entry.over:g} s: it changes at once or not at all")
    ramped = {key: value for key, value in entry.values.items() if key in COMMANDED}
    grown = {key: value for key, value in entry.values.items() if key not in COMMANDED}
    slopes = _slopes(entry, ramped, before)
    altered(present, slopes, f"{entry.source} (from {entry.at:g} s to {entry.at + entry.over:g} s)")
    yield from _ramps(entry, ramped, slopes, before)
    yield from _growth(entry, grown, before)


def _slopes(entry: _Entry, values: Mapping[str, float], before: Mapping[str, Any]) -> dict[str, float]:
    """Return the ramps by which speeds and loads take the entry's time; of two loads, the one that changes more does."""
    slopes: dict[str, float] = {}
    for key, value in values.items():
        slope = abs(value - before[key]) / entry.over
        slopes[RAMPS[key]] = max(slope, slopes.get(RAMPS[key], 0.0))
    return {key: slope for key, slope in slopes.items() if slope > 0.0}


def _ramps(entry: _Entry, values: Mapping[str, float], slopes: Mapping[str, float], before: Mapping[str, Any]) -> Iterator[Event]:
    """Yield the begin and the end of speeds and loads that change at one slope each; the ramps of before hold again at the end."""
    if slopes:
        yield Event(entry.first, {**slopes, **values}, f"scenario: {spoken(values)} over {entry.over:g} s begins")
        yield Event(entry.last, {key: before[key] for key in slopes}, f"scenario: {spoken(values)}")


def _growth(entry: _Entry, values: Mapping[str, float], before: Mapping[str, Any]) -> Iterator[Event]:
    """Yield the sizes of what grows, at equal steps between its begin and its end."""
    if not values:
        return
    first, last = entry.first, entry.last
    count = max(1, min(MOST_TICKS, math.floor(entry.over / TICK)))
    for k in range(1, count):
        share = k / count
        sizes = {key: before[key] + share * (value - before[key]) for key, value in values.items()}
        step = first + (last - first) * k // count
        yield Event(step, sizes, f"scenario: {spoken(values)} over {entry.over:g} s begins" if k == 1 else "")
    yield Event(last, values, f"scenario: {spoken(values)}")
