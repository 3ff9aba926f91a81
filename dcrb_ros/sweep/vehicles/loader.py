"""Loading of a sweep over vehicles: every parameter is tried on the vehicle, and an invalid one is refused in one sentence."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from dcrb_ros.schema.parameter_field import KINDS, ParameterField
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import fields_by_key, flatten, load_configuration
from dcrb_ros.settings.shipped import find_configuration, shipped
from dcrb_ros.sweep.axes import GAP_PARAMETERS, axes_of, refuse_fixed
from dcrb_ros.sweep.design import Axes, Choice, Span, Value
from dcrb_ros.sweep.sweep_file import LONGEST_RUN, SweepFile
from dcrb_ros.sweep.vehicles.sweep import BOX, VEHICLE, VEHICLE_SEED, VehicleSweep, placed
from dcrb_ros.text.files import checked_path, is_file
from dcrb_ros.vehicle.description import SIDES, Vehicle, Wheel
from dcrb_ros.vehicle.file import COMMON, DEFAULT_X, DRIVE, GROUPS, PLACES, SWAPPED, read_parameters, vehicle_of
from dcrb_ros.vehicle.paths import bearing_paths

ABSENT = ("base", "machine", "twins", "branch_at", "seeds")
"""Keys of other sweeps that one over vehicles does not have."""
TRIED = 20
"""Values of a list that are tried on the vehicle before the first run, at most [-]; another one is refused with its runs."""
SEEDS = (".simulation.seed", ".surfaces.seed", ".structure.seed")
"""Ends of the keys of a box's seeds."""


def vehicle_keys(tree: Mapping[str, Any], source: str) -> dict[str, Any]:
    """Return the keys of a sweep over vehicles that every sweep has.

    Raises:
        Refusal: a key that no sweep over vehicles has.
    """
    absent = next((key for key in ABSENT if key in tree), None)
    if absent is not None:
        reasons = {"base": "the vehicle is the base", "seeds": "its noise follows from vehicle.seed, which can be varied"}
        raise Refusal(f"{source}: a sweep over vehicles has no '{absent}'{': ' + reasons[absent] if absent in reasons else ''}: remove it")
    return {key: value for key, value in tree.items() if key != VEHICLE}


def vehicle_sweep_of(given: Any, file: SweepFile, source: str, folder: Path, text: str) -> VehicleSweep:
    """Return the sweep over vehicles of a file; ``given`` is the vehicle that it names.

    Raises:
        Refusal: the vehicle does not exist, a parameter is unknown or out of range, or the files of the data set cannot hold the runs.
    """
    if not isinstance(given, str) or not given:
        raise Refusal(f"{source}: vehicle = {given!r} is not the name of a vehicle: give a shipped one, such as bogie, or a file")
    if file.output == "bag":
        raise Refusal(f"{source}: output = bag is for single bearings, a vehicle has npz or parquet: give one of them")
    if file.split.apart:
        raise Refusal(f"{source}: split.apart is for single bearings, a vehicle is in one split anyway: remove it")
    beside = checked_path(folder / given)
    base = read_parameters(beside if is_file(beside) else given, file.fixed)
    vehicle = vehicle_of(base, f"{source}: set")
    _refuse_unlabelled(vehicle, f"{source}: set")
    names = [box.name for box in vehicle.boxes]
    if (total := file.duration * len(names)) > LONGEST_RUN:
        raise Refusal(f"{source}: duration = {file.duration:g} s makes {total:g} s of all boxes, above {LONGEST_RUN:g} s: shorten the runs")
    _refuse_seeds(flatten(file.fixed), f"{source}: set")
    _refuse_seeds(base, str(given))
    vary = axes_of(file.vary, file.design, f"{source}: vary", _field)
    refuse_fixed(vary, flatten(file.fixed), source)
    cases: dict[str, Axes] = {name: axes_of(case, file.design, f"{source}: cases.{name}", _field) for name, case in file.cases.items()}
    cases = cases or {"base": {}}
    if BOX in vary or any(key.startswith(f"{BOX}.") for key in vary):
        raise Refusal(f"{source}: vary: '{BOX}' is for cases: name the box, such as {names[0]}.surfaces.waviness")
    for name, axes in cases.items():
        if VEHICLE_SEED in axes:
            raise Refusal(
                f"{source}: cases.{name}: another {VEHICLE_SEED} is another vehicle, which may be in another split: move it to 'vary'"
            )
        _check_boxes(axes, names, f"{source}: cases.{name}")
        _refuse_varied(axes, vary, f"{source}: cases.{name}")
    for where, axes in (("vary", vary), *((f"cases.{name}", axes) for name, axes in cases.items())):
        _refuse_seeds(axes, f"{source}: {where}")
        # Paths that are drawn from a range, or given by 'vary' and a case together, are known with their runs only.
        others = cases.values() if axes is vary else [vary]
        known = not isinstance(axes.get("paths.seed"), Span) and not any(key.startswith("paths.") for other in others for key in other)
        for values in _tried(axes):
            try:
                tried = vehicle_of({**base, **placed(values)}, f"{source}: {where}")
                _refuse_unlabelled(tried, f"{source}: {where}")
                if known:
                    bearing_paths(tried, tried.boxes[0].configuration.step_rate)
            except Refusal as refusal:
                raise Refusal(str(refusal) if source in str(refusal) else f"{source}: {where}: {refusal}") from None
    benches, kinds = _benches(base, [vary, *cases.values()]), _kinds([vary, *cases.values()])
    return VehicleSweep(file, text, base, vary, cases, {}, source=given, vehicle=vehicle, kinds=kinds, benches=benches)


