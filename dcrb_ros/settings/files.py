"""Configurations: layers of parameters from files, settings and changes, checked and written in the form of a ROS parameter file."""

from __future__ import annotations

import math
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import yaml
from pydantic import ValidationError

from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import ParameterField, field_of, more, sentences
from dcrb_ros.schema.refusal import GOOD_LIKENESS, Refusal, nearest, nearest_key
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.sections import read_sections
from dcrb_ros.settings.sensor import preset_values
from dcrb_ros.settings.shipped import find_configuration
from dcrb_ros.settings.vehicle_speed import SPEED, SPEED_KMH, WHEEL_DIAMETER, converted
from dcrb_ros.text.yaml import parsed, read_yaml, yaml_text

MOST_UNKNOWN = 20
"""Unknown parameters for which those that may be meant are searched, which takes a millisecond each."""
LEAST = sys.float_info.min
"""Smallest magnitude of a number other than zero: quotients of smaller numbers overflow."""
VEHICLE_GROUPS = ("vehicle", "track", "axle_1", "axle_2")
"""Groups of the file of a vehicle, which is no configuration."""
OTHER_UNITS = {"rpm": math.pi / 30.0, "hz": 2.0 * math.pi}
"""Units in which speeds are often given [rad/s]."""

Model = TypeVar("Model", bound=Group)


def parameter_fields(model: type[Group] = Configuration, prefix: str = "") -> Iterator[ParameterField]:
    """Yield every parameter of a model by its dotted key."""
    for name, info in model.model_fields.items():
        if isinstance(info.annotation, type) and issubclass(info.annotation, Group):
            yield from parameter_fields(info.annotation, f"{prefix}{name}.")
        else:
            yield field_of(prefix + name, info)


@cache
def fields_by_key(model: type[Group] = Configuration) -> Mapping[str, ParameterField]:
    """Return every parameter of a model by its dotted key."""
    return {field.key: field for field in parameter_fields(model)}


