"""Vehicles from files: groups of parameters, wheelsets, and boxes as benches with changes of their own."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from dcrb_ros.schema.arguments import of_type, texts
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.parameter_field import more
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, load_configuration, nest, validated
from dcrb_ros.settings.sections import read_sections
from dcrb_ros.settings.shipped import find_shipped
from dcrb_ros.text.yaml import parsed, read_yaml
from dcrb_ros.vehicle.description import SIDES, Axle, Body, Box, Frame, Gear, Journey, Motor, Paths, Suspension, Track, Vehicle, Wheel
from dcrb_ros.vehicle.loads import check_loads
from dcrb_ros.vehicle.track import is_smooth

GROUPS: dict[str, type[Group]] = {
    "vehicle": Journey,
    "body": Body,
    "frame": Frame,
    "suspension": Suspension,
    "track": Track,
    "paths": Paths,
}
MOST_SLIDING = 0.2
"""Largest slide of a wheelset [-]."""
PLACES = {"x": (-3.0, 3.0, "m"), "radius": (0.3, 0.6, "m"), "creep": (-0.01, 0.01, "-"), "slide": (0.0, MOST_SLIDING, "-")}
"""Numbers of a wheelset, their ranges and units."""
SHARE = "shares of the speed"
"""Unit of a creep or a slide in a refusal."""
DRIVE: dict[str, type[Group]] = {"gear": Gear, "motor": Motor}
"""Groups of a wheelset."""
DEFAULT_X = {"axle_1": 1.28, "axle_2": -1.28}
"""Places of the wheelsets [m]."""
DEFAULT_RADIUS = 0.46
"""[m]"""
OF_VEHICLE = {"operating": "the vehicle's speed, weight and track", "background": "the vehicle's wheels, track and gear"}
"""Groups of a box's configuration that the vehicle replaces, and by what."""
COMMON = ("publishing", "recording", "time_scale")
"""Groups and parameters that a vehicle gives all its boxes."""
RUN = ("recording.", "time_scale", "publishing.clock", "publishing.listeners", "publishing.wait")
"""Those of them that a box cannot have of its own."""
OWN_BACKGROUND = ("impact_rate", "impact_level", "hum_level", "hum_frequency")
"""Background that a box may have of its own."""
SWAPPED = "sensor.swapped_with"
"""Key of the box whose accelerometer is connected to the channel of this one."""
SEEDS = 2**31 - 1
ONE_BOX = "has one box, but it rolls on two wheels: give both ({} for the bench without changes)"
"""Why wheels, track and drive of a wheelset are refused."""
NODE = "vehicle_simulator"
"""Node whose sections of a ROS parameter file describe the vehicle."""


def read_vehicle(source: str | Path, settings: Sequence[str] | Mapping[str, Any] = ()) -> Vehicle:
    """Return the vehicle of a file or a shipped name, with some settings changed.

    Parameters
    ----------
    source
        The name of a shipped vehicle, such as ``"bogie"``, or a YAML file.
    settings
        Texts such as ``"axle_1.left.faults.outer_1.width=0.002"``, or a mapping.

    Raises
    ------
    Refusal
        No such file, an unknown name, or a value that is out of range or does not fit the others.
    """
    return vehicle_of(read_parameters(source, settings), str(source))


def read_parameters(source: str | Path, settings: Sequence[str] | Mapping[str, Any] = (), *, of_ros: bool = False) -> dict[str, Any]:
    """Return the parameters of a file or a shipped name by dotted keys, with settings on top, unchecked; see `read_vehicle`.

    With ``of_ros``, those that every node of ROS has are included.
    """
    of_type(str, os.PathLike)("source", source)
    if not isinstance(settings, Mapping):
        texts("settings", settings)
    path = find_shipped("vehicle", source)
    tree = read_yaml(path)
    if not isinstance(tree, Mapping) or not tree:
        raise Refusal(
            f"{source} is not a vehicle: give groups such as 'vehicle: {{speed_kmh: 100.0}}' and 'axle_1: {{left: {{}}, right: {{}}}}'"
        )
    sections, wrong = read_sections(tree, NODE, of_ros=of_ros)
    if wrong:
        raise Refusal(f"{source}: {wrong[0]}{more(len(wrong))}")
    return layered({key: value for section in sections for key, value in flatten(section).items()}, settings)


