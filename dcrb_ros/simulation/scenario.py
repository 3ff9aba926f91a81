"""Scenarios: changes of speed, load, faults and sensor on a timeline in simulated time.

A new key under ``set`` needs ``run_time=True`` on its field, and no code here. Keys of faults, the sensor chain and the thermal network
take effect by that; for a key of another group, `simulation.loop.Simulation._alter` has the effect.

A new kind of entry, with a key beside those in `KEYS`, needs this key there, a check in `_entry`, a field of `Entry` and of
`ScheduledChange`, and its changes in `_changes`. Its event is in `stream.events`, the text of the event in `stream.event_text`, and its
effect in `simulation.loop.Simulation._apply_scheduled`. For vehicles, `vehicle.scenario` turns entries into changes. The onset in
`exam.exam_file` and the turns in `exam.revolutions` read the changes, too.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dcrb_ros.bearing.runtime_change import altered
from dcrb_ros.measurement.stages.machine_background import MachineBackgroundParameters, speed_of_level
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import changed, flatten
from dcrb_ros.settings.parameters import COMMANDED
from dcrb_ros.settings.shipped import find_shipped
from dcrb_ros.settings.vehicle_speed import SPEED, SPEED_KMH, WHEEL_DIAMETER
from dcrb_ros.stream.events import ScenarioEvent
from dcrb_ros.stream.late_scenario import refuse_late
from dcrb_ros.text.yaml import read_yaml

TICK = 0.05
"""Simulated time between two steps of a gradual change [s]; longer if there would be more than `MAX_TICKS`."""
MAX_TICKS = 20_000
MAX_CHANGES = 100_000
"""Steps of all gradual changes together."""
MAX_TIME = 1e6
"""Latest time of an entry [s]."""
MAX_ENTRIES = 3_000
"""Entries of a timeline; each is checked with the whole configuration, which takes 0.4 ms."""
RAMPS = {SPEED: "operating.speed_ramp", "operating.load": "operating.load_ramp", "operating.lateral_load": "operating.load_ramp"}
"""The ramp at which each target is approached."""
MOST_REHEARSED = 500
"""Intermediate values of a gradual change that are checked beforehand, at most [-]; a check takes half a millisecond."""
KEYS = ("at", "over", "set")
START_GROUPS = ("operating", "thermal", "faults", "structure", "background", "sensor")
"""Groups of parameters that are allowed under ``start``."""


@dataclass(frozen=True)
class ScheduledChange:
    """A change of parameters at a time step."""

    step: int
    """First time step with the new values, independent of the block size."""
    changes: Mapping[str, Any]
    """Dotted keys and their new values."""
    event: ScenarioEvent | None
    """The event to report; none for the intermediate steps of a gradual change."""


def checked_changes(scenario: object) -> tuple[ScheduledChange, ...]:
    """Return the scheduled changes of a scenario.

    Raises:
        Refusal: it is not an iterable of them.
    """
    changes = tuple(scenario) if isinstance(scenario, Iterable) else (scenario,)
    if not all(isinstance(change, ScheduledChange) for change in changes):
        raise Refusal(
            f"scenario = {scenario!r} is not a list of scheduled changes: dcrb_ros.simulate takes a scenario by name, file or content"
        )
    return changes


@dataclass(frozen=True)
class Entry:
    """An entry of the file: values that are set at a time, or approached linearly over a duration."""

    at: float
    """Simulated time [s]."""
    over: float
    """Duration of the change [s]; 0 for an immediate one."""
    first: int
    """Time step at which it begins."""
    last: int
    """Time step at which it ends."""
    values: Mapping[str, Any]
    """Dotted keys and their values at the end."""
    source: str
    """The entry's name in error messages."""

    @property
    def gradual(self) -> bool:
        """Whether the change extends over several time steps."""
        return self.last > self.first

    @property
    def keys(self) -> set[str]:
        """The keys it sets, including the ramps of speed and load."""
        return {*self.values, *(RAMPS[key] for key in self.values if key in RAMPS)}


def read_scenario(path: Path, configuration: Configuration) -> list[ScheduledChange]:
    """Return the changes of a scenario in the order of time.

    Args:
        path: a file, or the name of a shipped scenario.
        configuration: the bench, before the values under ``start``.

    Raises:
        Refusal: the file cannot be read or is not a scenario, or one of its changes is invalid for the bench.
    """
    tree = read_scenario_file(path)
    return scheduled_changes(tree, starting_configuration(tree, configuration, str(path)), str(path))


