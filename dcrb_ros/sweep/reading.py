"""Reading a sweep file: every key and value checked once, refused in one sentence."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from dcrb_ros.runtime.refusal import Refusal, nearest
from dcrb_ros.settings.files import (
    ParameterField,
    fields_by_key,
    find_configuration,
    flatten,
    load_configuration,
    overlaid,
    shipped_folder,
)
from dcrb_ros.settings.vehicle_speed import SPEED, SPEED_KMH
from dcrb_ros.settings.yaml import read_yaml
from dcrb_ros.simulation.scenario import read_scenario_file
from dcrb_ros.sweep.design import GRID, Axes, Axis, Choice, Span, Value
from dcrb_ros.sweep.sweep_file import SCENARIO, SOUND, Shares, Sweep, SweepFile, Windows

CASE_GROUPS = ("faults", "background", "sensor")
"""What a case may set: what is wrong. All else is a condition of the bearing."""
HEALTHY = "healthy"
LONGEST = 600.0
"""Longest run whose waveform is held in memory [s]: at 51.2 kHz 370 MB."""
MOST_VALUES = 10_000
SHORTEST_SETTLE = 0.005
"""Least time between a branch and the first recorded sample [s]: the filter's memory and more."""


def read_sweep(source: str | Path) -> Sweep:
    """Return a sweep, a file or a shipped name.

    Raises:
        Refusal: an unknown key, a value out of range, an empty design, or values that cannot be true together.
    """
    path = found_sweep(source)
    tree = read_yaml(path)
    if not isinstance(tree, Mapping):
        raise Refusal(f"{path} is not a sweep: it must hold keys such as 'base:', 'vary:', 'cases:' and 'duration:'")
    return sweep_of({str(key): value for key, value in tree.items()}, str(path), path.parent, path.read_text(encoding="utf-8"))


def found_sweep(source: str | Path) -> Path:
    """Return the path of a sweep given as a file or by a shipped name."""
    shipped = {path.stem: path for path in sorted((shipped_folder() / "sweeps").glob("*.yaml"))}
    path = Path(source)
    if not path.is_file() and str(source) not in shipped:
        raise Refusal(f"there is no sweep '{source}': give a YAML file or one of {', '.join(shipped)}{nearest(str(source), shipped)}")
    return path if path.is_file() else shipped[str(source)]


GAPS = ("publishing.loss_probability", "publishing.burst_period")
"""Parameters that leave blocks out."""


def sweep_of(tree: Mapping[str, Any], source: str, folder: Path = Path(), text: str = "") -> Sweep:
    """Return the sweep of a file as YAML gives it; names of other files count from ``folder``, too."""
    file = _file(tree, source)
    fields = fields_by_key()
    fixed = {key: _value(key, value, _known(key, fields, f"{source}: set"), f"{source}: set") for key, value in flatten(file.fixed).items()}
    base = overlaid(flatten(load_configuration(_beside(file.base, folder)).model_dump()), fixed)
    vary = _axes(file.vary, file.design, fields, f"{source}: vary")
    cases = {name: _axes(case, file.design, fields, f"{source}: cases.{name}") for name, case in file.cases.items()} or {"base": {}}
    if file.twins:
        if cases.get(HEALTHY):
            raise Refusal(f"{source}: with twins the case '{HEALTHY}' is the twin of all others and must be empty: rename this one")
        cases = {HEALTHY: {key: Choice((value,)) for key, value in SOUND.items()}, **{k: v for k, v in cases.items() if k != HEALTHY}}
    sweep = Sweep(file, text, base, vary, cases, _stories([vary, *cases.values()], folder))
    _consistent(sweep, fields, source)
    return sweep


def _file(tree: Mapping[str, Any], source: str) -> SweepFile:
    known = [info.alias or name for name, info in SweepFile.model_fields.items()]
    for key in tree:
        if key not in known:
            raise Refusal(f"{source}: unknown key '{key}'{nearest(key, known)}; a sweep has {', '.join(known)}")
    try:
        return SweepFile.model_validate(tree)
    except ValidationError as error:
        raise Refusal(f"{source}: {_sentence(error.errors()[0])}") from None