def layered(tree: Mapping[str, Any], settings: Sequence[str] | Mapping[str, Any]) -> dict[str, Any]:
    """Return a tree with settings on top, by dotted keys."""
    flat = flatten(tree)
    if isinstance(settings, Mapping):
        return {**flat, **flatten(settings)}
    for text in (settings,) if isinstance(settings, str) else settings:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise Refusal(f"--set {text}: write KEY=VALUE, for example axle_1.left.faults.outer_1.width=0.002")
        try:
            flat[key.strip()] = parsed(value)
        except yaml.YAMLError:
            raise Refusal(f"--set {text}: the value cannot be read") from None
    return flat


def vehicle_of(flat: Mapping[str, Any], source: str, recorded: Mapping[str, Configuration] | None = None) -> Vehicle:
    """Return the vehicle that parameters by dotted keys describe.

    Args:
        flat: the parameters.
        source: the vehicle's name in error messages.
        recorded: the configuration of each box in a recording of the vehicle, which replace the benches that its parameters name.

    Raises:
        Refusal: a name is unknown, or a value is out of range or does not fit the others.
    """
    common = {key: value for key, value in flat.items() if key.partition(".")[0] in COMMON}
    # Empty groups are copied, because other keys may be put into them.
    own = {key: {} if value == {} else value for key, value in flat.items() if key not in common and (value != {} or key not in GROUPS)}
    tree = nest(own)
    groups = _groups(source, tree)
    axles: list[Axle] = []
    parts: list[tuple[str, int, str, Mapping[str, Any]]] = []
    for number, name in enumerate(name for name in DEFAULT_X if name in tree):
        axle, sides = _axle(source, name, tree[name])
        axles.append(axle)
        parts += [(f"{name}.{side}", number, side, given) for side, given in sides.items()]
    _check_wheelsets(source, axles, [axle for _, axle, _, _ in parts], groups["track"])
    journey: Journey = groups["vehicle"]
    bench = next(iter(recorded.values())) if recorded else _bench(source, "vehicle.bench", journey.bench)
    _check_run(source, bench, common)
    bare = tuple(Box(name, axle, 1 if side == SIDES[0] else -1, bench, Wheel()) for name, axle, side, _ in parts)
    vehicle = Vehicle(journey, groups["body"], groups["frame"], groups["suspension"], groups["track"], groups["paths"], tuple(axles), bare)
    speed = journey.speed_kmh / 3.6
    loads = check_loads(vehicle, journey.model_dump(), f"{source}, vehicle: ")
    boxes = []
    for box, (name, _, _, given), (x, y) in zip(bare, parts, loads, strict=True):
        axle = axles[box.axle]
        turning = speed * (1.0 + axle.creep - axle.slide) / axle.radius
        configuration, wheel, swapped = _box(source, name, {**common, **given}, recorded, journey, turning, axle.radius, x, -y)
        boxes.append(Box(name, box.axle, box.side, configuration, wheel, swapped))
        if wheel.defective and [each.axle for each in bare].count(box.axle) == 1:
            raise Refusal(f"{source}: {axle.name} {ONE_BOX}")
    _check_clock(source, boxes)
    return replace(vehicle, boxes=_connected(source, boxes))


def _groups(source: str, tree: Mapping[str, Any]) -> dict[str, Any]:
    """Return the groups of the vehicle."""
    names = [*GROUPS, *COMMON, *DEFAULT_X]
    unknown = next((name for name in tree if name not in names), None)
    if unknown is not None:
        raise Refusal(f"{source}: unknown group '{unknown}'{nearest(str(unknown), names)} (known: {', '.join(names)})")
    return {name: _group(source, name, tree.get(name, {}), model) for name, model in GROUPS.items()}


def _group(source: str, name: str, given: Any, model: type[Group]) -> Any:
    """Return a group of parameters."""
    if not isinstance(given, Mapping):
        raise Refusal(f"{source}: {name} = {given} is not a group of parameters: give one of {', '.join(model.model_fields)}")
    return validated(as_floats(flatten(given), model), model, f"{source}, {name}")