@cache
def vehicle_fields() -> Mapping[str, ParameterField]:
    """Return every parameter of a vehicle by its dotted key, those of a box also below `BOX`."""
    boxes = (BOX, *(f"{axle}.{side}" for axle in DEFAULT_X for side in SIDES))
    groups = GROUPS | {f"{axle}.{part}": model for axle in DEFAULT_X for part, model in DRIVE.items()}
    groups |= dict.fromkeys(boxes, Configuration) | {f"{box}.wheel": Wheel for box in boxes}
    fields = {f"{name}.{key}": field for name, model in groups.items() for key, field in fields_by_key(model).items()}
    fields |= {key: field for key, field in fields_by_key().items() if key.partition(".")[0] in COMMON}
    fields |= {f"{axle}.{place}": _plain(place, float) for axle in DEFAULT_X for place in PLACES}
    return fields | {BOX: _plain(BOX, str)} | {f"{box}.{name}": _plain(name, str) for box in boxes for name in ("bench", SWAPPED)}


def _plain(key: str, kind: type) -> ParameterField:
    return ParameterField(key, kind, 0, None, None, "-", "", "Parameter of a vehicle", "", run_time=False)


def _field(key: str, value: Any) -> ParameterField:
    """Return the parameter of a key; an unknown one takes the type of its ``value``, with which the vehicle refuses it."""
    while isinstance(value, (list, Mapping)) and value:
        value = value[0] if isinstance(value, list) else next(iter(value.values()))
    return vehicle_fields().get(key) or _plain(key, type(value) if type(value) in KINDS else str)


def _kinds(all_axes: Iterable[Axes]) -> dict[str, type]:
    """Return the types of the varied parameters; one below `BOX` is a parameter of each box that its case lists."""
    kinds: dict[str, type] = {}
    for axes in all_axes:
        listed = axes.get(BOX, Choice(("",)))
        for box in listed.values if isinstance(listed, Choice) else ():
            kinds |= {place: _field(key, "").kind for key in axes if key != BOX for place in placed({BOX: box, key: ""})}
    return kinds


def _benches(base: Mapping[str, Any], all_axes: Iterable[Axes]) -> dict[str, Any]:
    """Return the parameters of the benches that are files of the user, by the names of the files, which the parameters have only."""
    axes = [(key, axis.values) for axes in all_axes for key, axis in axes.items() if isinstance(axis, Choice)]
    named = {
        str(name) for key, values in (*((key, (value,)) for key, value in base.items()), *axes) if key.endswith(".bench") for name in values
    }
    own = {name for name in named if find_configuration(name) not in shipped("configuration").values()}
    return {name: flatten(load_configuration(name).model_dump()) for name in sorted(own)}


def _refuse_unlabelled(vehicle: Vehicle, where: str) -> None:
    """Refuse a vehicle whose waveforms have gaps, which their files cannot represent, or are those of another box than their labels."""
    for box in vehicle.boxes:
        if box.swapped_with:
            raise Refusal(
                f"{where}: {box.name}.{SWAPPED} = '{box.swapped_with}' gives the box the waveform of another one, which its label does not "
                "describe: remove it"
            )
        parameters = flatten(box.configuration.model_dump())
        gaps = next((key for key in GAP_PARAMETERS if parameters[key]), None)
        if gaps is not None:
            raise Refusal(f"{where}: {gaps} = {parameters[gaps]:g} causes gaps, which waveform files cannot represent: set it to 0")


def _refuse_seeds(keys: Iterable[str], where: str) -> None:
    """Refuse a seed of a box: its bearing, housing or noise would be in several vehicles, or not that of its labels."""
    seed = next((key for key in keys if key.endswith(SEEDS)), None)
    if seed is not None:
        raise Refusal(f"{where}: {seed} is drawn by {VEHICLE_SEED}, so that each vehicle has its own: remove it")


def _check_boxes(axes: Axes, names: list[str], source: str) -> None:
    """Refuse a case whose box is not one of the vehicle's."""
    axis = axes.get(BOX)
    boxes = axis.values if isinstance(axis, Choice) else ()
    unknown = next((box for box in boxes if box not in names), None)
    if unknown is not None:
        raise Refusal(f"{source}: there is no box '{unknown}'{nearest(str(unknown), names)} (known: {', '.join(names)})")
    placeholder = next((key for key in axes if key.startswith(f"{BOX}.")), None)
    if (placeholder is not None) != bool(boxes):
        raise Refusal(f"{source}: '{placeholder or BOX}' needs both the boxes and a parameter: give {BOX}: [{names[0]}] and {BOX}.bench")


def _refuse_varied(axes: Axes, vary: Axes, source: str) -> None:
    """Refuse a case that sets a parameter which is varied, whose varied value would have no effect."""
    for values in _tried(axes):
        twice = next((key for key in placed(values) if key in vary), None)
        if twice is not None:
            raise Refusal(f"{source}: {twice} is under 'vary' too, which would have no effect in this case: give it in one of the two")


def _tried(axes: Axes) -> Iterator[dict[str, Value]]:
    """Yield values in which each axis has each of its ends or first values once; the others have their first value."""
    ends = {key: [axis.at(0.0), axis.at(1.0)] if isinstance(axis, Span) else [*axis.values[:TRIED]] for key, axis in axes.items()}
    first = {key: values[0] for key, values in ends.items()}
    yield first
    for key, values in ends.items():
        yield from ({**first, key: value} for value in values[1:])