def _sentence(problem: ErrorDetails) -> str:
    key = ".".join(str(part) for part in problem["loc"] if part not in ("int", "list[int]"))
    if problem["type"] == "missing":
        return f"'{key}' is missing" + (": the seconds to record of each run" if key == "duration" else "")
    if problem["type"] == "extra_forbidden":
        known = list(Windows.model_fields if problem["loc"][0] == "windows" else Shares.model_fields)
        return f"unknown key '{key}'{nearest(str(problem['loc'][-1]), known)}; there are {', '.join(known)}"
    said = problem["msg"].removeprefix("Value error, ").removeprefix("Input ").lower()
    return f"{key}: {said}" if problem["type"] == "value_error" else f"{key} = {problem['input']!r}: it {said}"


def _known(key: str, fields: Mapping[str, ParameterField], source: str) -> ParameterField:
    if key not in fields:
        raise Refusal(f"{source}: unknown parameter '{key}'{nearest(key, fields)}")
    if key == "simulation.seed":
        raise Refusal(f"{source}: simulation.seed is given by 'seeds': a count, or a list such as [1, 2]")
    return fields[key]


def _value(key: str, given: Any, field: ParameterField, source: str) -> Value:
    """Return a value of the type that its parameter has, within its range."""
    value: Any = float(given) if field.kind is float and type(given) is int else given
    if type(value) is not field.kind:
        raise Refusal(f"{source}: {key} = {value!r} is not {_KINDS[field.kind]}; {field.description.lower()}")
    if field.choices and value not in field.choices:
        raise Refusal(f"{source}: {key} = {value!r} is not one of {', '.join(field.choices)}{nearest(str(value), field.choices)}")
    if field.low is not None and field.high is not None and not field.low <= given <= field.high:
        remedy = field.remedy or f"{field.description.lower()} lies within it"
        raise Refusal(f"{source}: {key} = {value!r} is outside {field.low:g} .. {field.high:g} {field.unit}: {remedy}")
    return cast(Value, value)


_KINDS = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}


def _axes(tree: Mapping[str, Any], design: str, fields: Mapping[str, ParameterField], source: str) -> Axes:
    axes: dict[str, Axis] = {}
    for key, value in _opened(tree).items():
        if key == SCENARIO:
            axes[key] = _choice(key, value, None, source)
        elif isinstance(value, Mapping):
            axes[key] = _span(key, value, _known(key, fields, source), design, source)
        else:
            axes[key] = _choice(key, value, _known(key, fields, source), source)
    return axes