def _check_wheelsets(source: str, axles: Sequence[Axle], boxes: Sequence[int], track: Track) -> None:
    """Refuse wheelsets that overlap or lack boxes; ``boxes`` has the number of the wheelset of each box."""
    if not boxes:
        raise Refusal(f"{source}: there is no box: give axle_1 with left, right or both")
    if len(axles) == 2 and abs(axles[0].x - axles[1].x) < axles[0].radius + axles[1].radius:
        raise Refusal(
            f"{source}: the wheels of {axles[0].name} at x = {axles[0].x:g} m and of {axles[1].name} at x = {axles[1].x:g} m overlap: "
            f"place the wheelsets at least {axles[0].radius + axles[1].radius:g} m apart"
        )
    for number, axle in enumerate(axles):
        count = boxes.count(number)
        if count == 0:
            raise Refusal(f"{source}: {axle.name} has no box: give left and right ({{}} for the bench without changes), or leave it out")
        if count == 1 and (axle.gear.teeth or not is_smooth(track)):
            raise Refusal(f"{source}: {axle.name} {ONE_BOX}")


def _check_clock(source: str, boxes: Sequence[Box]) -> None:
    """Refuse boxes that differ in what all share."""
    first = boxes[0].configuration
    for box in boxes[1:]:
        for what, here, there in (
            ("simulation.step", first.step_rate, box.configuration.step_rate),
            ("sensor.sampling_rate", first.sensor.sampling_rate, box.configuration.sensor.sampling_rate),
            ("thermal.acceleration", first.thermal.acceleration, box.configuration.thermal.acceleration),
            ("publishing.block_size", first.publishing.block_size, box.configuration.publishing.block_size),
        ):
            if here != there:
                raise Refusal(f"{source}: {boxes[0].name} and {box.name} differ in {what} ({here} and {there}): boxes share one clock")


def _check_run(source: str, bench: Configuration, common: Mapping[str, Any]) -> None:
    """Refuse invalid parameters that no box has of its own, without the name of a box."""
    try:
        load_configuration(bench, {key: value for key, value in flatten(common).items() if key.startswith(RUN)})
    except Refusal as refusal:
        raise Refusal(f"{source}: {refusal}") from None


def _connected(source: str, boxes: Sequence[Box]) -> tuple[Box, ...]:
    """Return the boxes, each with the box whose accelerometer is connected to its channel.

    Raises:
        Refusal: a swap names no other box, or a box is in two swaps.
    """
    partner: dict[str, str] = {}
    for box in boxes:
        other = box.swapped_with
        if not other:
            continue
        others = [each.name for each in boxes if each is not box]
        if other not in others:
            known = ", ".join(others) or "none"
            raise Refusal(f"{source}: {box.name}.{SWAPPED} = '{other}' names no other box{nearest(other, others)} (known: {known})")
        for one, two in ((box.name, other), (other, box.name)):
            if partner.setdefault(one, two) != two:
                raise Refusal(f"{source}: the sensor of {one} is swapped with those of {partner[one]} and {two}: give one of them")
    return tuple(replace(box, swapped_with=partner.get(box.name, "")) for box in boxes)


def _axle(source: str, name: str, given: Any) -> tuple[Axle, dict[str, Mapping[str, Any]]]:
    """Return a wheelset and what stands for its boxes."""
    if not isinstance(given, Mapping):
        raise Refusal(f"{source}: {name} = {given} is not a wheelset: give left and right")
    known = (*PLACES, *DRIVE, *SIDES)
    unknown = next((key for key in given if key not in known), None)
    if unknown is not None:
        raise Refusal(f"{source}: unknown key '{name}.{unknown}'{nearest(str(unknown), known)} (known: {', '.join(known)})")
    values = {"x": DEFAULT_X[name], "radius": DEFAULT_RADIUS, "creep": 0.0, "slide": 0.0}
    for key, (low, high, unit) in PLACES.items():
        value = finite_number(f"{source}: {name}.{key} =", given.get(key, values[key]), SHARE if unit == "-" else unit)
        if not low <= value <= high:
            raise Refusal(f"{source}: {name}.{key} = {value:g} is outside {low:g} .. {high:g} {unit}")
        values[key] = value
    drive = {part: _group(source, f"{name}.{part}", given.get(part, {}), model) for part, model in DRIVE.items()}
    if (level := drive["motor"].level) > 0.0 and not drive["gear"].teeth:
        raise Refusal(f"{source}: {name}.motor.level = {level:g} needs gear.teeth: give the teeth of the wheel on the axle")
    boxes = {side: {} if given[side] is None else given[side] for side in SIDES if side in given}
    for side, box in boxes.items():
        if not isinstance(box, Mapping):
            raise Refusal(f"{source}: {name}.{side} = {box} is not a box: give {{}} for the bench without changes")
        shared = next((key for key in flatten(box) if key.startswith(RUN)), None)
        if shared is not None:
            raise Refusal(f"{source}: {name}.{side}.{shared} belongs to the whole vehicle: give {shared} beside the group vehicle")
    return Axle(name, values["x"], values["radius"], values["creep"], values["slide"], **drive), boxes


