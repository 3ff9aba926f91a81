"""Configurations as files: reading, writing and checking YAML in the form of a ROS parameter file, and the table of parameters."""

from __future__ import annotations

import itertools
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import yaml
from pydantic import ValidationError

from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import ParameterField, field_of, more, sentence
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.sensor import preset_values
from dcrb_ros.settings.vehicle_speed import without_replaced
from dcrb_ros.settings.yaml import parsed, read_yaml

LEAST = sys.float_info.min
"""Smallest magnitude of a number other than zero: quotients of smaller numbers overflow."""

COMMANDED = ("operating.speed", "operating.load", "operating.lateral_load")
"""Parameters that are changed on a topic of their own."""

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
    """Return a nested mapping with dotted keys."""
    flat: dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, Mapping):
            flat.update(flatten(value, f"{prefix}{name}."))
        else:
            flat[f"{prefix}{name}"] = value
    return flat


def nest(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mapping with dotted keys as a tree."""
    tree: dict[str, Any] = {}
    for key, value in flat.items():
        *groups, name = key.split(".")
        branch = tree
        for group in groups:
            branch = branch.setdefault(group, {})
        branch[name] = value
    return tree


def validated(flat: Mapping[str, Any], model: type[Model], source: str) -> Model:
    """Return the model of parameters with dotted keys.

    Raises:
        Refusal: an unknown key, a value of the wrong type or out of range, or values that contradict each other; one sentence with the
            value, the range and the remedy.
    """
    fields = fields_by_key(model)
    unknown = [key for key in flat if key not in fields]
    if unknown:
        raise Refusal(f"{source}: unknown parameter '{unknown[0]}'{nearest(unknown[0], fields)}{more(len(unknown))}")
    for key, value in flat.items():
        if isinstance(value, float) and 0.0 < abs(value) < LEAST:
            raise Refusal(f"{source}: {key} = {value!r} is too close to zero: give 0.0, or a magnitude of at least {LEAST:g}")
    try:
        return model.model_validate(nest(flat))
    except ValidationError as error:
        raise Refusal(f"{source}: {sentence(error, model)}") from None


def read_parameters(path: Path, node: str) -> dict[str, Any]:
    """Return the parameters of a ROS parameter file for a node by their dotted keys: those of ``/**``, then those of its own section.

    Raises:
        Refusal: the file cannot be read, is not YAML or does not have the form of a ROS parameter file.
    """
    tree = read_yaml(path)
    if not isinstance(tree, Mapping) or not all(isinstance(section, Mapping) for section in tree.values()):
        raise Refusal(f"{path} is not a ROS parameter file; it must begin with '/**:' and 'ros__parameters:'")
    flat: dict[str, Any] = {}
    for name in ("/**", node, f"/{node}", f"/dcrb/{node}", f"/**/{node}"):
        section = tree.get(name, {})
        if section and (set(section) != {"ros__parameters"} or not isinstance(section["ros__parameters"], Mapping)):
            raise Refusal(f"{path}: '{name}' must contain 'ros__parameters:' and nothing else")
        flat.update({str(key): value for key, value in flatten(section.get("ros__parameters", {})).items()})
    if not flat and not any(str(name).strip("/").split("/")[-1] for name in tree):
        raise Refusal(f"{path} contains no parameters for the node '{node}'; put them below '/**:' and 'ros__parameters:'")
    return flat


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
        if known and known.kind is str and type(value) is not str:
            value = text
        flat[key] = float(value) if known and known.kind is float and type(value) is int else value
    return flat


def overlaid(whole: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a configuration with dotted keys after changes; a new preset of the sensor among them also changes its typical values."""
    preset = changes.get("sensor.preset")
    brought = preset_values(str(preset)) if preset not in (None, whole.get("sensor.preset")) else {}
    return {**whole, **brought, **changes}


def load_configuration(source: Configuration | str | Path, settings: Mapping[str, Any] | Sequence[str] | str = ()) -> Configuration:
    """Return the configuration of a file or a shipped name, with some settings changed.

    Parameters
    ----------
    source
        The name of a shipped configuration (``"healthy"``), a YAML file, or a configuration to change.
    settings
        Parameters and values: ``{"operating.speed": 100.0}``, nested or with dotted keys, or texts such as
        ``"operating.speed=100.0"``, one or several.

    Raises
    ------
    Refusal
        No such file, an unknown parameter, or a value that is out of range or does not fit the others.

    Examples
    --------
    >>> load_configuration("healthy", {"faults": {"outer_1": {"width": 0.002}}, "operating.speed": 100.0})
    <Configuration: 100 rad/s (954.9 rpm), 100 kN, outer_1: 2 mm wide>
    """
    if not isinstance(source, (Configuration, str, Path)):
        raise Refusal(f"{source!r} is not a configuration: give a shipped name such as 'healthy', a YAML file or a Configuration")
    if not isinstance(settings, (Mapping, Iterable)):
        raise Refusal(f"settings = {settings!r} is neither a mapping nor texts: write {{'operating.speed': 100.0}}")
    if isinstance(settings, Mapping):
        asked = _plain(flatten(settings))
    else:
        asked = _settings((settings,) if isinstance(settings, str) else settings, fields_by_key())
    if isinstance(source, Configuration):
        return validated(overlaid(flatten(source.model_dump()), asked), Configuration, "settings") if asked else source
    flat = read_parameters(find_configuration(source), "simulator")
    return validated({**without_replaced(flat, asked), **asked}, Configuration, str(source))


def _plain(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings with the scalars of numpy as those of Python."""
    return {str(key): value.item() if isinstance(value, np.generic) else value for key, value in settings.items()}


def find_configuration(source: str | Path) -> Path:
    """Return the path of a configuration given as a file or by a shipped name."""
    path = Path(source)
    if path.is_file():
        return path
    shipped = shipped_configurations()
    name = path.stem if path.suffix in (".yaml", ".yml") and path.parent.name in ("", "config") else str(source)
    if name in shipped and not path.exists():
        return shipped[name]
    raise Refusal(f"there is no configuration '{source}': give a YAML file or one of {', '.join(shipped)}{nearest(str(source), shipped)}")


def shipped_folder() -> Path:
    """Return the folder of the shipped configurations: in the repository, or in the share folder of the installation."""
    package = Path(__file__).resolve().parents[1]
    candidates = [package.parent / "config", *(parent / "share" / "dcrb_ros" / "config" for parent in package.parents)]
    candidates.append(Path(sys.prefix) / "share" / "dcrb_ros" / "config")
    return next((folder for folder in candidates if (folder / "healthy.yaml").is_file()), candidates[0])


def shipped_configurations() -> dict[str, Path]:
    """Return the files of the shipped configurations by name."""
    return {path.stem: path for path in sorted(shipped_folder().glob("*.yaml")) if path.stem != "detector"}


def to_yaml(configuration: Group) -> str:
    """Return a configuration as a ROS parameter file that contains every parameter."""
    return str(yaml.safe_dump({"/**": {"ros__parameters": configuration.model_dump()}}, sort_keys=False))


UNIT_SIGNS = (("^2", "²"), ("sqrt(Hz)", "√Hz"), ("ug/", "µg/"))
"""Units as the schema writes them, and as the documentation does."""


def parameter_table(model: type[Group] = Configuration) -> str:
    """Return the parameters as Markdown: a table per group, with name, range and unit in one column, default and meaning."""
    lines: list[str] = []
    for group, fields in itertools.groupby(parameter_fields(model), lambda field: field.key.partition(".")[0] if "." in field.key else ""):
        if group or lines:
            lines += ["", f"### {group or 'no group'}", ""]
        lines += ["| parameter, range, unit | default | meaning |", "|---|---|---|"]
        lines += [_row(field) for field in fields]
    return "\n".join(lines).strip()


def _row(field: ParameterField) -> str:
    """Return a parameter as a row of its table."""
    default = f"{field.default:.6g}" if isinstance(field.default, float) else str(field.default)
    return f"| `{field.key}`{_range(field)} | {default} | {field.description}{_symbol(field)}{_changeable(field)} |"


def _range(field: ParameterField) -> str:
    """Return the range and the unit of a parameter, or its choices, on a line of their own."""
    if field.choices:
        return f"<br>{', '.join(field.choices)}"
    if field.low is None or field.high is None:
        return ""
    unit = field.unit if field.unit != "-" else ""
    for plain, sign in UNIT_SIGNS:
        unit = unit.replace(plain, sign)
    return f"<br>{' to '.join(field.limits)} {unit}".rstrip()


def _symbol(field: ParameterField) -> str:
    """Return the symbol of a parameter as a formula; a Greek letter is spelt out in the schema."""
    return f", ${re.sub('^([a-z]{2,})', lambda name: chr(92) + name[1], field.symbol)}$" if field.symbol else ""


def _changeable(field: ParameterField) -> str:
    """Return a remark on a parameter that can change at run time."""
    return "" if not field.run_time else ". *Changes by command.*" if field.key in COMMANDED else ". *Changes at run time.*"