def flatten(tree: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return a nested mapping with dotted keys; an empty group is a value of its own.

    Raises:
        Refusal: a key occurs twice, in its group and with a dotted name.
    """
    flat, wrong = _flattened(tree, prefix)
    if wrong:
        raise Refusal(wrong[0])
    return flat


def _flattened(tree: Mapping[str, Any], prefix: str = "") -> tuple[dict[str, Any], list[str]]:
    """Return a nested mapping with dotted keys, and a sentence for each key that occurs twice."""
    flat: dict[str, Any] = {}
    wrong: list[str] = []

    def fill(branch: Mapping[str, Any], prefix: str) -> None:
        for name, value in branch.items():
            key = f"{prefix}{name}"
            # Most values are numbers, of which the abstract class needs a slow search.
            if value.__class__ is not float and isinstance(value, Mapping) and value:
                fill(value, f"{key}.")
                continue
            if key in flat:
                wrong.append(f"{key} occurs twice, in its group and with a dotted name: remove one")
            flat[key] = value

    fill(tree, prefix)
    return flat, wrong


def nest(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mapping with dotted keys as a tree.

    Raises:
        Refusal: a key is below one that has a value.
    """
    tree: dict[str, Any] = {}
    for key, value in flat.items():
        *groups, name = key.split(".")
        branch = tree
        for group in groups:
            branch = branch.setdefault(group, {})
            if not isinstance(branch, dict):
                raise Refusal(f"{key} is below {group}, which has the value {branch!r}: give one of them")
        if branch.get(name) and isinstance(branch[name], dict) and not isinstance(value, Mapping):
            raise Refusal(f"{key} has the value {value!r}, and {next(iter(branch[name]))} is below it: give one of them")
        branch[name] = value
    return tree


def validated(flat: Mapping[str, Any], model: type[Model], source: str) -> Model:
    """Return the model of parameters with dotted keys.

    Raises:
        Refusal: an unknown key, a value of the wrong type or out of range, or values that contradict each other; one sentence with the
            value, the range and the remedy.
    """
    result, wrong = checked(flat, model)
    if result is None or wrong:
        raise Refusal(f"{source}: {wrong[0]}{more(len(wrong))}")
    return result


def checked(flat: Mapping[str, Any], model: type[Model]) -> tuple[Model | None, list[str]]:
    """Return the model of parameters with dotted keys, None if a value is invalid, and what is wrong with them.

    What is wrong has a sentence each, with the value, the range and the remedy.
    """
    known, fields = _without_empty_groups(flat, model), fields_by_key(model)
    unknown = [key for key in known if key not in fields]
    wrong = list(dict.fromkeys(unknown_parameter(key, model, known[key]) for key in unknown[:MOST_UNKNOWN]))
    wrong += [f"unknown parameter '{key}'" for key in unknown[MOST_UNKNOWN:]]
    for key, value in known.items():
        if key in fields and isinstance(value, float) and 0.0 < abs(value) < LEAST:
            wrong.append(f"{key} = {value!r} is too close to zero: give 0.0, or a magnitude of at least {LEAST:g}")
    try:
        return model.model_validate(nest({key: value for key, value in known.items() if key in fields})), wrong
    except ValidationError as error:
        return None, wrong + sentences(error, model)


def _groups(model: type[Group]) -> set[str]:
    """Return the dotted names of a model's groups."""
    return {".".join(parts[:end]) for parts in (key.split(".") for key in fields_by_key(model)) for end in range(1, len(parts))}


def _without_empty_groups(flat: Mapping[str, Any], model: type[Group]) -> dict[str, Any]:
    """Return parameters without the groups that a file gives as ``{}``."""
    groups = _groups(model) if any(map(_is_empty, flat.values())) else ()
    return {key: value for key, value in flat.items() if not (_is_empty(value) and key in groups)}


def _is_empty(value: object) -> bool:
    return isinstance(value, Mapping) and not value


def unknown_parameter(key: str, model: type[Group] = Configuration, value: object = None) -> str:
    """Return a sentence about a key that is no parameter of a model: what it is instead, or what may be meant."""
    fields, groups = fields_by_key(model), _groups(model)
    if key in groups:
        example = next(known for known in fields if known.startswith(f"{key}."))
        return f"{key} is a group of parameters: give them below it, such as {example}, or leave it out"
    if model is Configuration and (group := key.partition(".")[0]) in VEHICLE_GROUPS:
        return f"the group '{group}' belongs to a vehicle: give its file with --vehicle, in a sweep with the key vehicle"
    if model is Configuration and (speed := _in_other_unit(key, value)):
        return f"unknown parameter '{key}'{speed}"
    alike = [group for group in groups if len(group.split(".")) == len(key.split("."))]
    return f"unknown parameter '{key}'{nearest(key, alike, GOOD_LIKENESS) or nearest_key(key, fields)}"


def _in_other_unit(key: str, value: object) -> str:
    """Return how to give a speed that an unknown key such as ``rpm`` or ``speed_hz`` names in another unit, or an empty string."""
    unit = key.lower().rpartition(".")[2].removeprefix("speed_")
    if unit not in OTHER_UNITS:
        return ""
    number = float(value) if isinstance(value, (int, float)) and abs(value) < sys.float_info.max and not isinstance(value, bool) else 1.0
    return f"; speeds are in rad/s: {number:g} {unit.replace('hz', 'Hz')} is {SPEED}={number * OTHER_UNITS[unit]:.6g}"


def read_parameters(path: Path, node: str, *, of_ros: bool = False) -> dict[str, Any]:
    """Return the parameters of a file for a node of the bench by their dotted keys: plain groups, or those of a ROS parameter file.

    With ``of_ros``, those that every node of ROS has are included.

    Raises:
        Refusal: the file cannot be read, is not YAML, has no parameters for the node, or has something that no node reads.
    """
    flat, wrong = _read(path, node, of_ros=of_ros)
    if wrong:
        raise Refusal(f"{path}: {wrong[0]}{more(len(wrong))}")
    return flat


def _read(path: Path, node: str, *, of_ros: bool = False) -> tuple[dict[str, Any], list[str]]:
    """Return the parameters of a file, and a sentence for everything that no node reads and for each key that occurs twice."""
    flat: dict[str, Any] = {}
    trees, wrong = read_sections(read_yaml(path), node, of_ros=of_ros)
    for tree in trees:
        parameters, twice = _flattened(tree)
        flat.update(parameters)
        wrong += twice
    return flat, wrong


def _settings(settings: Sequence[str], fields: Mapping[str, ParameterField]) -> dict[str, Any]:
    """Return parameters given as texts, KEY=VALUE."""
    flat: dict[str, Any] = {}
    for setting in settings:
        if not isinstance(setting, str):
            raise Refusal(f"setting {setting!r} is not a text: write KEY=VALUE, such as operating.speed=125.664")
        key, equals, text = setting.partition("=")
        if not equals:
            raise Refusal(f"setting '{setting}': write KEY=VALUE, such as operating.speed=125.664")
        known = fields.get(key)
        try:
            value = parsed(text)
        except yaml.YAMLError:
            raise Refusal(f"setting '{setting}': the value is not a plain number or text") from None
        if _is_empty(value) and not known:
            raise Refusal(f"setting '{setting}': {unknown_parameter(key)}")
        if known and known.kind is str and type(value) is not str:
            value = text
        flat[key] = float(value) if known and known.kind is float and type(value) is int else value
    return flat


def layered(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters with dotted keys after changes ``above`` them: a speed in one form replaces one in the other."""
    replaced_form = SPEED if above.get(SPEED_KMH) else SPEED_KMH if SPEED in above else ""
    return {**{key: value for key, value in below.items() if key != replaced_form}, **above}


def overlaid(whole: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return all parameters of a configuration with dotted keys after changes.

    A new preset of the sensor among them also changes its typical values, and a speed in one form replaces one in the other: the values are
    those that run.
    """
    preset = changes.get("sensor.preset")
    brought = preset_values(str(preset)) if preset not in (None, whole.get("sensor.preset")) else {}
    parameters = {**whole, **brought, **changes}
    if SPEED in changes:
        return {**parameters, SPEED_KMH: changes.get(SPEED_KMH, 0.0)}
    speed = converted(parameters.get(SPEED_KMH), parameters.get(WHEEL_DIAMETER))
    return parameters if speed is None else {**parameters, SPEED: speed, SPEED_KMH: 0.0}


def changed(configuration: Configuration, changes: Mapping[str, Any], source: str) -> Configuration:
    """Return a configuration with changes to dotted keys; all of it is checked, since parameters depend on each other.

    Raises:
        Refusal: see `validated`.
    """
    return validated(overlaid(flatten(configuration.model_dump()), changes), Configuration, source)


def load_configuration(source: Configuration | str | Path, settings: Mapping[str, Any] | Sequence[str] | str = ()) -> Configuration:
    """Return the configuration of a file or a shipped name, with some settings changed.

    Parameters
    ----------
    source
        The name of a shipped configuration (``"healthy"``), a YAML file, or a configuration to change.
    settings
        Parameters and values: ``{"operating.speed": 100.0}``, nested or with dotted keys, or texts such as
        ``"operating.speed=100.0"``, one or several; of several for one parameter, the last one counts.

    Raises
    ------
    Refusal
        No such file, an unknown parameter, or a value that is out of range or does not fit the others.

    Examples
    --------
    >>> load_configuration("healthy", {"faults": {"outer_1": {"width": 0.002}}, "operating.speed": 100.0})
    <Configuration: 100 rad/s (954.9 rpm), 100 kN, outer_1: 2 mm wide>
    """
    if isinstance(source, Configuration):
        return changed(source, asked, "settings") if (asked := settings_by_key(settings)) else source
    flat, wrong = layers(source, settings)
    if wrong:
        raise Refusal(f"{source}: {wrong[0]}{more(len(wrong))}")
    return validated(flat, Configuration, str(source))


def layers(source: str | Path, settings: Mapping[str, Any] | Sequence[str] | str = ()) -> tuple[dict[str, Any], list[str]]:
    """Return the parameters of a file or a shipped name with settings on top by their dotted keys, unchecked; see `load_configuration`.

    The second value is a sentence for everything in the file that no node reads.

    Raises:
        Refusal: no such file, or a setting cannot be read.
    """
    if not isinstance(source, (str, Path)):
        raise Refusal(f"{source!r} is not a configuration: give a shipped name such as 'healthy', a YAML file or a Configuration")
    asked = settings_by_key(settings)
    path = find_configuration(source)
    flat, wrong = _read(path, "simulator")
    return layered(flat, asked), wrong


def settings_by_key(settings: Mapping[str, Any] | Sequence[str] | str) -> dict[str, Any]:
    """Return settings by their dotted keys, with the scalars of numpy as those of Python.

    Raises:
        Refusal: a setting cannot be read.
    """
    if not isinstance(settings, (Mapping, Iterable)):
        raise Refusal(f"settings = {settings!r} is neither a mapping nor texts: write {{'operating.speed': 100.0}}")
    if not isinstance(settings, Mapping):
        return _settings((settings,) if isinstance(settings, str) else settings, fields_by_key())
    return {str(key): value.item() if isinstance(value, np.generic) else value for key, value in flatten(settings).items()}


def to_yaml(configuration: Group) -> str:
    """Return a configuration as a ROS parameter file that contains every parameter."""
    return yaml_text({"/**": {"ros__parameters": configuration.model_dump()}})


def to_described_yaml(configuration: Group) -> str:
    """Return a configuration as a ROS parameter file that contains every parameter, with units as comments."""
    lines, values = ["/**:", "  ros__parameters:"], flatten(configuration.model_dump())
    before: tuple[str, ...] = ()
    for field in parameter_fields(type(configuration)):
        *groups, name = field.key.split(".")
        same = next((k for k, (a, b) in enumerate(zip(groups, before, strict=False)) if a != b), min(len(groups), len(before)))
        lines += [f"{'  ' * (k + 2)}{groups[k]}:" for k in range(same, len(groups))]
        unit = f"  # {field.unit}" if field.unit != "-" else ""
        text = yaml_text({name: values[field.key]}, width=math.inf).rstrip("\n")
        lines.append(textwrap.indent(text, "  " * (len(groups) + 2)) + unit)
        before = tuple(groups)
    return "\n".join(lines) + "\n"