def _bench(source: str, key: str, name: str) -> Configuration:
    """Return the configuration that a key names."""
    try:
        return load_configuration(name)
    except Refusal as refusal:
        raise Refusal(f"{source}: {key}: {refusal}") from None


def _box(
    source: str,
    name: str,
    given: Mapping[str, Any],
    recorded: Mapping[str, Configuration] | None,
    journey: Journey,
    shaft_speed: float,
    radius: float,
    x: float,
    load: float,
) -> tuple[Configuration, Wheel, str]:
    """Return configuration and wheel of a box, and the box whose accelerometer is connected to its channel."""
    flat = flatten(given)
    bench = flat.pop("bench", journey.bench)
    if not isinstance(bench, str):
        raise Refusal(f"{source}: {name}.bench = {bench} is not the name of a configuration")
    swapped = flat.pop(SWAPPED, "")
    if not isinstance(swapped, str):
        raise Refusal(f"{source}: {name}.{SWAPPED} = {swapped} is not the name of a box, such as axle_2.left")
    _group(source, f"{name}.wheel", flat.pop("wheel", {}), Wheel)
    wheel = {key.removeprefix("wheel."): flat.pop(key) for key in list(flat) if key.startswith("wheel.")}
    for key in flat:
        if owner := made_by_vehicle(key):
            raise Refusal(f"{source}: {name}.{key} would count twice: it follows from {owner}")
    if recorded:  # the parameters are in it
        return recorded[name], validated(as_floats(wheel, Wheel), Wheel, f"{source}: {name}: wheel"), swapped
    own = _bench(source, f"{name}.bench", bench)
    twice = [key for key in own.background.described() if key not in OWN_BACKGROUND]
    if twice:
        raise Refusal(f"{source}: the bench '{bench}' of {name} has background.{twice[0]}, which the vehicle makes: choose another bench")
    settings = {
        "simulation.seed": seed_of(journey.seed, name, "run"),
        "surfaces.seed": seed_of(journey.seed, name, "individual"),
        "structure.seed": seed_of(journey.seed, name, "housing"),
        "publishing.frame": f"{name.replace('.', '/')}/outer_ring",
        **flat,
        "operating.speed": shaft_speed,
        "operating.wheel_diameter": 2.0 * radius,
        "operating.load": load,
        "operating.lateral_load": x,
        "operating.speed_fluctuation": 0.0,
        "operating.speed_ripple": 0.0,
    }
    try:
        return load_configuration(own, settings), validated(as_floats(wheel, Wheel), Wheel, "wheel"), swapped
    except Refusal as refusal:
        raise Refusal(f"{source}: {name}: {refusal}") from None


def made_by_vehicle(key: str) -> str:
    """Return what of the vehicle replaces a parameter of a box; empty for one that a box may have of its own."""
    group = key.partition(".")[0]
    return OF_VEHICLE[group] if group in OF_VEHICLE and not key.endswith(OWN_BACKGROUND) else ""


def seed_of(seed: int, *names: str) -> int:
    """Return the seed of a part of the vehicle, a hash of the vehicle's seed and of names."""
    digest = hashlib.sha256("/".join((str(seed), *names)).encode()).digest()
    return int.from_bytes(digest[:4], "little") % SEEDS


def as_floats(flat: Mapping[str, Any], model: type[Group]) -> dict[str, Any]:
    """Return values with whole numbers as floats where the model has floats, as ROS writes them, unless they are beyond all floats."""
    floats = {key for key, field in model.model_fields.items() if field.annotation is float}
    whole = {key for key, value in flat.items() if key in floats and isinstance(value, int) and not isinstance(value, bool)}
    return {key: float(value) if key in whole and abs(value) <= sys.float_info.max else value for key, value in flat.items()}