def read_scenario_file(path: Path) -> Any:
    """Return a scenario, a file or a shipped name, as parsed from YAML; recordings contain it in this form."""
    return read_yaml(find_shipped("scenario", path))


def scenario_of_run(scenario: Path | None, duration: float | None) -> Any:
    """Return a scenario as parsed from YAML, None without one; refuse one that changes nothing in ``duration`` [s], endless without one."""
    if scenario is None:
        return None
    tree = read_scenario_file(scenario)
    refuse_late(tree, duration, f"the scenario {scenario}", "increase --duration or leave out --scenario")
    return tree


def starting_configuration(tree: Any, configuration: Configuration, source: str) -> Configuration:
    """Return the configuration at the start of a scenario: with the values under ``start``, if there are any.

    A level of the healthy bearing keeps the speed of ``configuration``.

    Raises:
        Refusal: a key is not in one of `START_GROUPS`, a value is invalid, or a bench at rest has a level without a speed.
    """
    start = tree.get("start", {}) if isinstance(tree, Mapping) else {}
    if not isinstance(start, Mapping):
        raise Refusal(f"{source}: 'start' must name parameters and their values, such as operating.speed_kmh: 20.0")
    values = _values(start, configuration, f"{source}: start")
    for key in values:
        if key.startswith("vehicle."):
            raise Refusal(f"{source} is a scenario of a vehicle: it needs --vehicle")
        if not key.startswith(tuple(f"{group}." for group in START_GROUPS)):
            raise Refusal(f"{source}: start: {key} cannot be set by a scenario; give keys of {', '.join(START_GROUPS)}")
    if not values:
        return configuration
    starting = changed(configuration, values, f"{source}: start")
    background = starting.measurement.parameters[MachineBackgroundParameters]
    if background.healthy_level == 0.0:
        return starting
    return changed(starting, {"structure.healthy_speed": speed_of_level(background, configuration.operating.speed)}, source)


def _values(tree: Mapping[Any, Any], configuration: Configuration, source: str) -> dict[str, Any]:
    """Return the parameters that a scenario sets, with dotted keys, and with the shaft's speed in place of one in km/h.

    Raises:
        Refusal: both speeds are given, or the speed in km/h is not a number within its range.
    """
    values = {str(key): value for key, value in flatten(tree).items()}
    if SPEED_KMH not in values:
        return values
    if SPEED in values:
        raise Refusal(f"{source}: it sets {SPEED} and {SPEED_KMH}; give one of them")
    vehicle = {key: values[key] for key in (SPEED_KMH, WHEEL_DIAMETER) if key in values}
    speed = changed(configuration, vehicle, source).operating.speed
    # In a configuration, 0 km/h stands for no speed in km/h. In a scenario, the vehicle stops.
    return {SPEED: speed if values.pop(SPEED_KMH) else 0.0, **values}


def scheduled_changes(tree: Any, configuration: Configuration, source: str) -> list[ScheduledChange]:
    """Return the changes of a scenario in the order of time.

    Args:
        tree: the scenario as parsed from YAML.
        configuration: the bench as returned by `starting_configuration`.
        source: the scenario's name in error messages.

    Raises:
        Refusal: the tree is not a scenario, or one of its changes is invalid for the bench.
    """

    def parameters(given: Mapping[Any, Any], name: str) -> dict[str, Any]:
        return _values(given, configuration, name)

    return planned_changes(timeline_entries(tree, source, configuration.step_rate, parameters), configuration, source)


def timeline_entries(
    tree: Any, source: str, step_rate: int, values_of: Callable[[Mapping[Any, Any], str], Mapping[str, Any]]
) -> list[Entry]:
    """Return the entries of a scenario in the order of time.

    Args:
        tree: the scenario as parsed from YAML.
        source: the scenario's name in error messages.
        step_rate: rate of the time steps [Hz].
        values_of: gives the values that an entry sets by dotted keys, for its mapping and its name in error messages.

    Raises:
        Refusal: the tree is not a scenario, or two entries change the same parameter at the same time.
    """
    if not isinstance(tree, Mapping) or set(tree) - {"start"} != {"timeline"} or not isinstance(tree["timeline"], list):
        raise Refusal(
            f"{source} is not a scenario: give 'timeline:' with a list of entries that have 'at' and 'set', and optionally 'start:'"
        )
    if len(tree["timeline"]) > MAX_ENTRIES:
        raise Refusal(f"{source} has {len(tree['timeline'])} entries; a scenario has at most {MAX_ENTRIES}")
    parsed = [_entry(item, f"{source}, entry {number}", step_rate, values_of) for number, item in enumerate(tree["timeline"], 1)]
    # Immediate changes come before gradual changes that begin at the same time.
    entries = sorted(parsed, key=lambda entry: (entry.first, entry.gradual))
    _refuse_overlaps(entries)
    return entries