def _opened(tree: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return a tree with dotted keys, ranges left whole."""
    flat: dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, Mapping) and not {"low", "high"} & set(value):
            flat.update(_opened(value, f"{prefix}{name}."))
        else:
            flat[f"{prefix}{name}"] = value
    return flat


def _choice(key: str, value: Any, field: ParameterField | None, source: str) -> Choice:
    values = value if isinstance(value, list) else [value]
    if not values:
        raise Refusal(f"{source}: {key} has no value, so there would be no run: give at least one, or leave the key out")
    if len(values) > MOST_VALUES:
        raise Refusal(f"{source}: {key} has {len(values)} values; {MOST_VALUES} at most, or a range")
    if field is None:
        for name in values:
            if not isinstance(name, str):
                raise Refusal(f"{source}: {key} = {name!r} is not the name of a scenario; an empty text means none")
        return Choice(tuple(values))
    return Choice(tuple(_value(key, one, field, source) for one in values))


def _span(key: str, tree: Mapping[str, Any], field: ParameterField, design: str, source: str) -> Span:
    known = ("low", "high", "scale", "count")
    for name in tree:
        if name not in known:
            raise Refusal(f"{source}: {key}: unknown key '{name}'{nearest(str(name), known)}; a range has {', '.join(known)}")
    if not {"low", "high"} <= set(tree) or field.kind not in (int, float):
        raise Refusal(f"{source}: {key}: a range needs low and high, and a parameter that is a number")
    low, high = (_value(f"{key} ({end})", tree[end], field, source) for end in ("low", "high"))
    scale, count = tree.get("scale", "linear"), tree.get("count", 0)
    if scale not in ("linear", "log"):
        raise Refusal(f"{source}: {key}: scale = {scale!r} is not one of linear, log")
    if not float(low) < float(high):
        raise Refusal(f"{source}: {key}: low = {low!r} is not below high = {high!r}: swap them, or give a list of values")
    if scale == "log" and not float(low) > 0.0:
        raise Refusal(f"{source}: {key}: low = {low!r} is not above 0, where a logarithmic scale begins")
    if type(count) is not int or (design == GRID and not 1 <= count <= MOST_VALUES):
        raise Refusal(f"{source}: {key}: a grid needs the count of values in a range, 1 .. {MOST_VALUES}; it is {count!r}")
    return Span(float(low), float(high), scale == "log", field.kind is int, count)


def _beside(name: str, folder: Path) -> Path:
    """Return the configuration of a sweep: beside its file, or as any command finds it."""
    beside = folder / name
    return beside if beside.is_file() else find_configuration(name)


def _stories(all_axes: list[Axes], folder: Path) -> dict[str, Any]:
    """Return the scenarios that axes name, as YAML gives them."""
    names = {str(name) for axes in all_axes if SCENARIO in axes for name in axes[SCENARIO].grid() if name}
    return {name: read_scenario_file(folder / name if (folder / name).is_file() else Path(name)) for name in sorted(names)}


def _consistent(sweep: Sweep, fields: Mapping[str, ParameterField], source: str) -> None:
    """Refuse what cannot be true together."""
    file = sweep.file
    if file.design == GRID and file.points:
        raise Refusal(f"{source}: points = {file.points} is for a random or latin_hypercube design; a grid has as many as its values make")
    if file.design != GRID and not file.points:
        raise Refusal(f"{source}: a {file.design} design needs 'points', the number of its conditions, above 0")
    seeds = [file.seeds] if isinstance(file.seeds, int) else file.seeds
    if not seeds or min(seeds) < (1 if isinstance(file.seeds, int) else 0) or max(seeds) > 2**31 - 1:
        raise Refusal(f"{source}: seeds = {file.seeds!r}: give how many each condition has, from 1 up, or a list such as [1, 2]")
    for name, axes in sweep.cases.items():
        for key in axes:
            if key != SCENARIO and key.split(".")[0] not in CASE_GROUPS:
                raise Refusal(f"{source}: cases.{name}: {key} is a condition of the bearing and belongs under 'vary'")
    if file.twins and SCENARIO in sweep.vary:
        _twins(sweep, source)
    if file.branch_at:
        _branching(sweep, fields, source)
    held = file.output != "bag" or file.windows is not None
    if held and file.duration > LONGEST:
        raise Refusal(
            f"{source}: duration = {file.duration:g} s is above {LONGEST:g} s, too long for memory: take 'output: bag' and no windows"
        )
    if SPEED_KMH in flatten(file.fixed) and SPEED in sweep.vary:
        raise Refusal(f"{source}: set: {SPEED_KMH} would win over {SPEED} under 'vary': give one of them")
    gaps = [key for key in GAPS if sweep.base[key] or key in sweep.vary]
    if held and gaps:
        raise Refusal(
            f"{source}: {gaps[0]} leaves gaps, which waveform files and windows have no place for: take 'output: bag' and no windows"
        )
    rate = sweep.base["sensor.sampling_rate"]
    if file.windows is not None and "sensor.sampling_rate" not in sweep.vary and file.windows.length > file.duration * float(rate):
        raise Refusal(
            f"{source}: windows.length = {file.windows.length} samples is longer than a run of {file.duration:g} s, "
            f"{round(file.duration * float(rate))} samples at {rate} Hz: make the window shorter or the run longer"
        )


def _twins(sweep: Sweep, source: str) -> None:
    """Refuse scenarios of a condition that would make its healthy twin a faulty one."""
    for name in sweep.vary[SCENARIO].grid():
        if "faults." in json.dumps(sweep.stories.get(str(name))) or "'faults'" in str(sweep.stories.get(str(name))):
            raise Refusal(f"{source}: vary: the scenario '{name}' brings faults, so a twin would not be healthy: put it into a case")


def _branching(sweep: Sweep, fields: Mapping[str, ParameterField], source: str) -> None:
    if sweep.stories:
        raise Refusal(f"{source}: branch_at and a scenario do not go together, whose times count from the start: leave one out")
    if sweep.file.settle < SHORTEST_SETTLE:
        raise Refusal(
            f"{source}: settle = {sweep.file.settle:g} s is below {SHORTEST_SETTLE:g} s, within which what is wrong appears after branch_at"
        )
    for name, axes in sweep.cases.items():
        for key in axes:
            if key != SCENARIO and not fields[key].run_time:
                raise Refusal(f"{source}: cases.{name}: {key} cannot change as the bearing turns: set branch_at to 0")
