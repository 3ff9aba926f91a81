"""Scenarios of a vehicle: commands, slides, wheels and parameters of boxes on a timeline in simulated time.

The files are those of a bench (`dcrb_ros.simulation.scenario`) with keys as the vehicle's file has them: ``vehicle.speed_kmh``,
``axle_2.slide``, ``axle_1.left.faults.outer_1.width``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from dcrb_ros.measurement.stages.machine_background import MachineBackgroundParameters
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import flatten
from dcrb_ros.simulation.scenario import (
    MAX_CHANGES,
    MAX_TICKS,
    START_GROUPS,
    Entry,
    ScheduledChange,
    planned_changes,
    timeline_entries,
)
from dcrb_ros.vehicle.changes import RANGES, checked_command, of_model, sorted_changes
from dcrb_ros.vehicle.description import Vehicle
from dcrb_ros.vehicle.file import layered, vehicle_of
from dcrb_ros.vehicle.frame import FRAME
from dcrb_ros.vehicle.loads import check_loads

PREFIX = "vehicle."
SPEED, RAMP = "vehicle.speed_kmh", "vehicle.ramp"
STEEPEST = 3.0
"""Largest slope of a gradual change of the speed [m/s^2]."""


@dataclass(frozen=True)
class ScheduledSetting:
    """A change of the vehicle, of a slide or of a wheel at a frame."""

    frame: int
    """The frame that begins at or after its time; it acts from the end of that frame on."""
    key: str
    """Such as ``vehicle.curvature`` or ``axle_2.slide``; ``vehicle.ramp`` is that of the speed [m/s^2]."""
    value: Any


@dataclass(frozen=True)
class VehicleScenario:
    """What changes during a run of a vehicle."""

    boxes: Mapping[str, tuple[ScheduledChange, ...]]
    """Changes of the parameters of each box, at their time steps."""
    settings: tuple[ScheduledSetting, ...]
    """All other changes, in the order of time."""
    content: Any = None
    """The scenario as parsed from YAML, from which a recording is simulated again."""


def starting_parameters(tree: Any, parameters: Mapping[str, Any], source: str) -> dict[str, Any]:
    """Return the parameters of a vehicle at the start of a scenario, None for none: with the values under ``start``, if there are any.

    A level of a healthy box keeps the speed of the vehicle without ``start``.

    Raises:
        Refusal: ``start`` has no parameters, or those of a bearing; or the vehicle without it is invalid, and a box has such a level.
    """
    start = tree.get("start", {}) if isinstance(tree, Mapping) else {}
    if not isinstance(start, Mapping):
        raise Refusal(f"{source}: 'start' must name parameters and their values, such as vehicle.speed_kmh: 60.0")
    if any(str(key).partition(".")[0] in START_GROUPS for key in start):
        raise Refusal(f"{source} is a scenario of a bearing, not of a vehicle: give one with keys of a vehicle's file, such as bogie_ride")
    starting = layered(parameters, start)
    references = _references(parameters, starting, source) if start else {}
    written = {key.removesuffix(".structure.healthy_speed") for key in references}
    # A box that is written without a value has nothing below it yet.
    return {key: value for key, value in starting.items() if value is not None or key not in written} | references


def _references(parameters: Mapping[str, Any], starting: Mapping[str, Any], source: str) -> dict[str, float]:
    """Return the speed of the shaft at which the level of a healthy box holds, that without ``start``, where a box states none."""
    try:
        boxes = vehicle_of(starting, source).boxes
    except Refusal:  # who runs the vehicle names what is invalid
        return {}
    levels = {box.name: box.configuration.measurement.parameters[MachineBackgroundParameters] for box in boxes}
    asked = [name for name, level in levels.items() if level.healthy_level > 0.0 and level.healthy_speed == 0.0]
    before = vehicle_of(parameters, f"{source}, without its start").boxes if asked else ()
    return {f"{box.name}.structure.healthy_speed": abs(box.configuration.operating.speed) for box in before if box.name in asked}


def vehicle_scenario(tree: Any, vehicle: Vehicle, source: str) -> VehicleScenario:
    """Return the changes of a scenario.

    Args:
        tree: the scenario as parsed from YAML.
        vehicle: the vehicle of `starting_parameters`.
        source: the scenario's name in error messages.

    Raises:
        Refusal: the tree is not a scenario, or one of its changes is invalid for the vehicle.
    """
    entries = timeline_entries(tree, source, vehicle.boxes[0].configuration.step_rate, _flat)
    course = _Course(vehicle)
    of_boxes: dict[str, list[Entry]] = {box.name: [] for box in vehicle.boxes}
    settings: list[ScheduledSetting] = []
    sources: list[str] = []
    for entry in entries:
        where, known = f"{entry.source}: ", len(settings)
        changes = {key: value for key, value in entry.values.items() if not key.startswith(PREFIX)}
        asked = sorted_changes(vehicle, course.wheels, changes, where)
        for name, values in asked.boxes.items():
            of_boxes[name].append(replace(entry, values=values, source=f"{entry.source}, {name}"))
        for key, value in entry.values.items():
            if key.startswith(PREFIX):
                settings += course.settings(entry, key, checked_command(key.removeprefix(PREFIX), value, where))
            elif of_model(key):
                settings += course.settings(entry, key, value)
        sources += [entry.source] * (len(settings) - known)
        course.wheels.update(asked.wheels)
    if len(settings) > MAX_CHANGES:
        raise Refusal(f"{source}: its gradual changes of the vehicle take {len(settings)} steps, above {MAX_CHANGES}: shorten them")
    commands = {name: float(getattr(vehicle.journey, name)) for name in RANGES}
    way = sorted(zip(settings, sources, strict=True), key=lambda item: item[0].frame)
    check_way(vehicle, way, commands, commands["speed_kmh"], vehicle.journey.ramp)
    boxes = {
        box.name: tuple(planned_changes(of_boxes[box.name], box.configuration, f"{source}, {box.name}"))
        for box in vehicle.boxes
        if of_boxes[box.name]
    }
    return VehicleScenario(boxes, tuple(sorted(settings, key=lambda setting: setting.frame)), tree)


def _flat(given: Mapping[Any, Any], source: str) -> dict[str, Any]:
    """Return what an entry sets, by dotted keys.

    Raises:
        Refusal: a command lacks the name of its group.
    """
    values = {str(key): value for key, value in flatten(given).items()}
    bare = next((key for key in values if key in RANGES), None)
    if bare is not None:
        raise Refusal(f"{source}: '{bare}' names nothing: did you mean '{PREFIX}{bare}'?")
    return values


def _approached(value: float, wanted: float, change: float) -> float:
    """Return a value after a change towards the wanted one."""
    return wanted if abs(wanted - value) <= change else value + math.copysign(change, wanted - value)


def check_way(
    vehicle: Vehicle,
    settings: Iterable[tuple[ScheduledSetting, str]],
    commands: Mapping[str, float],
    speed: float,
    ramp: float,
    begun: int = 0,
    end: str = "",
) -> None:
    """Refuse settings, with the names of their entries and in the order of time, that leave a box without load at any time.

    Between two of them only the speed changes, in one direction, so that the loads are extreme before and after each. At the frame
    ``begun`` the vehicle has a ``speed`` [km/h] and a ``ramp`` [m/s^2], and the ``commands`` are in effect; ``end`` completes a refusal.
    """
    interval, commands, source = FRAME / vehicle.boxes[0].configuration.step_rate, dict(commands), ""

    def check(seconds: float) -> None:
        check_loads(vehicle, commands | {"speed_kmh": speed}, f"{source} (at {seconds:.6g} s): ", end)

    of_vehicle = (item for item in settings if item[0].key.startswith(PREFIX))
    for frame, together in itertools.groupby(of_vehicle, key=lambda item: item[0].frame):
        before, speed = speed, _approached(speed, commands["speed_kmh"], 3.6 * ramp * (frame - begun) * interval)
        if speed != before:
            check(frame * interval)
        for setting, name in together:
            source = name
            if setting.key == RAMP:
                ramp = setting.value
            else:
                commands[setting.key.removeprefix(PREFIX)] = setting.value
        check(frame * interval)
        begun = frame
    last = begun * interval + abs(commands["speed_kmh"] - speed) / (3.6 * ramp)
    speed = commands["speed_kmh"]
    check(last)


class _Course:
    """The values of the vehicle as the entries of a scenario change them."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._frame = FRAME / vehicle.boxes[0].configuration.step_rate
        self._ramp = vehicle.journey.ramp
        self.wheels = {box.name: box.wheel for box in vehicle.boxes}
        """The wheel under each box."""
        self._present: dict[str, Any] = {f"{PREFIX}{name}": getattr(vehicle.journey, name) for name in RANGES}
        self._present |= {f"{axle.name}.slide": axle.slide for axle in vehicle.axles}
        self._last_speed = (0, vehicle.journey.speed_kmh, vehicle.journey.speed_kmh)
        """Frame of the latest change of the speed, the speed at this frame and the commanded one [km/h]."""

    def settings(self, entry: Entry, key: str, value: Any) -> Iterator[ScheduledSetting]:
        """Yield the settings by which an entry changes a value, at once or gradually; a change within one frame is made at its end."""
        first, last = (-(-step // FRAME) for step in (entry.first, entry.last))
        before = self._speed_at(first) if key == SPEED else self._before(key)
        self._present[key] = value
        if key == SPEED:
            slope = abs(value - before) / 3.6 / (max(1, last - first) * self._frame) if entry.gradual else 0.0
            if slope > STEEPEST:
                raise Refusal(f"{entry.source}: {key} would change by {slope:.3g} m/s^2, above {STEEPEST:g} m/s^2: give a longer 'over'")
            ramped = slope > 0.0 and last > first
            self._last_speed = (last, value, value) if ramped else (first, before, value)
            if ramped:
                yield ScheduledSetting(first, RAMP, slope)
            yield ScheduledSetting(first, key, value)
            if ramped:
                yield ScheduledSetting(last, RAMP, self._ramp)
        elif not entry.gradual:
            yield ScheduledSetting(first, key, value)
        elif isinstance(value, bool) or not isinstance(value, (int, float)):
            raise Refusal(f"{entry.source}: {key} cannot change gradually 'over' {entry.over:g} s: leave out 'over'")
        else:
            count = max(1, min(MAX_TICKS, last - first))
            for k in range(1, count):
                yield ScheduledSetting(first + (last - first) * k // count, key, before + k / count * (value - before))
            yield ScheduledSetting(last, key, float(value))  # `before + (value - before)` may be another number

    def _speed_at(self, frame: int) -> float:
        """Return the speed at a frame [km/h], which may still be on its way to the commanded one."""
        begun, speed, commanded = self._last_speed
        return _approached(speed, commanded, 3.6 * self._ramp * (frame - begun) * self._frame)

    def _before(self, key: str) -> Any:
        """Return the present value of a key."""
        if key not in self._present:
            name, _, parameter = key.rpartition(".wheel.")
            return getattr(self.wheels[name], parameter)
        return self._present[key]