def planned_changes(entries: Sequence[Entry], configuration: Configuration, source: str) -> list[ScheduledChange]:
    """Return the changes of a bench by the entries of a scenario, in the order of time.

    Raises:
        Refusal: one of the changes is invalid for the bench.
    """
    _refuse_many_steps(entries, source)
    beginning, ending = defaultdict[int, list[Entry]](list), defaultdict[int, list[Entry]](list)
    for entry in entries:
        beginning[entry.first].append(entry)
        if entry.gradual:
            ending[entry.last].append(entry)
    planned: list[tuple[ScheduledChange, Entry]] = []
    present = configuration
    for moment in sorted({*beginning, *ending}):
        # Gradual changes end before others begin at the same time.
        for entry in ending.get(moment, ()):
            present = altered(present, entry.values, f"{entry.source} (at {entry.at + entry.over:g} s)")
        for entry in beginning.get(moment, ()):
            planned += [(change, entry) for change in _changes(entry, present)]
            present = present if entry.gradual else altered(present, entry.values, f"{entry.source} (at {entry.at:g} s)")
    planned.sort(key=lambda item: item[0].step)
    _rehearse(planned, configuration)
    return [change for change, _ in planned]


def _rehearse(planned: Sequence[tuple[ScheduledChange, Entry]], configuration: Configuration) -> None:
    """Refuse a gradual change on whose way the bench becomes impossible, together with whatever else changes meanwhile."""
    between = Counter(entry.source for change, entry in planned if change.event is None)
    passed: Counter[str] = Counter()
    present = configuration
    for change, entry in planned if between else ():
        if change.event is None:
            passed[entry.source] += 1
            if passed[entry.source] % math.ceil(between[entry.source] / MOST_REHEARSED):
                continue
        present = altered(present, change.changes, f"{entry.source} (at {change.step / configuration.step_rate:.6g} s)")


def _refuse_many_steps(entries: Sequence[Entry], source: str) -> None:
    """Refuse gradual changes of more than `MAX_CHANGES` steps together."""
    steps = sum(_steps(entry) for entry in entries if set(entry.values) - set(COMMANDED))
    if steps > MAX_CHANGES:
        raise Refusal(
            f"{source}: its gradual changes take {steps} steps of {TICK:g} s or longer; a scenario has at most {MAX_CHANGES}: "
            "shorten them, or give fewer"
        )


def _steps(entry: Entry) -> int:
    """Return the number of steps of a gradual change."""
    return max(1, min(MAX_TICKS, math.floor(entry.over / TICK)))


def _refuse_overlaps(entries: Sequence[Entry]) -> None:
    """Refuse an entry that sets a key which another entry sets at the same time or is still changing: one would have no effect."""
    changing: dict[str, Entry] = {}
    changed_at: dict[tuple[str, int], Entry] = {}
    for entry in entries:
        for key in entry.values if not entry.gradual else ():
            other = changed_at.get((key, entry.first))
            if other is not None and other.values[key] != entry.values[key]:
                raise Refusal(
                    f"{entry.source}: it sets {key} to {entry.values[key]} at {entry.at:.9g} s, and {other.source} to {other.values[key]} "
                    "in the same time step: leave out one of them"
                )
            changed_at[key, entry.first] = entry
        for key in sorted(entry.keys & set(changing)):
            other = changing[key]
            if entry.first < other.last:
                raise Refusal(
                    f"{entry.source}: it sets {key} at {entry.at:g} s, which another entry changes from {other.at:g} s to "
                    f"{other.at + other.over:g} s; begin this one when the other ends, or end the other earlier"
                )
        if entry.gradual:
            changing.update(dict.fromkeys(entry.keys, entry))


def _entry(item: Any, source: str, step_rate: int, values_of: Callable[[Mapping[Any, Any], str], Mapping[str, Any]]) -> Entry:
    if not isinstance(item, Mapping) or not {"at", "set"} <= set(item):
        raise Refusal(f"{source}: it must have 'at' [s] and 'set', and may have 'over' [s]")
    for key in item:
        if key not in KEYS:
            raise Refusal(f"{source}: unknown key '{key}'{nearest(str(key), KEYS)}; an entry has 'at', 'set' and 'over'")
    if not isinstance(item["set"], Mapping) or not item["set"]:
        raise Refusal(f"{source}: 'set' must name parameters and their values, such as faults.outer_1.width: 0.002")
    values = values_of(item["set"], source)
    if "time_scale" in values:
        raise Refusal(f"{source}: time_scale cannot be set by a scenario, whose times are simulated; set it in the configuration")
    at, over = _seconds(item["at"], "at", source), _seconds(item.get("over", 0.0), "over", source)
    first, last = (first_step(seconds, step_rate) for seconds in (at, at + over))
    return Entry(at, over, first, last, values, source)


def _seconds(value: Any, key: str, source: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= MAX_TIME:
        raise Refusal(f"{source}: {key} = {value!r} is not a simulated time within 0 .. {MAX_TIME:g} s")
    return float(value)


def first_step(seconds: float, step_rate: int) -> int:
    """Return the first time step at or after a simulated time [s]."""
    exact = seconds * step_rate
    near = round(exact)
    return near if abs(exact - near) < 1e-3 else math.ceil(exact)


def _changes(entry: Entry, present: Configuration) -> Iterator[ScheduledChange]:
    """Yield the changes of an entry; ``present`` is the configuration at its beginning."""
    if not entry.gradual:
        yield ScheduledChange(entry.first, entry.values, ScenarioEvent(entry.values))
        return
    before = flatten(present.model_dump())
    altered(present, entry.values, f"{entry.source} (at {entry.at + entry.over:g} s)")
    values = {key: float(value) if type(value) is int and isinstance(before[key], float) else value for key, value in entry.values.items()}
    for key, value in values.items():
        if not isinstance(value, float) or (key.startswith("operating.") and key not in COMMANDED):
            raise Refusal(f"{entry.source}: {key} cannot change gradually 'over' {entry.over:g} s: leave out 'over'")
    ramped = {key: value for key, value in values.items() if key in COMMANDED}
    grown = {key: value for key, value in values.items() if key not in COMMANDED}
    slopes = _slopes(entry, ramped, before)
    altered(present, slopes, f"{entry.source} (from {entry.at:g} s to {entry.at + entry.over:g} s)")
    yield from _ramps(entry, ramped, slopes, before)
    yield from _growth(entry, grown, before)


def _slopes(entry: Entry, values: Mapping[str, float], before: Mapping[str, Any]) -> dict[str, float]:
    """Return the ramps with which speed and load take the entry's duration; of two loads, the one that changes more."""
    slopes: dict[str, float] = {}
    for key, value in values.items():
        slope = abs(value - before[key]) / entry.over
        slopes[RAMPS[key]] = max(slope, slopes.get(RAMPS[key], 0.0))
    return {key: slope for key, slope in slopes.items() if slope > 0.0}


def _ramps(entry: Entry, values: Mapping[str, float], slopes: Mapping[str, float], before: Mapping[str, Any]) -> Iterator[ScheduledChange]:
    """Yield the start and the end of a gradual change of speed and load; at the end the previous ramps are restored."""
    if slopes:
        yield ScheduledChange(entry.first, {**slopes, **values}, ScenarioEvent(values, entry.over))
        yield ScheduledChange(entry.last, {key: before[key] for key in slopes}, ScenarioEvent(values))


def _growth(entry: Entry, values: Mapping[str, float], before: Mapping[str, Any]) -> Iterator[ScheduledChange]:
    """Yield the steps of parameters that change gradually, at equal intervals; the last one completes the change."""
    if not values:
        return
    first, last = entry.first, entry.last
    count = _steps(entry)
    for k in range(1, count):
        share = k / count
        sizes = {key: before[key] + share * (value - before[key]) for key, value in values.items()}
        step = first + (last - first) * k // count
        yield ScheduledChange(step, sizes, ScenarioEvent(values, entry.over) if k == 1 else None)
    yield ScheduledChange(last, values, ScenarioEvent(values))
